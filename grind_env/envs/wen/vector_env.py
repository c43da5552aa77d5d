"""`grind/Wen-v0`, many times side by side."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from grind_env.arrays import Array
from grind_env.envs.arguments import check_count, refuse_render
from grind_env.envs.contexts import read_all_options
from grind_env.envs.observations import Reading
from grind_env.envs.vector_common import (
    VECTOR_RENDER_MODES,
    Generators,
    StepLimit,
    autoreset,
    beside_mask,
    drawn_all,
    final_info,
    masked,
    refuse_out_of_turn,
    reset_mask,
    vector_metadata,
)
from grind_env.envs.wen.actions import action_array, action_space, check_arguments, decode
from grind_env.envs.wen.cases import draw_case, observation_info, observation_space, observed, read_case
from grind_env.envs.wen.info import report, with_masks
from grind_env.envs.wen.judging import judged, named
from grind_env.envs.wen.model import CASES, Setting, WenVerdict
from grind_env.envs.wen.view import sheet_of


class WenVectorEnv(VectorEnv[Array, Array, Array]):
    """N times `WenEnv`, with the numbers of `gymnasium.vector.SyncVectorEnv` bit by bit.

    Sub-environment i has a generator of its own, seeded with `seed + i` or with entry i of a list of seeds.

    Args:
        num_envs: number of sub-environments.
        autoreset_mode: `AutoresetMode` or its value: `"NextStep"`, `"SameStep"` or `"Disabled"`.
        render_mode: as for `GrindVectorEnv`.
        action: form of the action: `"box"`, the only one.
        observation: as for `WenEnv`.
        show_block: False.
        predress: False.
        cycle: None.
        plant: None.
        max_episode_steps: as for `GrindVectorEnv`; an episode has one step.
    """

    def __init__(
        self,
        num_envs: int = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        action: str = "box",
        observation: str = "measured",
        show_block: bool = False,
        predress: bool = False,
        cycle: str | None = None,
        plant: str | None = None,
        max_episode_steps: int | None = None,
    ) -> None:
        self.num_envs = num_envs = check_count("num_envs", num_envs)
        check_arguments(action, observation, show_block, predress, cycle, plant)
        refuse_render(render_mode, VECTOR_RENDER_MODES)
        self.render_mode, self.autoreset_mode = render_mode, autoreset(autoreset_mode)
        self.metadata = vector_metadata(self.autoreset_mode)
        self.limit = StepLimit(max_episode_steps, num_envs)
        self.single_action_space, self.single_observation_space = action_space(), observation_space()
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.generators = Generators(num_envs)
        self.fixed: list[int | None] = [None] * num_envs
        self.cases = np.zeros(num_envs, np.int64)
        self.begun, self.due = np.zeros(num_envs, bool), np.zeros(num_envs, bool)
        self.chosen: list[tuple[Setting, WenVerdict] | None] = [None] * num_envs

    @property
    def np_random_seed(self) -> Any:
        """The seeds of the generators of all sub-environments, as in `SyncVectorEnv`."""
        return tuple(self.generators.seeds)

    def observation_info(self) -> tuple[Reading, ...]:
        """Name and meaning of every entry of the observation."""
        return observation_info()

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start episodes: all, or those in `options["reset_mask"]`, bool of shape (num_envs,).

        Args:
            seed: of the generators, which else go on.
            options: beside the mask `"context"`, as for `WenEnv`, or a list of contexts, one for each sub-environment.

        Raises:
            GrindError: if the seeds, the mask or the options do not fit the sub-environments.
        """
        mask = reset_mask(options, self.num_envs)
        fixed = read_all_options(beside_mask(options), self.fixed, read_case)
        self.generators.reseed(seed, mask)
        self.fixed = [new if chosen else old for new, old, chosen in zip(fixed, self.fixed, mask, strict=True)]
        self._restart(mask)
        self.begun |= mask
        self.due &= ~mask
        return observed(self.cases), {}

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """Grind one part in every sub-environment, in the autoreset mode of `metadata["autoreset_mode"]`.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset; without autoreset, after an episode's step.
            ActionError: if an action is not in the action space.
        """
        refuse_out_of_turn(bool(self.begun.all()), self.due, self.autoreset_mode)
        values = action_array(actions, self.num_envs)
        # in NEXT_STEP mode the action of an episode that is over is ignored, and it begins anew
        settings = decode(np.where(self.due[:, None], 0.0, values))
        stepping = ~self.due
        verdicts = judged(settings, self.cases)
        columns = report(settings, verdicts)
        terms = columns["reward_terms"]
        rewards = np.where(stepping, terms["objective"] + terms["violation"], 0.0)
        info = masked(with_masks(columns, stepping), stepping) if stepping.any() else {}
        if self.render_mode is not None:
            self.chosen = [named(*each) for each in zip(settings, verdicts, strict=True)]
        self._restart(self.due)
        truncated = self.limit.step(stepping)
        observations = observed(self.cases)
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            info = final_info(info, observations, stepping)
            self._restart(stepping)
            return observed(self.cases), rewards, stepping, truncated, info
        self.due = stepping.copy()
        return observations, rewards, stepping, truncated, info

    def render(self) -> tuple[Any, ...] | None:
        """The setting of each sub-environment and what it gives, as `WenEnv.render` shows it.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            RenderError: if what draws it is not installed.
        """
        names = list(CASES)
        sheets = (
            sheet_of(names[case], *(chosen or (None, None)))
            for case, chosen in zip(self.cases.tolist(), self.chosen, strict=True)
        )
        return drawn_all(self.render_mode, self.begun, sheets)

    def _restart(self, mask: Array) -> None:
        self.limit.restart(mask)
        for i in np.flatnonzero(mask).tolist():
            self.cases[i], self.chosen[i] = draw_case(self.generators.rngs[i], self.fixed[i]), None
