"""Measuring in turns: compared functions run in alternation, so that a busy machine slows all of them equally."""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from grind_env.array_types import Array
from tests.speed_envs import rounds

Ratios: TypeAlias = dict[str, Array]  #: ratios by name, one value per round


def in_turns(sides: Mapping[str, Callable[[], float]], seconds: float) -> dict[str, Array]:
    """Call the functions in turns for about `seconds`; return their values, one per round, after a warm-up call."""
    for measure in sides.values():
        measure()
    found: dict[str, list[float]] = {name: [] for name in sides}
    for _ in rounds(time.perf_counter() + seconds):
        for name, measure in sides.items():
            found[name].append(measure())
    return {name: np.array(values) for name, values in found.items()}


def over(one: Sequence[float] | Array, other: Sequence[float] | Array) -> Array:
    """Return the ratio of two series round by round, for the rounds that both have."""
    count = min(len(one), len(other))
    return np.asarray(one[:count]) / np.asarray(other[:count])
