"""Adapters that learn from shift to shift."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from agents.track.fitting import CONSTANTS, changed, fitted
from grind_env.arrays import Array
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision
from grind_env.policies.guard import guarded
from grind_env.policies.naming import named_policy
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.track import TrackShift

PLANNER = "look_ahead"
"""The planner on the belief."""


@dataclass
class CalibratedPlanner:
    """A planner on the belief with a guard, both on a model that is fitted to all shifts so far."""

    name: ClassVar[str] = "calibrated"
    sees: ClassVar[Sees] = "measurements"
    shifts: list[TrackShift] = field(default_factory=list, repr=False)
    z: Array = field(default_factory=lambda: np.zeros(len(CONSTANTS)), repr=False)
    policy: Policy | None = None

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.model = simulation
        self.policy = self.policy or guarded(named_policy(PLANNER, simulation))
        self.policy.begin(changed(simulation, self.z) if self.shifts else simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        assert self.policy is not None
        return self.policy.act(observation, episodes)

    def learn(self, shift: TrackShift) -> None:
        self.shifts.append(shift)
        self.z = fitted(self.model, self.shifts, self.z)
