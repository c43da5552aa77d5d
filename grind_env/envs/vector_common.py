"""What all vector environments share: seeds, masks, autoreset, pictures and the masks of the info."""

from collections.abc import Iterable, Sequence
from typing import Any, TypeGuard

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode

from grind_env.arrays import Array
from grind_env.envs.arguments import check_steps
from grind_env.envs.contexts import option_items
from grind_env.envs.tasks import TaskError
from grind_env.errors import GrindError
from grind_env.render import ansi, frames
from grind_env.render.view import EpisodePicture

VECTOR_RENDER_MODES = ("rgb_array", "ansi")


def vector_metadata(mode: AutoresetMode) -> dict[str, Any]:
    """What a vector environment in an autoreset mode says of itself."""
    return {"render_modes": [*VECTOR_RENDER_MODES], "render_fps": frames.FPS, "autoreset_mode": mode}


def drawn_all(render_mode: str | None, begun: Array, views: Iterable[EpisodePicture]) -> tuple[Any, ...] | None:
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


class StepLimit:
    """Cuts the episodes of N sub-environments short, as `gymnasium.wrappers.TimeLimit` does those of a single one.

    Args:
        max_episode_steps: steps after which an episode is truncated; None for never.
        num_envs: number of sub-environments.

    Raises:
        TaskError: if the steps are no whole number of at least 1.
    """

    def __init__(self, max_episode_steps: int | None, num_envs: int) -> None:
        self.most = check_steps(max_episode_steps)
        self.steps = np.zeros(num_envs, np.int64)

    def restart(self, mask: Array) -> None:
        """The episodes in `mask`, shape (num_envs,), begin."""
        self.steps[mask] = 0

    def step(self, stepping: Array) -> Array:
        """Count a step of those in `stepping`, a mask or indices; which episodes are cut short, a new bool array."""
        if self.most is None:
            return np.zeros(len(self.steps), bool)
        self.steps[stepping] += 1
        return np.asarray(self.steps >= self.most)


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


def final_info(info: dict[str, Any], observations: Array, over: Array) -> dict[str, Any]:
    """The vector info of a step in mode `"SameStep"`: what belongs to the episodes that it ended is set apart.

    Args:
        info: of the step.
        observations: last ones of the episodes, shape (num_envs, entries).
        over: which are over, bool of shape (num_envs,), one of them at least.
    """
    final_obs = np.full(len(over), None, object)
    for i in np.flatnonzero(over):
        final_obs[i] = observations[i].copy()
    moved = {
        "final_obs": final_obs,
        "_final_obs": over.copy(),
        "final_info": masked(info, over),
        "_final_info": over.copy(),
    }
    return {**moved, **masked(info, ~over)} if not over.all() else moved


def refuse_out_of_turn(all_begun: bool, over: Array, mode: AutoresetMode) -> None:
    """Refuse a step that some sub-environment cannot make.

    Args:
        all_begun: whether all of them have begun.
        over: whose episodes are over, bool of shape (num_envs,).
        mode: the autoreset mode.

    Raises:
        gymnasium.error.ResetNeeded: some have not begun; without autoreset, the episode of one is over.
    """
    if not all_begun:
        raise gym.error.ResetNeeded("some sub-environments have not begun: call reset() before step()")
    if mode == AutoresetMode.DISABLED and over.any():
        raise gym.error.ResetNeeded(
            f"episode {np.flatnonzero(over)[0]} is over: reset it with options={{'reset_mask': ...}}"
        )


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
    given: Any = seed
    if isinstance(given, np.ndarray):
        given = given.tolist()
    if _is_seed(given):
        return [int(given) + i for i in range(num_envs)]
    if isinstance(given, list | tuple) and len(given) == num_envs:
        numbers = [each if each is None else int(each) for each in given if each is None or _is_seed(each)]
        if len(numbers) == num_envs:
            return numbers
    raise GrindError(f"seed is {seed!r}, but must be one int of at least 0, or a list of {num_envs}, one for each env")


class Generators:
    """A random generator for each of N sub-environments, and the seed of each; chosen anew until a reset gives one."""

    def __init__(self, num_envs: int) -> None:
        self.rngs: list[np.random.Generator] = []
        self.seeds: list[int] = []
        for _ in range(num_envs):
            rng, seed = seeding.np_random()
            self.rngs.append(rng)
            self.seeds.append(seed)

    def reseed(self, seed: int | Sequence[int | None] | None, mask: Array) -> None:
        """Put new generators in the place of those in `mask` that a reset gives a seed; see `seed_list`.

        Raises:
            GrindError: if the seeds do not fit the sub-environments; none is then changed.
        """
        for i, each in enumerate(seed_list(seed, len(self.rngs))):
            if mask[i] and each is not None:
                self.rngs[i], self.seeds[i] = seeding.np_random(each)


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
