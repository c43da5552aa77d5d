"""Fixed plans, from which somebody who could try them all would take the best."""

from itertools import product, repeat

from agents.plants.shift import BatchResult, Decide, batches, cost_of
from grind_env.envs.job.outline import JobChoice
from grind_env.envs.job.simulation import JobSimulation

RATIOS = (0.6, 0.8, 1.0, 1.25, 1.6)
"""E over that of the program, in all blocks."""
EVERY = (1, 2, 4)
"""Parts from one that is dressed to the next, in its first block that can be."""


def plans(simulation: JobSimulation) -> list[Decide]:
    """15 of them."""
    return [_plan(simulation, ratio, every) for ratio, every in product(RATIOS, EVERY)]


def best_plan(simulation: JobSimulation, episodes: int) -> list[BatchResult]:
    """Return the batches of the plan that costs least in them."""
    planned = [batches(simulation, repeat(plan).__next__, episodes) for plan in plans(simulation)]
    return min(planned, key=cost_of)


def _plan(simulation: JobSimulation, ratio: float, every: int) -> Decide:
    blocks = simulation.blocks
    first = {block.part: k for k, block in reversed([*enumerate(blocks)]) if block.takes_dresses}
    low, high = (1000.0 * end for end in simulation.task.action.speed_ends)

    def decide(number: int, readings: object) -> JobChoice:
        block = blocks[number]
        dresses = first.get(block.part) == number and block.part % every == 0
        speed = min(max(ratio * block.plan.feed, low), high)
        return JobChoice(speed, max(int(block.plan.dresses), 1) if dresses else 0)

    return decide
