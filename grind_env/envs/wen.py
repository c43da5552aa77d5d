"""The published one-step problem of Wen, Tay & Nee as environments, single and vector."""

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from grind_env.envs.actions import ActionError
from grind_env.envs.arguments import check_count, refuse_render
from grind_env.envs.contexts import refuse_options
from grind_env.envs.observations import Reading
from grind_env.envs.showing import RENDER_MODES, Showing
from grind_env.envs.vector_common import (
    VECTOR_RENDER_MODES,
    autoreset,
    beside_mask,
    drawn_all,
    masked,
    reset_mask,
    seed_list,
    vector_metadata,
)
from grind_env.envs.wen_actions import action_array, action_space, check_arguments
from grind_env.envs.wen_cases import draw_case, observation_info, observation_space, observed
from grind_env.envs.wen_info import report, with_masks
from grind_env.envs.wen_view import sheet_of
from grind_env.process.wen import CASES, HIGHEST, LOWEST, Setting, Verdict, judge_settings
from grind_env.render.sheet import Sheet

Array = NDArray[Any]

LOW, HIGH = np.array(LOWEST), np.array(HIGHEST)
CASE_ROWS = np.array(list(CASES.values()))
OBJECTIVE, VIOLATION = Verdict._fields.index("objective"), Verdict._fields.index("violation")


def decode(values: Array) -> Array:
    """Settings, shape (N, fields of `Setting`), of actions of that shape: linear from -1..1 onto the bounds.

    Raises:
        ActionError: if an action is not a number or lies outside -1..1.
    """
    good = np.abs(values) <= 1.0
    if not good.all():
        i, k = np.argwhere(~good)[0]
        name = Setting._fields[k]
        raise ActionError(f"action {i} has {values[i, k]} for {name}, but must lie between -1 and 1: clip it first")
    settings: Array = LOW + 0.5 * (values + 1.0) * (HIGH - LOW)
    return settings


def encode(setting: Setting) -> NDArray[np.float32]:
    """The action, shape (4,), that chooses a setting.

    Raises:
        ActionError: if the setting lies outside the bounds.
    """
    values = np.array(setting)
    good = (values >= LOW) & (values <= HIGH)
    if not good.all():
        k = int(np.flatnonzero(~good)[0])
        raise ActionError(f"{Setting._fields[k]} is {values[k]:g}, but must be from {LOW[k]:g} to {HIGH[k]:g}")
    action: NDArray[np.float32] = (2.0 * (values - LOW) / (HIGH - LOW) - 1.0).astype(np.float32)
    return action


def judged(settings: Array, cases: Array) -> Array:
    """Verdicts, shape (N, fields of `Verdict`), of settings for cases given by number, shape (N,)."""
    verdicts = np.empty((len(settings), len(Verdict._fields)))
    judge_settings(settings, CASE_ROWS[cases], verdicts)
    return verdicts


