"""The cases of `grind/Wen-v0`: which one an episode draws, and how it is observed."""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.envs.observations import Reading
from grind_env.process.wen import CASES

Array = NDArray[Any]


def draw_case(rng: np.random.Generator) -> int:
    """Number of the case of an episode; both are equally likely."""
    return int(rng.integers(len(CASES)))


def observation_space() -> spaces.Box[np.float32]:
    """The case, one-hot."""
    return spaces.Box(0.0, 1.0, (len(CASES),), np.float32)


def observed(cases: int | Array) -> Array:
    """Observations, shape (cases, entries), of cases given by number, shape (cases,); of one, shape (entries,)."""
    return np.asarray(np.eye(len(CASES), dtype=np.float32)[cases])


def observation_info() -> tuple[Reading, ...]:
    """Name and meaning of every entry of the observation."""
    return tuple(
        Reading(name, "", 0.0, 1.0, 0.0, 1.0, "exact", f"1 if the part is to be ground as in the {name} problem")
        for name in CASES
    )
