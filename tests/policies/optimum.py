"""The exact optimum of a small task, which planners and searches have to find."""

from typing import NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import all_choices
from grind_env.policies.episode_columns import COST
from grind_env.policies.planners.dynamic_programming import SPEEDS


class Optimum(NamedTuple):
    """The cheapest plan of a deterministic task; costs in $, handover included, and E in mm/min."""

    cost: float
    speeds: Array
    executions: Array
    runner_up: float  #: cost of the second-best plan


def exact_optimum(simulation: Simulation) -> Optimum:
    """Try every plan; return the exact optimum of a task without chance and with levels of E.

    Plans share their beginnings: n choices and B blocks take n + n^2 + ... + n^B block evaluations.
    """
    task = simulation.task
    choices = all_choices(task, SPEEDS)
    count = len(choices.speeds)
    start = simulation.start([np.random.default_rng(0)])
    costs = []
    for k in range(count):  # one first choice at a time keeps the last level small
        state = start.pick([0])
        cost = simulation.step(state, choices.speeds[[k]], choices.executions[[k]])[0][:, COST]
        for _ in range(1, task.blocks):
            state = state.pick(np.repeat(np.arange(len(cost)), count))
            decision = np.tile(choices.speeds, len(cost)), np.tile(choices.executions, len(cost))
            cost = np.repeat(cost, count) + simulation.step(state, *decision)[0][:, COST]
        costs.append(cost)
    every = np.concatenate(costs)
    best, second = np.argsort(every, kind="stable")[:2]
    plan = np.array(np.unravel_index(best, (count,) * task.blocks))
    return Optimum(float(every[best]), choices.speeds[plan], choices.executions[plan], float(every[second]))
