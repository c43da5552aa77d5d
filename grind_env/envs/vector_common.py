"""What all vector environments share: seeds, masks, autoreset modes, pictures and the masks of the info."""

from collections.abc import Iterable, Sequence
from typing import Any, TypeGuard

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from grind_env.envs.contexts import option_items
from grind_env.envs.tasks import TaskError
from grind_env.errors import GrindError
from grind_env.render import ansi, frames
from grind_env.render.sheet import Sheet
from grind_env.render.view import View

Array = NDArray[Any]

VECTOR_RENDER_MODES = ("rgb_array", "ansi")


def vector_metadata(mode: AutoresetMode) -> dict[str, Any]:
    """What a vector environment in an autoreset mode says of itself."""
    return {"render_modes": [*VECTOR_RENDER_MODES], "render_fps": frames.FPS, "autoreset_mode": mode}


def drawn_all(render_mode: str | None, begun: Array, views: Iterable[View | Sheet]) -> tuple[Any, ...] | None:
    """A picture or a text of every sub-environment; None, with a warning, without a render mode.

    Args:
        render_mode: one of `VECTOR_RENDER_MODES`, or None.
        begun: which sub-environments have begun, bool of shape (num_envs,).
        views: what the pictures show.

    Raises:
        gymnasium.error.ResetNeeded: some have not begun.
        RenderError: what draws them is not installed.
    """
    if render_mode is None:
        gym.logger.warn("render() shows nothing: make the env with render_mode='rgb_array' or 'ansi'")
        return None
    if not begun.all():
        raise gym.error.ResetNeeded("there is nothing to show yet: call reset() before render()")
    draw = ansi.panel if render_mode == "ansi" else frames.render
    return tuple(draw(view) for view in views)


def masked(info: dict[str, Any], mask: Array) -> dict[str, Any]:
    """The vector info of the sub-environments in `mask` alone."""
    chosen: dict[str, Any] = {}
    for name, value in info.items():
        if name.startswith("_"):
            chosen[name] = value & mask
        elif isinstance(value, dict):
            chosen[name] = masked(value, mask)
        else:
            chosen[name] = np.where(mask, value, np.zeros((), value.dtype) if value.dtype != object else None)
    return chosen


def autoreset(mode: AutoresetMode | str) -> AutoresetMode:
    """The autoreset mode of that name.

    Raises:
        TaskError: if there is none.
    """
    try:
        return AutoresetMode(mode)
    except ValueError:
        legal = ", ".join(repr(each.value) for each in AutoresetMode)
        raise TaskError(f"autoreset_mode is {mode!r}, but must be one of {legal}") from None


def seed_list(seed: int | Sequence[int | None] | None, num_envs: int) -> list[int | None]:
    """A seed for each sub-environment; None to go on with its generator.

    Raises:
        GrindError: if `seed` is neither an int, nor `num_envs` of them, nor None, or if one is below 0.
    """
    if seed is None:
        return [None] * num_envs
    if _is_seed(seed):
        return [int(seed) + i for i in range(num_envs)]
    if isinstance(seed, list | tuple | np.ndarray) and len(seed) == num_envs:
        numbers = [each if each is None else int(each) for each in seed if each is None or _is_seed(each)]
        if len(numbers) == num_envs:
            return numbers
    raise GrindError(f"seed is {seed!r}, but must be one int of at least 0, or a list of {num_envs}, one for each env")


def _is_seed(value: object) -> TypeGuard[int]:
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(value >= 0)


def reset_mask(options: dict[str, Any] | None, num_envs: int) -> Array:
    """The sub-environments to reset, bool of shape (num_envs,).

    Raises:
        GrindError: if the mask has another shape or dtype, or selects nothing, or if the options are no dict.
    """
    mask = dict(option_items(options)).get("reset_mask", np.ones(num_envs, bool))
    if not isinstance(mask, np.ndarray) or mask.dtype != bool or mask.shape != (num_envs,) or not mask.any():
        raise GrindError(f"reset_mask must be a bool array of shape ({num_envs},) with at least one True")
    return mask


def beside_mask(options: dict[str, Any] | None) -> dict[str, Any]:
    """The options of a reset but for the mask.

    Raises:
        ContextError: if they are no dict.
    """
    return {name: value for name, value in option_items(options) if name != "reset_mask"}
