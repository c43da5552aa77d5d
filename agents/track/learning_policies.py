"""Adapters that learn from shift to shift."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from agents.benchmark.agent_training import plain_agent
from agents.track.model_fit import CONSTANTS, changed, fitted
from grind_env.array_types import Array
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.plants.plant_names import TRAINING
from grind_env.policies.choices import Decision
from grind_env.policies.learned.network import LearnedPolicy
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.mismatch_fallback import guarded
from grind_env.policies.nominal_model import on
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.policy_lookup import named_policy, trained_file
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scripted.empirical_rule import EmpiricalRule
from grind_env.policies.track import SHIFTS, TrackShift
from grind_env.training.gru_ppo import Settings

STEPS = 5_000_000  #: number of environment steps of the training of `rl2`
PLANNER = "look_ahead"  #: the planner on the belief


@dataclass
class CalibratedPlanner:
    """Planner on the belief with a guard, both on a model that is fitted to all shifts so far."""

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


class LearningRule(EmpiricalRule):
    """Empirical rule that keeps its laws of power, Ra and size, its E and its volumes from shift to shift."""

    name: ClassVar[str] = "empirical_rule_learns"
    LEARNED: ClassVar[tuple[str, ...]] = ("power", "roughness", "size", "speeds", "volumes")

    def begin(self, simulation: Simulation, episodes: int) -> None:
        learned = {name: value for name, value in vars(self).items() if name in self.LEARNED}
        super().begin(simulation, episodes)
        vars(self).update(learned)


@dataclass
class Trained:
    """Base of policies that change a trained agent between shifts; `model` is the simulation of the model."""

    sees: ClassVar[Sees] = "measurements"
    agent: Any = None  #: trained agent; by default it begins as `robust`

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.model, self.agent = simulation, self.agent or self._first(simulation)
        self.agent.begin(simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        decision: Decision = self.agent.act(observation, episodes)
        return decision

    def _first(self, simulation: Simulation) -> LearnedPolicy:
        return load_policy(trained_file("robust", simulation.task.name), simulation=simulation)


class Rl2(Trained):
    """GRU of `gru_ppo`, trained on ten shifts of each machine; its state lasts over all shifts on a machine."""

    name: ClassVar[str] = "rl2"
    remembers: ClassVar[bool] = True

    def begin(self, simulation: Simulation, episodes: int) -> None:
        remembered = getattr(self.agent, "state", None) if self.remembers else None
        super().begin(simulation, episodes)
        if remembered is not None:
            self.agent.state = remembered

    def _first(self, simulation: Simulation) -> LearnedPolicy:
        problem = on(find_problem(simulation.task.name), TRAINING)
        path = plain_agent(problem, Rl2.name, Settings(steps=STEPS, shifts=SHIFTS), 0)
        return load_policy(path, simulation=simulation, name=self.name)


class ForgetfulRl2(Rl2):
    """Agent of `rl2` that forgets each shift; the difference to `rl2` is the value of memory of earlier shifts."""

    name: ClassVar[str] = "rl2_forgets"
    remembers: ClassVar[bool] = False
