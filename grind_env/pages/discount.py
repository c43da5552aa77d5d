"""The discount factor that a task page recommends, from how long a dress pays.

A dress costs at once and pays until the next one. How far apart they stand is worked out on the nominal episode, in
which nothing is left to chance: of all plans with one table speed and one execution every n steps the cheapest says n.
"""

import numpy as np

from grind_env.envs.contexts import Given
from grind_env.envs.cost import Outcome
from grind_env.envs.simulation import Simulation, advance

KEPT = 0.9
"""Share that is left, at the end of the interval, of what a dress saves there."""
SPEEDS = 8
"""Table speeds tried."""
GROWTH = 1.25
"""At least from one interval tried to the next."""

COST = Outcome._fields.index("cost")


def dress_interval(simulation: Simulation, nominal: Given) -> int:
    """Steps from dress to dress of the cheapest plan of the nominal episode; all steps where none is worthwhile."""
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
        cost += advance(simulation, episodes, *simulation.taken(episodes, (E, D)))[0][:, COST]
        done += 1
    return min(int(every[cost.argmin()]), done)


def intervals(steps: int) -> list[int]:
    """Return the intervals that are tried in an episode of that many steps; the last one never dresses."""
    found = [1]
    while found[-1] < steps:
        found.append(min(max(found[-1] + 1, round(GROWTH * found[-1])), steps))
    return found
