"""The native vector environment of every id whose actions are E and D: one call steps all sub-environments."""

import inspect
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeGuard

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from grind_env.array_types import Array
from grind_env.envs.actions import ActionCodec
from grind_env.envs.arguments import check_count, check_flags, check_render
from grind_env.envs.cost import Outcome
from grind_env.envs.env import EpisodeLength, GrindEnv
from grind_env.envs.infos import InfoWriter
from grind_env.envs.observations import Reading
from grind_env.envs.reset_options import Given, option_items, read_all_options, read_options, with_machines
from grind_env.envs.simulation import Simulation
from grind_env.envs.space_metadata import shown_space
from grind_env.envs.tasks import TaskError
from grind_env.envs.threaded_step import step_shared
from grind_env.errors import GrindError
from grind_env.render import frames, terminal_view

VECTOR_RENDER_MODES = ("rgb_array", "ansi")

REWARD = Outcome._fields.index("reward")


class GrindVectorEnv(EpisodeLength, VectorEnv[Array, Any, Array]):
    """Vector environment of N `GrindEnv`, with bitwise the numbers of `gymnasium.vector.SyncVectorEnv`.

    Sub-environment i has its own generator, seeded with `seed + i` or with entry i of a list of seeds.

    Args:
        simulation: as for `GrindEnv`.
        num_envs: number of sub-environments.
        show_block: put the text of the blocks that were run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        autoreset_mode: `AutoresetMode` or its value: `"NextStep"`, `"SameStep"` or `"Disabled"`.
        render_mode: `"rgb_array"` or `"ansi"`, for one picture or text of each sub-environment.
        max_episode_steps: steps after which an episode is truncated, as by `TimeLimit`; None for never.
        info: as for `GrindEnv`.
        threads: number of threads, which share the episodes; pays for some thousand episodes on idle cores.
        out_of_range: `"clip"` or `"raise"`, see `grind_env.envs.actions`.

    Raises:
        GrindError: an argument is not legal.
    """

    def __init__(
        self,
        simulation: Simulation,
        num_envs: int = 1,
        *,
        show_block: bool = False,
        action: str = "box",
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        info: str = "measured",
        threads: int = 1,
        out_of_range: str | None = None,
    ) -> None:
        check_flags(show_block=show_block)
        self.num_envs = num_envs = check_count("num_envs", num_envs)
        check_render(render_mode, VECTOR_RENDER_MODES)
        self.render_mode = render_mode
        self.autoreset_mode = _autoreset(autoreset_mode)
        self.metadata = {
            "render_modes": [*VECTOR_RENDER_MODES],
            "render_fps": frames.FPS,
            "autoreset_mode": self.autoreset_mode,
        }
        self.most_steps = max_episode_steps
        if max_episode_steps is not None:
            self.most_steps = check_count("max_episode_steps", max_episode_steps, ", or left out")
        self.steps = np.zeros(num_envs, np.int64)
        self.show_block = show_block
        self.task, self.simulation = simulation.task, simulation
        self.threads = check_count("threads", threads)
        if self.threads > 1 and not simulation.compiled:
            raise TaskError(f"threads is {threads}, but Python runs this program, in one thread: leave it out")
        self.codec = ActionCodec(self.task, action, predress=simulation.pre_dress, out_of_range=out_of_range)
        self.infos = InfoWriter(simulation, self.codec.names, info)
        self.single_action_space = self.codec.space
        self.single_observation_space = shown_space(self.simulation)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.rngs: list[np.random.Generator] = []
        self.seeds: list[int] = []
        for _ in range(num_envs):
            rng, seed = seeding.np_random()
            self.rngs.append(rng)
            self.seeds.append(seed)
        self.given = [Given()] * num_envs
        self.episodes = self.simulation.start(self.rngs, full_tape=False)
        self.begun = np.zeros(num_envs, bool)
        self.all_begun = False
        self.due = np.zeros(num_envs, bool)
        self.some_due = False
        self.everyone = np.arange(num_envs)
        self.blocks: list[list[Any]] = [[] for _ in range(num_envs)]  # blocks and outcomes of each, for pictures
        self.outcomes: list[list[Outcome]] = [[] for _ in range(num_envs)]
        self.last: tuple[Array, tuple[Array, ...]]  # outcomes and choice of the last step

    @property
    def np_random_seed(self) -> Any:
        """Return the seeds of the generators of all sub-environments, as in `SyncVectorEnv`."""
        return tuple(self.seeds)

    def observation_info(self) -> tuple[Reading, ...]:
        """Return name, unit, scale, noise and meaning of every entry of the observation."""
        return self.simulation.entries

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start episodes: all, or those in `options["reset_mask"]`, bool of shape (num_envs,).

        Args:
            seed: seeds of the generators; without a seed the generators continue.
            options: the mask, and `"context"`, `"split"` and `"plant"` of the episodes that start, see
                `grind_env.envs.reset_options`; they hold until changed. A list has one entry for each sub-environment.

        Returns:
            The observations; and an info with the names of the machines if the environments were made with a plant.

        Raises:
            GrindError: if the seeds or the options do not fit the sub-environments.
        """
        given_options = dict(option_items(options))
        mask = given_options.pop("reset_mask", np.ones(self.num_envs, bool))
        if not isinstance(mask, np.ndarray) or mask.dtype != bool or mask.shape != (self.num_envs,) or not mask.any():
            raise GrindError(f"reset_mask must be a bool array of shape ({self.num_envs},) with at least one True")
        read = partial(read_options, self.task, unfixable=self.simulation.unfixable, made=self.simulation.plants)
        given = read_all_options(given_options, self.given, read)
        for i, each in enumerate(_seed_list(seed, self.num_envs)):
            if mask[i] and each is not None:
                self.rngs[i], self.seeds[i] = seeding.np_random(each)
        self.given = [new if chosen else old for new, old, chosen in zip(given, self.given, mask, strict=True)]
        info = self._restart(mask)
        self.begun |= mask
        self.due &= ~mask
        self.all_begun, self.some_due = bool(self.begun.all()), bool(self.due.any())
        return self.simulation.observe(self.episodes), info

    def step(self, actions: Any) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """Grind one block in every sub-environment, in the autoreset mode of `metadata["autoreset_mode"]`.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset; without autoreset, after the last block.
            ActionError: if an action is not in the action space.
        """
        if not self.all_begun:
            raise gym.error.ResetNeeded("some sub-environments have not begun: call reset() before step()")
        if self.autoreset_mode == AutoresetMode.DISABLED and self.some_due:
            raise gym.error.ResetNeeded(
                f"episode {np.flatnonzero(self.due)[0]} is over: reset it with options={{'reset_mask': ...}}"
            )
        # in NEXT_STEP mode the action for an episode that is over is ignored, and a new episode begins
        resetting, some = self.due, self.some_due
        values = self.codec.table(actions, self.num_envs)
        stepping = self.everyone
        if some:
            values = np.where(resetting[:, None], self.codec.neutral, values)
            stepping = np.flatnonzero(~resetting)
        choice = self.simulation.applied_choice(self.episodes, self.codec.choose(values))
        blocks: dict[int, Any] = {}
        if self.show_block or self.render_mode is not None:
            block = self.simulation.writer.block
            blocks = {i: block(self.episodes, i, *(values[i] for values in choice)) for i in stepping.tolist()}
        outcomes = step_shared(self.simulation, self.episodes, choice, stepping, self.threads)
        self.last = outcomes, choice
        if self.render_mode is not None:
            for i, ground in blocks.items():
                self.blocks[i].append(ground)
                self.outcomes[i].append(Outcome(*outcomes[i].tolist()))
        begun = self._restart(resetting) if some else {}
        terminated, truncated = self.simulation.over(self.episodes), np.zeros(self.num_envs, bool)
        if self.most_steps is not None:
            self.steps[stepping] += 1
            truncated = self.steps >= self.most_steps
        over = terminated | truncated
        ended = bool(over.any())
        observations = self.simulation.observe(self.episodes)
        told = self._info(outcomes, observations, choice, blocks, ~resetting) if stepping.size > 0 else {}
        info = {**begun, **told}
        if ended and self.autoreset_mode == AutoresetMode.SAME_STEP:
            info = {**_final_info(info, observations, over), **self._restart(over)}
            observations = self.simulation.observe(self.episodes)
        due_later = self.autoreset_mode != AutoresetMode.SAME_STEP
        self.due, self.some_due = over & due_later, ended and due_later
        return observations, outcomes[:, REWARD].copy(), terminated, truncated, info

    def _restart(self, mask: Array) -> dict[str, Any]:
        """Replace the episodes in `mask` with new ones; return their info."""
        index = np.flatnonzero(mask).tolist()
        rngs = [self.rngs[i] for i in index]
        given = with_machines(self.simulation, [self.given[i] for i in index], rngs)
        self.simulation.restart_all(self.episodes, index, rngs, given)
        self.steps[mask] = 0
        for i in index:
            self.blocks[i], self.outcomes[i] = [], []
        if not given or given[0].plant is None:
            return {}
        names = np.full(self.num_envs, None, object)
        names[index] = [each.plant and each.plant.text for each in given]
        return {"plant": names, "_plant": mask.copy()}

    def render(self) -> tuple[Any, ...] | None:
        """Return the machine of each sub-environment after its last block, as `GrindEnv.render` shows it.

        After an episode, mode `"SameStep"` shows the next one; the other modes show its last block until the reset.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            RenderError: if a package for drawing is not installed.
        """
        if self.render_mode is None:
            gym.logger.warn("render() shows nothing: make the env with render_mode='rgb_array' or 'ansi'")
            return None
        if not self.all_begun:
            raise gym.error.ResetNeeded("there is nothing to show yet: call reset() before render()")
        draw = terminal_view.panel if self.render_mode == "ansi" else frames.render
        ground = enumerate(zip(self.blocks, self.outcomes, strict=True))
        return tuple(draw(self.simulation.viewer.view(self.episodes, i, *each)) for i, each in ground)

    def _info(
        self, outcomes: Array, observations: Array, choice: tuple[Array, ...], blocks: dict[int, Any], mask: Array
    ) -> dict[str, Any]:
        info = self.infos.vector(outcomes, observations, choice, mask)
        if self.show_block:
            texts = np.full(self.num_envs, None, object)
            texts[list(blocks)] = [self.simulation.writer.text(block) for block in blocks.values()]
            info["block"], info["_block"] = texts, mask
        return info


#: arguments that a vector environment takes for itself
OF_VECTORS = inspect.signature(GrindVectorEnv).parameters.keys() - {"simulation", "num_envs"}


def side_by_side(make: Callable[..., GrindEnv]) -> Callable[..., GrindVectorEnv]:
    """Return the `make_vector` of an id, given its `make`."""

    def vector(num_envs: int = 1, **arguments: Any) -> GrindVectorEnv:
        shown = {name: arguments.pop(name) for name in OF_VECTORS & arguments.keys()}
        return GrindVectorEnv(make(**arguments).simulation, num_envs, **shown)

    vector.__name__ = vector.__qualname__ = f"{make.__name__}_vector"
    vector.__doc__ = f"Return a `GrindVectorEnv`; its arguments and those of `{make.__name__}` are accepted."
    return vector


def _masked(info: dict[str, Any], mask: Array) -> dict[str, Any]:
    """Return the vector info of the sub-environments in `mask` alone."""
    chosen: dict[str, Any] = {}
    for name, value in info.items():
        if name.startswith("_"):
            chosen[name] = value & mask
        elif isinstance(value, dict):
            chosen[name] = _masked(value, mask)
        else:
            chosen[name] = np.where(mask, value, np.zeros((), value.dtype) if value.dtype != object else None)
    return chosen


def _final_info(info: dict[str, Any], observations: Array, over: Array) -> dict[str, Any]:
    """Return the vector info of a step in mode `"SameStep"`, with the info of ended episodes in `final_info`.

    Args:
        info: vector info of the step.
        observations: last observations of the episodes, shape (num_envs, entries).
        over: whether each episode is over, bool of shape (num_envs,), at least one.
    """
    final_obs = np.full(len(over), None, object)
    for i in np.flatnonzero(over):
        final_obs[i] = observations[i].copy()
    moved = {
        "final_obs": final_obs,
        "_final_obs": over.copy(),
        "final_info": _masked(info, over),
        "_final_info": over.copy(),
    }
    return {**moved, **_masked(info, ~over)} if not over.all() else moved


def _autoreset(mode: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(mode)
    except ValueError:
        legal = ", ".join(repr(each.value) for each in AutoresetMode)
        raise TaskError(f"autoreset_mode is {mode!r}, but must be one of {legal}") from None


def _seed_list(seed: int | Sequence[int | None] | None, num_envs: int) -> list[int | None]:
    """Return a seed for each sub-environment; None to go on with its generator."""
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


def _is_seed(value: object) -> TypeGuard[int]:
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(value >= 0)
