"""The adaptive rule for D alone; E is one and the same."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.policy import Sees
from grind_env.policies.scripted.estimator import SharpnessEstimator
from grind_env.policies.scripted.rules import DressLaw


@dataclass(kw_only=True)
class AdaptiveDress(DressLaw):
    """D as `AdaptiveRule` chooses it, at one E for all blocks, as a fixed plan has it (scenarios, section 5).

    What it saves on the best fixed plan is what adapting D alone is worth; what `AdaptiveRule` saves on it, what
    adapting E is.

    Attributes:
        E: m/min.
        wS: of the lot severity in the dress criterion.
    """

    E: float
    wS: float
    name: ClassVar[str] = "adaptive_dress"
    sees: ClassVar[Sees] = "measurements"
    task: Task = field(init=False, repr=False)
    estimator: SharpnessEstimator = field(init=False, repr=False)

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Forget all lots."""
        self.task, self.estimator = simulation.task, SharpnessEstimator(simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Estimate, then decide on D."""
        seen = self.estimator.update(observation)
        speeds = nearest_speed(self.task, np.full(len(observation), 1000.0 * self.E))
        return Decision(speeds, self.executions(seen, self.wS * seen.severity))
