"""What a reward of -1 is worth in a task that does not say: what a block costs by the cheapest of some fixed plans."""

from dataclasses import replace
from itertools import product

import numpy as np

from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.tables import Outcome
from grind_env.envs.tasks import Task

SPEEDS = 12
"""E that divide its range geometrically, if the task has no levels."""
INTERVALS = (1, 2, 3, 5, 8, 12, 20)
"""Blocks from one dress to the next; without any dress, too."""
EPISODES = 16
"""Of each plan."""
COST = Outcome._fields.index("cost")


def usual_cost(task: Task, kind: type[BlockSimulation]) -> float:
    """Mean cost of a block, $, by the cheapest pair of an E and a dress interval for all blocks.

    One execution a dress, on the same few episodes: what lots, stocks and wheels differ in decides what a plan costs.
    """
    simulation = kind(replace(task, reference_cost=1.0))
    low, high = task.action.speed_ends
    tried = [float(round(speed)) for speed in np.geomspace(1000.0 * low, 1000.0 * high, SPEEDS)]
    if task.action.speed_levels is not None:
        tried = [1000.0 * speed for speed in task.action.speed_levels]
    plans = np.array(list(product(tried, (0, *INTERVALS))))
    speeds, every = np.repeat(plans, EPISODES, axis=0).T
    episodes = simulation.start([np.random.default_rng(k % EPISODES) for k in range(len(speeds))])
    cost = np.zeros(len(speeds))
    for block in range(1, task.blocks + 1):
        dresses = (every > 0.0) & (block % np.maximum(every, 1.0) == 0.0)
        cost += simulation.step(episodes, speeds, dresses.astype(float))[0][:, COST]
    return float(cost.reshape(len(plans), EPISODES).mean(axis=1).min()) / task.blocks
