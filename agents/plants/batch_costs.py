"""Batches with E and D of any decider: cost, and number of limits exceeded twice in a row."""

from collections.abc import Callable, Sequence

import numpy as np

from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.shop.advise.rehearsal import LOTS, BatchResult, Decide, ground

EARLY = 14
"""Number of first parts in which an adviser still has few readings."""


def batches(simulation: JobSimulation, decider: Callable[[], Decide], episodes: int) -> list[BatchResult]:
    """Grind batches, each with its own decider, on the same lots."""
    return [ground(simulation, decider(), LOTS + number) for number in range(episodes)]


def cost_of(found: Sequence[BatchResult]) -> float:
    """Return the mean cost of a part in some batches, $."""
    return float(np.mean([each.cost.mean() for each in found]))


def numbers_of(batch: BatchResult, simulation: JobSimulation) -> dict[str, float]:
    """Return the numbers of a batch for the tables; `late` is the mean cost of a part from the 15th on, $."""
    job, lowest = simulation.job, simulation.task.action.speed_ends[0]
    power = np.array([(each.peak_power or 0.0) / job.limits.power for each in batch.readings])
    # for each part: the larger of size error and Ra over its limit, and whether E is least and the wheel is dressed
    gauged, slowest = np.zeros(simulation.parts), np.zeros(simulation.parts, bool)
    for number, (block, readings) in enumerate(zip(simulation.blocks, batch.readings, strict=True)):
        slowest[block.part] = batch.speeds[number] <= lowest and batch.executions[number] > 0
        if readings.size_error is not None and job.part.tolerance > 0.0:
            gauged[block.part] = abs(readings.size_error) / job.part.tolerance
        if readings.Ra_before is not None and block.part > 0 and job.limits.roughness > 0.0:
            gauged[block.part - 1] = max(gauged[block.part - 1], readings.Ra_before / job.limits.roughness)
    beyond, off = power > 1.0, gauged > 1.0
    return {
        "cost": float(batch.cost.mean()),
        "late": float(batch.cost[EARLY:].mean()),
        "scrap": float(batch.scrap.mean()),
        "in_a_row": float((beyond[1:] & beyond[:-1]).sum()),
        "parts_in_a_row": float((off[1:] & off[:-1] & ~slowest[1:]).sum()),
        "dresses": float(batch.executions.sum()),
    }
