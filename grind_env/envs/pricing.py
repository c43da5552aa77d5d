"""What a reward of -1 is worth in a task that does not say: what a block costs by the cheapest of some fixed plans."""

from dataclasses import replace
from itertools import product

import numpy as np

from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.tables import Outcome
from grind_env.envs.tasks import Spread, Task

SPEEDS = 12
"""E that divide its range geometrically, if the task has no levels."""
INTERVALS = (1, 2, 3, 5, 8, 12, 20)
"""Blocks from one dress to the next; without any dress, too."""
COST = Outcome._fields.index("cost")


def usual_cost(task: Task, kind: type[BlockSimulation]) -> float:
    """Mean cost of a block, $, by the cheapest pair of an E and a dress interval for all blocks.

    On the nominal wheel and parts, with exact gauges, one execution a dress.

    Args:
        task: its `reference_cost` is not read.
        kind: what steps its blocks.
    """
    simulation = kind(replace(task, spread=Spread(), reference_cost=1.0))
    plans = np.array(list(product(_speeds(task), (0, *INTERVALS))))
    n = len(plans)
    episodes = simulation.start([np.random.default_rng(0) for _ in range(n)])
    cost = np.zeros(n)
    for block in range(1, task.blocks + 1):
        dresses = (plans[:, 1] > 0) & (block % np.maximum(plans[:, 1], 1) == 0)
        cost += simulation.step(episodes, plans[:, 0], dresses.astype(float))[0][:, COST]
    return float(cost.min()) / task.blocks


def _speeds(task: Task) -> list[float]:
    if task.action.speed_levels is not None:
        return [1000.0 * speed for speed in task.action.speed_levels]
    low, high = task.action.speed_ends
    return [float(round(speed)) for speed in np.geomspace(1000.0 * low, 1000.0 * high, SPEEDS)]
