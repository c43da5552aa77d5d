"""Measuring in turns: what is compared runs one after the other and again, so that a busy machine slows all alike."""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from grind_env.arrays import Array
from tests.speed_envs import rounds

Ratios: TypeAlias = dict[str, Array]
"""By name: a ratio a round."""


def in_turns(sides: Mapping[str, Callable[[], float]], seconds: float) -> dict[str, Array]:
    """What each side gives, in turns for about so many s: a number a round, after one that does not count."""
    for measure in sides.values():
        measure()
    found: dict[str, list[float]] = {name: [] for name in sides}
    for _ in rounds(time.perf_counter() + seconds):
        for name, measure in sides.items():
            found[name].append(measure())
    return {name: np.array(values) for name, values in found.items()}


def over(one: Sequence[float] | Array, other: Sequence[float] | Array) -> Array:
    """One over the other round by round, of as many rounds as both have."""
    count = min(len(one), len(other))
    return np.asarray(one[:count]) / np.asarray(other[:count])
