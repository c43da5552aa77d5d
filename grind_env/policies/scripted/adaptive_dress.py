"""The adaptive rule for D alone; E is one and the same."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episodes import Episodes
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.scripted.rules import DressLaw, Estimating


@dataclass(kw_only=True)
class AdaptiveDress(Estimating, DressLaw):
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

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        seen = self.estimator.update(observation)
        speeds = nearest_speed(self.task, np.full(len(observation), 1000.0 * self.E))
        return Decision(speeds, self.executions(seen, self.wS * seen.severity))