class WenEnv(Showing, gym.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Choose wheel speed, table speed, dress depth and dress lead of one part.

    ## Description

    The most used published optimisation problem of surface grinding (Wen, Tay & Nee 1992; see
    `grind_env.process.wen`): a contextual bandit with known optima, to check an optimiser with. When to dress has no
    weight in it.

    ## Action space

    `Box(-1, 1, (4,), float32)`, mapped linearly: wheel speed Vs 1000..2023 m/min, table speed Vw 10..22.7 m/min,
    depth of dressing doc 0.01..0.137 mm, lead of dressing L 0.01..0.137 mm/rev. This is the only form of the action:
    the problem is published with continuous settings, and has no E and D for the discrete forms of the other ids.

    ## Observation space

    `Box(0, 1, (2,), float32)`: (1, 0) if the part is to be rough-ground, (0, 1) if it is to be finished.

    ## Reward

    `-(COF + v)`: the published objective (cost and removal, or cost and roughness) and the sum of the relative
    violations of its limits, an exact penalty. The best is 0.2292 for rough and -0.5224 for finish, uniform actions
    earn -0.148 and -0.843 on average. `info["reward_terms"]` holds both terms, `info["cost"]` is v.

    ## Episode

    One step, then `terminated`. Rough or finish is drawn at reset.

    Args:
        render_mode: `"rgb_array"`, `"human"` or `"ansi"`, for the setting and its verdict; as for `GrindEnv`.
        action: form of the action: `"box"`, the only one.
        observation: `"measured"` or `"full"`: the case is all that there is to observe.
        show_block: False; there is no block.
        predress: False; nothing is dressed.
    """

    def __init__(
        self,
        render_mode: str | None = None,
        action: str = "box",
        observation: str = "measured",
        show_block: bool = False,
        predress: bool = False,
    ) -> None:
        check_arguments(action, observation, show_block, predress)
        refuse_render(render_mode, RENDER_MODES)
        self.render_mode = render_mode
        self.action_space, self.observation_space = action_space(), observation_space()
        self.case: int | None = None
        self.over = False
        self.chosen: tuple[Setting, Verdict] | None = None

    def observation_info(self) -> tuple[Reading, ...]:
        """Name and meaning of every entry of the observation."""
        return observation_info()

    def view(self) -> Sheet:
        """The setting chosen and what it gives.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        if self.case is None:
            raise gym.error.ResetNeeded("there is nothing to show yet: call reset() before render()")
        return sheet_of(list(CASES)[self.case], *(self.chosen or (None, None)))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Draw a case; the same seed draws the same one.

        Raises:
            ContextError: if there are options: the problem has none.
        """
        refuse_options(options, "Wen")
        super().reset(seed=seed)
        self.case, self.over, self.chosen = draw_case(self.np_random), False, None
        self.follow()
        return observed(self.case), {}

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Grind the part.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset and after the step.
            ActionError: if the action is not in the action space.
        """
        if self.case is None or self.over:
            raise gym.error.ResetNeeded("the episode has not begun or is over: call reset() before step()")
        settings = decode(action_array([action], 1))
        verdicts = judged(settings, np.array([self.case]))
        info = report(settings, verdicts)
        self.over, self.chosen = True, _named(settings[0], verdicts[0])
        self.follow()
        terms = {name: float(column[0]) for name, column in info.pop("reward_terms").items()}
        numbers = {name: float(column[0]) for name, column in info.items()}
        return observed(self.case), sum(terms.values()), True, False, {"reward_terms": terms, **numbers}


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
    ) -> None:
        self.num_envs = num_envs = check_count(num_envs)
        check_arguments(action, observation, show_block, predress)
        refuse_render(render_mode, VECTOR_RENDER_MODES)
        self.render_mode, self.autoreset_mode = render_mode, autoreset(autoreset_mode)
        self.metadata = vector_metadata(self.autoreset_mode)
        self.single_action_space, self.single_observation_space = action_space(), observation_space()
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.rngs: list[np.random.Generator] = [seeding.np_random(None)[0] for _ in range(num_envs)]
        self.cases = np.zeros(num_envs, np.int64)
        self.begun, self.due = np.zeros(num_envs, bool), np.zeros(num_envs, bool)
        self.chosen: list[tuple[Setting, Verdict] | None] = [None] * num_envs

    def observation_info(self) -> tuple[Reading, ...]:
        """Name and meaning of every entry of the observation."""
        return observation_info()

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start episodes: all, or those in `options["reset_mask"]`, bool of shape (num_envs,).

        Raises:
            GrindError: if the seeds or the mask do not fit the sub-environments, or if there is another option.
        """
        mask = reset_mask(options, self.num_envs)
        refuse_options(beside_mask(options), "Wen")
        fresh = {
            i: seeding.np_random(each)[0]
            for i, each in enumerate(seed_list(seed, self.num_envs))
            if mask[i] and each is not None
        }
        for i, rng in fresh.items():
            self.rngs[i] = rng
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
        if not self.begun.all():
            raise gym.error.ResetNeeded("some sub-environments have not begun: call reset() before step()")
        if self.due.any() and self.autoreset_mode == AutoresetMode.DISABLED:
            raise gym.error.ResetNeeded(
                f"episode {np.flatnonzero(self.due)[0]} is over: reset it with options={{'reset_mask': ...}}"
            )
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
            self.chosen = [_named(*each) for each in zip(settings, verdicts, strict=True)]
        self._restart(self.due)
        observations = observed(self.cases)
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            final_obs = np.full(self.num_envs, None, object)
            for i, observation in enumerate(observations):
                final_obs[i] = observation.copy()
            info = {
                "final_obs": final_obs,
                "_final_obs": stepping.copy(),
                "final_info": info,
                "_final_info": stepping.copy(),
            }
            self._restart(stepping)
            return observed(self.cases), rewards, stepping, np.zeros(self.num_envs, bool), info
        self.due = stepping.copy()
        return observations, rewards, stepping, np.zeros(self.num_envs, bool), info

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
        for i in np.flatnonzero(mask).tolist():
            self.cases[i], self.chosen[i] = draw_case(self.rngs[i]), None


def _named(setting: Array, verdict: Array) -> tuple[Setting, Verdict]:
    return Setting(*setting.tolist()), Verdict(*verdict.tolist())
