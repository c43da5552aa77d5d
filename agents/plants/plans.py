"""Fixed plans, from which somebody who could try them all would take the best."""

from itertools import product

from grind_env.envs.job.outline import Choice
from grind_env.envs.job.simulation import JobSimulation
from grind_env.shop.advise.rehearsal import Decide
from grind_env.training.rivals import EVERY, RATIOS, Programmed


def plans(simulation: JobSimulation) -> list[Decide]:
    """15 of them."""
    return [_decide(Programmed(*plan), simulation) for plan in product(RATIOS, EVERY)]


def _decide(plan: Programmed, simulation: JobSimulation) -> Decide:
    plan.begin(simulation, 1)
    return lambda number, readings: Choice(float(plan.speeds[number]), int(plan.executions[number]))
