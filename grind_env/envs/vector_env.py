"""The native vector environment of every id in which E and D are chosen: all sub-environments in one step."""

import inspect
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from grind_env.arrays import Array
from grind_env.envs.actions import ActionCodec
from grind_env.envs.arguments import check_count, check_flags, check_threads, refuse_render
from grind_env.envs.contexts import Given, drawn, read_all_options, read_options
from grind_env.envs.env import GrindEnv
from grind_env.envs.episode_length import EpisodeLength
from grind_env.envs.infos import InfoWriter
from grind_env.envs.machines import machines_of
from grind_env.envs.observations import Reading
from grind_env.envs.shown import shown_space
from grind_env.envs.simulation import Simulation
from grind_env.envs.tables import Outcome
from grind_env.envs.threads import step_shared
from grind_env.envs.vector_common import (
    VECTOR_RENDER_MODES,
    Generators,
    StepLimit,
    autoreset,
    beside_mask,
    drawn_all,
    final_info,
    refuse_out_of_turn,
    reset_mask,
    vector_metadata,
)
from grind_env.envs.view import History

REWARD = Outcome._fields.index("reward")


class GrindVectorEnv(EpisodeLength, VectorEnv[Array, Any, Array]):
    """N times `GrindEnv`, with the numbers of `gymnasium.vector.SyncVectorEnv` bit by bit.

    Sub-environment i has a generator of its own, seeded with `seed + i` or with entry i of a list of seeds.

    Args:
        simulation: as for `GrindEnv`.
        num_envs: number of sub-environments.
        show_block: put the text of the blocks that were run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        autoreset_mode: `AutoresetMode` or its value: `"NextStep"`, `"SameStep"` or `"Disabled"`.
        render_mode: `"rgb_array"` or `"ansi"`, for one picture or text of each sub-environment.
        max_episode_steps: steps after which an episode is truncated, as by `TimeLimit`; None for never.
        info: as for `GrindEnv`.
        threads: that grind, each a share of the episodes; the numbers are the same. For some thousand, on idle cores.

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
        refuse_render(render_mode, VECTOR_RENDER_MODES)
        self.render_mode = render_mode
        self.autoreset_mode = autoreset(autoreset_mode)
        self.metadata = vector_metadata(self.autoreset_mode)
        self.limit = StepLimit(max_episode_steps, num_envs)
        self.show_block = show_block
        self.task, self.simulation = simulation.task, simulation
        self.threads = check_threads(threads, compiled=simulation.compiled)
        self.codec = ActionCodec(self.task, action, predress=simulation.pre_dress, out_of_range=out_of_range)
        self.infos = InfoWriter(simulation, self.codec.names, info)
        self.single_action_space = self.codec.space
        self.single_observation_space = shown_space(self.simulation)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.generators = Generators(num_envs)
        self.given = [Given()] * num_envs
        self.episodes = self.simulation.start(self.generators.rngs, whole=False)
        self.begun = np.zeros(num_envs, bool)
        self.all_begun = False
        self.due = np.zeros(num_envs, bool)
        self.some_due = False
        self.everyone = np.arange(num_envs)
        self.history = None if render_mode is None else History(num_envs)
        self.last: tuple[Array, tuple[Array, ...]]  # outcomes and choice of the last step

    @property
    def np_random_seed(self) -> Any:
        """The seeds of the generators of all sub-environments, as in `SyncVectorEnv`."""
        return tuple(self.generators.seeds)

    def observation_info(self) -> tuple[Reading, ...]:
        """Name, unit, scale, noise and meaning of every entry of the observation."""
        return self.simulation.entries

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start episodes: all, or those in `options["reset_mask"]`, bool of shape (num_envs,).

        Args:
            seed: of the generators, which else go on.
            options: beside the mask `"context"`, `"split"` and `"plant"` of the episodes that start, see
                `grind_env.envs.contexts`; they hold until others are given. A list has one entry for each
                sub-environment.

        Returns:
            The observations, and as info the names of the machines where the environments were made with some.

        Raises:
            GrindError: if the seeds or the options do not fit the sub-environments.
        """
        mask = reset_mask(options, self.num_envs)
        read = partial(read_options, self.task, barred=self.simulation.barred, made=machines_of(self.simulation))
        given = read_all_options(beside_mask(options), self.given, read)
        self.generators.reseed(seed, mask)
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
        refuse_out_of_turn(self.all_begun, self.due, self.autoreset_mode)
        # in NEXT_STEP mode the action of an episode that is over is ignored, and it begins anew
        resetting, some = self.due, self.some_due
        values = self.codec.table(actions, self.num_envs)
        stepping = self.everyone
        if some:
            values = np.where(resetting[:, None], self.codec.neutral, values)
            stepping = np.flatnonzero(~resetting)
        choice = self.simulation.taken(self.episodes, self.codec.choose(values))
        blocks: dict[int, Any] = {}
        if self.show_block or self.history is not None:
            block = self.simulation.block
            blocks = {i: block(self.episodes, i, *(values[i] for values in choice)) for i in stepping.tolist()}
        outcomes = step_shared(self.simulation, self.episodes, choice, stepping, self.threads)
        self.last = outcomes, choice
        if self.history is not None:
            self.history.note(blocks, outcomes)
        begun = self._restart(resetting) if some else {}
        terminated, truncated = self.simulation.over(self.episodes), self.limit.step(stepping)
        over = terminated | truncated
        ended = bool(over.any())
        observations = self.simulation.observe(self.episodes)
        told = self._info(outcomes, observations, choice, blocks, ~resetting) if stepping.size > 0 else {}
        info = {**begun, **told}
        if ended and self.autoreset_mode == AutoresetMode.SAME_STEP:
            info = {**final_info(info, observations, over), **self._restart(over)}
            observations = self.simulation.observe(self.episodes)
        due_later = self.autoreset_mode != AutoresetMode.SAME_STEP
        self.due, self.some_due = over & due_later, ended and due_later
        return observations, outcomes[:, REWARD].copy(), terminated, truncated, info

    def _restart(self, mask: Array) -> dict[str, Any]:
        """Put new episodes in place of those in `mask`; what there is to say of them."""
        index = np.flatnonzero(mask).tolist()
        rngs = [self.generators.rngs[i] for i in index]
        given = drawn(self.simulation, [self.given[i] for i in index], rngs)
        self.simulation.restart_all(self.episodes, index, rngs, given)
        self.limit.restart(mask)
        if self.history is not None:
            for i in index:
                self.history.restart(i)
        if not given or given[0].plant is None:
            return {}
        names = np.full(self.num_envs, None, object)
        names[index] = [each.plant and each.plant.text for each in given]
        return {"plant": names, "_plant": mask.copy()}

    def render(self) -> tuple[Any, ...] | None:
        """The machine of each sub-environment after its last block, as `GrindEnv.render` shows it.

        After an episode, mode `"SameStep"` shows the next one; the other modes show its last block until the reset.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            RenderError: if what draws it is not installed.
        """
        ground = () if self.history is None else enumerate(self.history)
        views = (self.simulation.view(self.episodes, i, *each) for i, each in ground)
        return drawn_all(self.render_mode, self.begun, views)

    def _info(
        self, outcomes: Array, observations: Array, choice: tuple[Array, ...], blocks: dict[int, Any], mask: Array
    ) -> dict[str, Any]:
        info = self.infos.vector(outcomes, observations, choice, mask)
        if self.show_block:
            texts = np.full(self.num_envs, None, object)
            texts[list(blocks)] = [self.simulation.text(block) for block in blocks.values()]
            info["block"], info["_block"] = texts, mask
        return info


OF_VECTORS = inspect.signature(GrindVectorEnv).parameters.keys() - {"simulation", "num_envs"}
"""Arguments that a vector environment takes for itself."""


def side_by_side(make: Callable[..., GrindEnv]) -> Callable[..., GrindVectorEnv]:
    """The vector form of an id: arguments as for the id, and those of `GrindVectorEnv`."""

    def vector(num_envs: int = 1, **arguments: Any) -> GrindVectorEnv:
        shown = {name: arguments.pop(name) for name in OF_VECTORS & arguments.keys()}
        return GrindVectorEnv(make(**arguments).simulation, num_envs, **shown)

    vector.__name__ = vector.__qualname__ = f"{make.__name__}_vector"
    vector.__doc__ = f"As `{make.__name__}`, many times side by side; further arguments as for `GrindVectorEnv`."
    return vector
