"""The adaptive rule for E alone; D is that of a fixed plan."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision
from grind_env.policies.scripted.rules import Estimating, Fixed, SpeedLaw


@dataclass(kw_only=True)
class AdaptiveSpeed(Estimating, SpeedLaw):
    """E as `AdaptiveRule` chooses it, D executions in every `every`-th block.

    What it saves on the best fixed plan is what adapting E alone is worth; what `AdaptiveRule` saves on it, what
    adapting D is.
    """

    gS: float
    D: int
    every: int
    name: ClassVar[str] = "adaptive_speed"
    plan: Fixed = field(init=False, repr=False)

    def begin(self, simulation: Simulation, episodes: int) -> None:
        super().begin(simulation, episodes)
        self.plan = Fixed(self.E[0], self.D, self.every)
        self.plan.begin(simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        seen = self.estimator.update(observation)
        return self.plan.act(observation, episodes)._replace(speeds=self.speeds(seen, self.gS * seen.severity))
