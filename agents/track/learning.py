"""Adapters that learn from shift to shift: a bounded trim of a fixed plan, and a model calibrated in the loop."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from agents.track.adapter import Shift
from agents.track.fitting import CONSTANTS, changed, fitted
from grind_env.arrays import Array
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tables import KindRow
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.guard import guarded
from grind_env.policies.held import model_of
from grind_env.policies.naming import named_policy
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.problem import Problem
from grind_env.policies.registry import FIXED_PLANS, policy_names
from grind_env.policies.scripted.learned_laws import AIM
from grind_env.policies.tuned import read_tuned, tuned_folder

SHARE = 0.88
"""Of the power limit that is aimed at."""
HIGHEST = 0.9
"""Share of the readings of power that are below it."""
TRIM, WIDEST = 1.15, 1.6
"""Most that E is trimmed by from shift to shift, and in all."""


@dataclass
class Scaled:
    """A policy with its E times a factor."""

    policy: Policy
    factor: float
    sees: ClassVar[Sees] = "measurements"

    @property
    def name(self) -> str:
        """That of the policy, with the factor."""
        return f"{self.policy.name} x {self.factor:.2f}"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Let the policy begin."""
        self.task = simulation.task
        self.policy.begin(simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Its decision, with another E."""
        speeds, executions = self.policy.act(observation, episodes)
        return Decision(nearest_speed(self.task, self.factor * speeds), executions)


@dataclass
class Trim:
    """The best fixed plan of the model, its E moved after every shift to where readings come as near as they may.

    Power follows E by an exponent of about 0.7, Ra by 0.5, and what parts are off their size by 1. After a bad part E
    does not rise.
    """

    name: ClassVar[str] = "trim"
    factor: float = 1.0

    def start(self, problem: Problem) -> Policy:
        """The plan as it is."""
        self.model = model_of(problem)
        held = read_tuned(self.model.task.name, tuned_folder(self.model.task))
        plans = [name for name in FIXED_PLANS if name in held and name in policy_names(self.model)]
        if not plans:
            raise GrindError(f"no fixed plan is tuned for {problem.name}: run `python -m agents tune`")
        best = min(plans, key=lambda name: held[name].validation_cost)
        self.plan = named_policy(best, self.model)
        return Scaled(self.plan, self.factor)

    def learn(self, shift: Shift) -> Policy:
        """The plan with another E."""
        seen, most = self.model.read(shift.observations), KindRow(*self.model.kinds.max(axis=0))
        power = SHARE / (np.quantile(seen["peak_power"], HIGHEST) / most.power)
        roughness = AIM / max(float(seen["roughness"].mean()), 0.1)
        size = AIM / max(float(np.abs(seen["size_error"]).mean()) / most.size, 0.1) if most.size else np.inf
        wanted = min(power ** (1.0 / 0.7), roughness**2.0, size, 1.0 if shift.bad.any() else TRIM)
        moved = self.factor * min(max(wanted, 1.0 / TRIM), TRIM)
        self.factor = min(max(moved, 1.0 / WIDEST), WIDEST)
        return Scaled(self.plan, self.factor)


@dataclass
class Holding:
    """A policy that takes the machine for another model than that which it is begun with."""

    policy: Policy
    model: Simulation = field(repr=False)
    sees: ClassVar[Sees] = "measurements"

    @property
    def name(self) -> str:
        """That of the policy."""
        return self.policy.name

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Let the policy begin on the model."""
        self.policy.begin(self.model, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """As the policy."""
        return self.policy.act(observation, episodes)


@dataclass
class Calibrated:
    """The planner on the belief with a guard, both on a model that is fitted to all shifts so far.

    Args:
        planner: its name.
    """

    planner: str
    name: ClassVar[str] = "calibrated"
    shifts: list[Shift] = field(default_factory=list, repr=False)
    z: Array = field(default_factory=lambda: np.zeros(len(CONSTANTS)), repr=False)
    FITS: ClassVar[tuple[int, ...]] = (1, 2, 3, 4, 5, 7, 10, 14, 20)
    """Shifts after which it is fitted: later ones tell ever less."""

    def start(self, problem: Problem) -> Policy:
        """On the model as it is."""
        self.model = self.held = model_of(problem)
        return self._policy()

    def learn(self, shift: Shift) -> Policy:
        """On the model as the shifts have it."""
        self.shifts.append(shift)
        if len(self.shifts) in self.FITS:
            self.z = fitted(self.model, self.shifts, self.z)
            self.held = changed(self.model, self.z)
        return self._policy()

    def _policy(self) -> Policy:
        return Holding(guarded(named_policy(self.planner, self.model)), self.held)
