"""The cases of `grind/Wen-v0`: which one an episode draws, and how it is observed."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces

from grind_env.arrays import Array
from grind_env.envs.contexts import ContextError, option_items
from grind_env.envs.observations import Reading
from grind_env.envs.wen.model import CASES


def draw_case(rng: np.random.Generator, fixed: int | None) -> int:
    """Number of the case of an episode; both are equally likely unless one is fixed."""
    drawn = int(rng.integers(len(CASES)))
    return drawn if fixed is None else fixed


def read_case(options: Mapping[str, Any] | None, before: int | None) -> int | None:
    """Number of the case that the options of a reset fix; None if it is drawn, and `before` if they do not say.

    Raises:
        ContextError: if they are not `{"context": {"case": name}}`, with `{}` or None for no context.
    """
    case = before
    for option, context in option_items(options):
        if option != "context":
            raise ContextError(f"there is no reset option {option!r} in grind/Wen-v0; legal is context")
        if context is not None and (not isinstance(context, Mapping) or set(context) - {"case"}):
            raise ContextError(f"context is {context!r}, but must be a dict with the key case, or None")
        name = (context or {}).get("case")
        if name is not None and (not isinstance(name, str) or name not in CASES):
            raise ContextError(f"case is {name!r}, but must be one of {', '.join(CASES)}")
        case = None if name is None else list(CASES).index(name)
    return case


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
