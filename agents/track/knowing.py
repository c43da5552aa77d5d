"""What stands beside the adapters: tuned on the machine itself, of which it knows all, on tuning seeds."""

from dataclasses import dataclass
from typing import Any

from agents.track.adapter import TrackShift
from agents.tuning.rules import Tuner, tune_policy
from grind_env.envs.simulation import Simulation
from grind_env.policies.planners.known_state import ModelPredictive
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem
from grind_env.policies.registry import FIXED_PLANS, TUNED, policy_names
from grind_env.policies.tuned import Parameters, arguments

FIXED, PLANNER, RETUNED = "fixed_plan_retuned", "planner_of_machine", "adaptive_rule_retuned"
ANCHORS = (FIXED, PLANNER)
"""Score 0 and 100."""
KNOWING = (*ANCHORS, RETUNED)
EVALUATIONS, STARTS, EPISODES = 300, 2, 48

Numbers = dict[str, tuple[float, Parameters]]
"""Cost on validation episodes, $, and parameters by policy."""


def tuned_for(simulation: Simulation) -> dict[str, list[str]]:
    """Names of the policies that are tuned for each of them, of which the best is taken."""
    plans = [name for name in FIXED_PLANS if name in policy_names(simulation)]
    return {FIXED: plans, PLANNER: ["full_state_rule"], RETUNED: ["adaptive_rule"]}


def tune_on(problem: Problem) -> Numbers:
    """Tune them on the machine of a problem."""
    tuner = Tuner(problem.simulation(), None, EPISODES)
    names = [name for of in tuned_for(tuner.simulation).values() for name in of]
    found = {name: tune_policy(name, tuner, EVALUATIONS, STARTS) for name in names}
    return {name: (each.validation_cost, each.parameters) for name, each in found.items()}


@dataclass
class Known:
    """One of these; it learns nothing any more."""

    name: str
    tuned: Numbers

    def start(self, problem: Problem) -> Policy:
        names = tuned_for(problem.simulation())[self.name]
        best = min(names, key=lambda name: self.tuned[name][0])
        policy: Any = TUNED[best](**arguments(self.tuned[best][1]))
        self.policy: Policy = ModelPredictive(policy) if self.name == PLANNER else policy
        return self.policy

    def learn(self, shift: TrackShift) -> Policy:
        return self.policy
