"""Rule on the belief about wheel and lot."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.belief.wheel_belief import WheelBelief
from grind_env.envs.episode_state import Episodes
from grind_env.envs.filter_members import MemberModel
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision
from grind_env.policies.episode_columns import AREA, LOADING
from grind_env.policies.scripted.rules import LOADED_AREA, Estimating, SharpnessRule


@dataclass(kw_only=True)
class BeliefRule(Estimating, SharpnessRule):
    """`FullStateRule` on measurements: the mean belief of an ensemble filter replaces the true state.

    A process engineer with the model of the process and the spreads of wheels and lots at hand can follow the wheel
    from power readings (`grind_env.belief`). Sharpness is the believed (A + 0.02 lam) pm. With the believed dulling
    rate kA, ln E has the further term gK ln kA, and the dress criterion wK ln kA.
    """

    gK: float
    wK: float
    name: ClassVar[str] = "belief_rule"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        super().begin(simulation, episodes)
        self.belief = WheelBelief(MemberModel(simulation))
        self.belief.begin(episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        belief = self.belief.update(observation)
        wheels = self.belief.wheels
        dullness = (wheels[:, :, AREA] + LOADED_AREA * wheels[:, :, LOADING]).mean(axis=1) * np.exp(belief.pressure)
        seen = self.estimator.update(observation)._replace(wear_flat=dullness)
        return self.decide(seen, self.gK * belief.growth, self.wK * belief.growth)
