"""What it is worth to adapt E, D or both in a task, and what is left to be had."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.reference.table import best_plan
from grind_env.arrays import Array
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.policy import Sees
from grind_env.policies.problem import Problem
from grind_env.policies.registry import REFERENCE, make_policy
from grind_env.policies.statistics import Interval, bootstrap

FIXED, SPEED, DRESS, BOTH, BEST, PLANNER, HINDSIGHT = ROLES = (
    "fixed plan",
    "E alone",
    "D alone",
    "both",
    "best rule",
    "planner",
    "hindsight",
)
"""What is compared: the best plan without sensors; the adaptive rule for one decision, and for both; the scripted
policy that costs least of those that see measurements; the planner that knows the state; the one that knows the
future."""
DULLNESS, GROWTH, ROUGHNESS, STATE = KNOWN = ("dullness", "dullness, growth", "dullness, Ra", "full state")
"""What the rule on the state knows before a block: how dull the wheel is; beside it how fast the lot dulls it, or which
Ra wheel and part give; or all."""
ADAPTING_E, ADAPTING_D = "adapting E", "adapting D"
AGAINST = {**dict.fromkeys((*ROLES[1:], *KNOWN), FIXED), ADAPTING_E: DRESS, ADAPTING_D: SPEED}
"""What each saving is counted from."""
DOES = {ADAPTING_E: BOTH, ADAPTING_D: BOTH}
"""Who saves it, where the name does not say it."""


@dataclass(frozen=True, slots=True)
class Gap:
    """What one policy costs in a task, and what it saves on another one in the same episodes."""

    what: str
    policy: str
    sees: Sees
    cost: Interval
    """$ per step of the best fixed plan, the terminal cost included, as `reference_cost` is."""
    against: str
    """The policy on which it saves."""
    saving: Interval
    """Of the mean cost of an episode, %."""
    score: Interval
    """0 is the best fixed plan, 100 hindsight."""


@dataclass(frozen=True, slots=True)
class TaskGaps:
    """All gaps of a task, by what they are of."""

    task: str
    reference_cost: float
    gaps: Mapping[str, Gap]

    @property
    def off(self) -> float:
        """Reference cost over the measured cost of the best fixed plan, less one, %."""
        return 100.0 * (self.reference_cost / self.gaps[FIXED].cost.value - 1.0)


def task_gaps(problem: Problem, found: Mapping[str, Evaluation], configs: Path | None = None) -> TaskGaps:
    """The gaps of a task, from the evaluations of its policies on the same episodes."""
    simulation = problem.simulation()
    sees = {name: make_policy(name, simulation, configs).sees for name in found}
    rules = [name for name in found if sees[name] == "measurements"]
    policies = {
        FIXED: best_plan(found),
        SPEED: "adaptive_speed",
        DRESS: "adaptive_dress",
        BOTH: "adaptive_rule",
        BEST: min(rules, key=lambda name: float(found[name].cost.mean())),
        PLANNER: "mpc",
        HINDSIGHT: REFERENCE,
        DULLNESS: "dullness_rule",
        GROWTH: "growth_rule",
        ROUGHNESS: "roughness_rule",
        STATE: "full_state_rule",
    }
    fixed, hindsight = found[policies[FIXED]], found[REFERENCE]
    steps = fixed.speeds.shape[1]
    gaps = {}
    for what in (*ROLES, ADAPTING_E, ADAPTING_D, *KNOWN):
        policy, against = policies[DOES.get(what, what)], policies[AGAINST.get(what, FIXED)]
        if policy in found:
            run = found[policy]
            gaps[what] = Gap(
                what=what,
                policy=policy,
                sees=sees[policy],
                cost=bootstrap(mean, run.cost / steps),
                against=against,
                saving=bootstrap(saving, run.cost, found[against].cost),
                score=run.score(fixed, hindsight),
            )
    return TaskGaps(problem.name, simulation.task.reference_cost, gaps)


def mean(cost: Array) -> Array:
    """Mean along the last axis."""
    return np.asarray(cost.mean(axis=-1))


def saving(cost: Array, against: Array) -> Array:
    """By how much the mean cost is below another one, % of that, along the last axis."""
    return np.asarray(100.0 * (1.0 - cost.mean(axis=-1) / against.mean(axis=-1)))
