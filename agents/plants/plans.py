"""Fixed plans, from which somebody who could try them all would take the best."""

from itertools import product, repeat

from grind_env.envs.job.outline import JobChoice
from grind_env.envs.job.simulation import JobSimulation
from grind_env.shop.advise.rehearsal import BatchResult, Decide, batches, cost_of
from grind_env.training.rivals import EVERY, RATIOS, Programmed


def plans(simulation: JobSimulation) -> list[Decide]:
    """15 of them."""
    return [_decide(Programmed(*plan), simulation) for plan in product(RATIOS, EVERY)]


def best_plan(simulation: JobSimulation, episodes: int) -> list[BatchResult]:
    """Return the batches of the plan that costs least in them."""
    planned = [batches(simulation, repeat(plan).__next__, episodes) for plan in plans(simulation)]
    return min(planned, key=cost_of)


def _decide(plan: Programmed, simulation: JobSimulation) -> Decide:
    plan.begin(simulation, 1)
    return lambda number, readings: JobChoice(float(plan.speeds[number]), int(plan.executions[number]))
