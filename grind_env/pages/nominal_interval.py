"""The best dress interval of the nominal episode, from which a task page recommends its discount factor.

A dress costs at once and pays off until the next dress. The interval n is found on the nominal episode, without
randomness: it belongs to the cheapest of all plans with one table speed and one dress every n steps.
"""

import numpy as np

from grind_env.envs.cost import Outcome
from grind_env.envs.reset_options import Given
from grind_env.envs.simulation import Simulation, advance

SAVINGS_LEFT = 0.9  #: share at which the savings of a dress still count at the end of the interval
SPEEDS = 8  #: number of table speeds tried
GROWTH = 1.25  #: ratio of one interval tried to the one before; short intervals grow by one step

COST = Outcome._fields.index("cost")


def dress_interval(simulation: Simulation, nominal: Given) -> int:
    """Return the steps between dresses of the cheapest plan of the nominal episode; all steps if no dress pays."""
    steps, action = simulation.task.blocks, simulation.task.action
    if action.executions == 0:
        return steps
    speeds = np.floor(np.array(action.speed_levels or np.geomspace(*action.speed_ends, SPEEDS)) + 0.5)
    E, every = (grid.ravel() for grid in np.meshgrid(speeds, intervals(steps)))
    rngs = [np.random.default_rng(0) for _ in E]
    episodes = simulation.start(rngs, [nominal] * len(E))
    cost, done = np.zeros(len(E)), 0
    while not simulation.over(episodes).all():
        D = np.where((done > 0) & (done % every == 0), 1.0, 0.0)
        cost += advance(simulation, episodes, *simulation.applied_choice(episodes, (E, D)))[0][:, COST]
        done += 1
    return min(int(every[cost.argmin()]), done)


def intervals(steps: int) -> list[int]:
    """Return the intervals that are tried in an episode of `steps` steps; with the last one there is no dress."""
    found = [1]
    while found[-1] < steps:
        found.append(min(max(found[-1] + 1, round(GROWTH * found[-1])), steps))
    return found
