"""Adapters that learn from shift to shift: a bounded trim of a fixed plan, and a model calibrated in the loop."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from agents.track.adapter import TrackShift
from agents.track.fitting import CONSTANTS, changed, fitted
from grind_env.arrays import Array
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tables import KindRow
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.evaluation import episode_seeds, start_episodes, steps
from grind_env.policies.guard import guarded
from grind_env.policies.model_view import model_of
from grind_env.policies.naming import named_policy
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.problem import Problem
from grind_env.policies.registry import FIXED_PLANS, policy_names
from grind_env.policies.scripted.empirical_rule import SHARE
from grind_env.policies.scripted.learned_laws import AIM
from grind_env.policies.tuned import read_tuned, tuned_folder

EXPONENTS = np.array([0.7, 0.5, 1.0])
"""Of E in peak power, Ra and size error."""
TRIALS = 16
"""Episodes of the plan on the model."""
DAMPING = 0.5
"""Share of what readings ask for by which E moves: lots differ from shift to shift, too."""
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
        return f"{self.policy.name} x {self.factor:.2f}"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.task = simulation.task
        self.policy.begin(simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        speeds, executions = self.policy.act(observation, episodes)
        return Decision(nearest_speed(self.task, self.factor * speeds), executions)


@dataclass
class Trim:
    """The best fixed plan of the model, its E moved after every shift to where readings come as near as they may.

    That is as near to their limits as is usual, or as on the model. After a bad part E does not rise.
    """

    name: ClassVar[str] = "trim"
    factor: float = 1.0

    def start(self, problem: Problem) -> Policy:
        self.model = model_of(problem)
        held = read_tuned(self.model.task.name, tuned_folder(self.model.task))
        plans = [name for name in FIXED_PLANS if name in held and name in policy_names(self.model)]
        if not plans:
            raise GrindError(f"no fixed plan is tuned for {problem.name}: run `python -m agents tune`")
        best = min(plans, key=lambda name: held[name].validation_cost)
        self.plan = named_policy(best, self.model)
        episodes = start_episodes(self.model, episode_seeds("training", TRIALS))
        read = self._read(np.concatenate([each.observation for each in steps(self.plan, self.model, episodes)]))
        most = KindRow(*self.model.kinds.max(axis=0))
        self.most = np.maximum(read, [SHARE * most.power, AIM, AIM * most.size])
        return Scaled(self.plan, self.factor)

    def learn(self, shift: TrackShift) -> Policy:
        wanted = np.min((self.most / self._read(shift.observations)) ** (1.0 / EXPONENTS))
        moved = self.factor * min(max(float(wanted) ** DAMPING, 1.0 / TRIM), 1.0 if shift.bad.any() else TRIM)
        self.factor = min(max(moved, 1.0 / WIDEST), WIDEST)
        return Scaled(self.plan, self.factor)

    def _read(self, observations: NDArray[np.float32]) -> Array:
        """Mean peak power, Ra and size error as blocks have shown them, each with 1 for none."""
        seen = self.model.read(observations)
        found = [np.abs(seen[name]).mean() for name in ("peak_power", "roughness", "size_error")]
        return np.where(np.array(found) > 0.0, found, 1.0)


@dataclass
class Holding:
    """A policy that takes the machine for another model than that which it is begun with."""

    policy: Policy
    model: Simulation = field(repr=False)
    sees: ClassVar[Sees] = "measurements"

    @property
    def name(self) -> str:
        return self.policy.name

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.policy.begin(self.model, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        return self.policy.act(observation, episodes)


@dataclass
class CalibratedAdapter:
    """A planner on the belief with a guard, both on a model that is fitted to all shifts so far."""

    planner: str
    name: ClassVar[str] = "calibrated"
    shifts: list[TrackShift] = field(default_factory=list, repr=False)
    z: Array = field(default_factory=lambda: np.zeros(len(CONSTANTS)), repr=False)
    FITS: ClassVar[tuple[int, ...]] = (1, 2, 3, 4, 5, 7, 10, 14, 20)
    """Shifts after which it is fitted: later ones tell ever less."""

    def start(self, problem: Problem) -> Policy:
        self.model = self.held = model_of(problem)
        return self._policy()

    def learn(self, shift: TrackShift) -> Policy:
        self.shifts.append(shift)
        if len(self.shifts) in self.FITS:
            self.z = fitted(self.model, self.shifts, self.z)
            self.held = changed(self.model, self.z)
        return self._policy()

    def _policy(self) -> Policy:
        return Holding(guarded(named_policy(self.planner, self.model)), self.held)
