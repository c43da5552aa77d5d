"""The published one-step problem of Wen, Tay & Nee as an environment."""

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from grind_env.envs.arguments import refuse_render
from grind_env.envs.observations import Reading
from grind_env.envs.showing import RENDER_MODES, Showing
from grind_env.envs.wen.actions import action_space, check_arguments, decode, single_array
from grind_env.envs.wen.cases import draw_case, observation_info, observation_space, observed, read_case
from grind_env.envs.wen.info import report
from grind_env.envs.wen.judging import judged, named
from grind_env.envs.wen.model import CASES, Setting, WenVerdict
from grind_env.envs.wen.view import sheet_of
from grind_env.render.sheet import Sheet


class WenEnv(Showing, gym.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Choose wheel speed, table speed, dress depth and dress lead of one part.

    ## Description

    The most used published optimisation problem of surface grinding (Wen, Tay & Nee 1992; see
    `grind_env.envs.wen.model`): a contextual bandit with known optima, to check an optimiser with. When to dress has no
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

    One step, then `terminated`. Rough or finish is drawn at reset, or fixed by its options.

    Args:
        render_mode: `"rgb_array"`, `"human"` or `"ansi"`, for the setting and its verdict; as for `GrindEnv`.
        action: form of the action: `"box"`, the only one.
        observation: `"measured"` or `"full"`: the case is all that there is to observe.
        show_block: False; there is no block.
        predress: False; nothing is dressed.
        cycle: None; there is no program.
        plant: None; the model is that of the problem.
    """

    def __init__(
        self,
        render_mode: str | None = None,
        action: str = "box",
        observation: str = "measured",
        show_block: bool = False,
        predress: bool = False,
        cycle: str | None = None,
        plant: str | None = None,
    ) -> None:
        check_arguments(action, observation, show_block, predress, cycle, plant)
        refuse_render(render_mode, RENDER_MODES)
        self.render_mode = render_mode
        self.action_space, self.observation_space = action_space(), observation_space()
        self.fixed: int | None = None
        self.case: int | None = None
        self.over = False
        self.chosen: tuple[Setting, WenVerdict] | None = None

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

        Args:
            seed: of the generator, which else goes on.
            options: `{"context": {"case": "rough"}}` or `"finish"`; it holds until another is given, None removes it.

        Raises:
            ContextError: if an option is not legal.
        """
        fixed = read_case(options, self.fixed)
        super().reset(seed=seed)
        self.fixed = fixed
        self.case, self.over, self.chosen = draw_case(self.np_random, fixed), False, None
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
        settings = decode(single_array(action))
        verdicts = judged(settings, np.array([self.case]))
        info = report(settings, verdicts)
        self.over, self.chosen = True, named(settings[0], verdicts[0])
        self.follow()
        terms = {name: float(column[0]) for name, column in info.pop("reward_terms").items()}
        numbers = {name: float(column[0]) for name, column in info.items()}
        return observed(self.case), sum(terms.values()), True, False, {"reward_terms": terms, **numbers}
