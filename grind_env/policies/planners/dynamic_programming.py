"""Plans for a known noise tape, by forward dynamic programming over classes of states."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation, advance
from grind_env.envs.tasks import Task
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.policies.choices import Decision, all_choices
from grind_env.policies.episode_columns import AREA, COST, ENDS_PART, SCRAP, SECONDS, SURVIVAL, VOLUME

AREA_CLASSES = np.geomspace(0.006, 0.06, 64)  #: edges of the classes of wear-flat area
VOLUME_CLASSES = np.array([20.0, 80.0, 400.0])  #: edges of the classes of specific volume since the dress, mm3/mm
DRESSES = Tally._fields.index("dresses")
SPEEDS = 20
MOST_EXECUTIONS = 2  #: largest number of executions tried in a block; more were never worth their price
#: cost of a state above the cheapest state and two surcharges for executions, $, beyond which a state is dropped:
#: dressing the cheapest state costs less. The plans of eight episodes were the same with and without it, in half the
#: time
MARGIN = 10.0
#: number of episodes planned at once, which limits the memory: an episode has some thousand branches
EPISODES_AT_ONCE = 16

Index = NDArray[np.int64]


class Surcharge(NamedTuple):
    """Surcharges of the search over the true cost, for differences within its classes of states."""

    second: float = 0.0  #: surcharge for time, $/s, because lost time is missing at a later due date
    execution: float = 0.0  #: surcharge for a dress execution, $, because it is missing before a wheel change


def surcharges(task: Task) -> list[Surcharge]:
    """Return the surcharges that are worth trying in a task."""
    seconds = (0.04, 0.08, 0.15) if task.due is not None else (0.0,)
    executions = (6.0, 12.0) if task.wheel_change is not None else (0.0,)
    return [Surcharge(second, execution) for second in seconds for execution in executions]


def forward_plans(simulation: Simulation, start: Episodes, surcharge: Surcharge) -> Decision:
    """Return a cheap plan for each of N episodes with known tapes: E and D of shape (N, steps).

    From every retained state, every E of a grid is tried with every D up to 2. Each class of wear-flat area and volume
    since the dress retains its cheapest new state, unless this costs much more than the cheapest of all.
    """
    every = all_choices(simulation.task, SPEEDS)
    choices = Decision(*(values[every.executions <= MOST_EXECUTIONS] for values in every))
    n = np.arange(len(start.block))
    parts = [
        _forward(simulation, start.pick(chunk), choices, surcharge)
        for chunk in np.array_split(n, -(-len(n) // EPISODES_AT_ONCE))
    ]
    chosen = np.concatenate(parts)
    return Decision(choices.speeds[chosen], choices.executions[chosen])


def _forward(simulation: Simulation, start: Episodes, choices: Decision, surcharge: Surcharge) -> Index:
    """Return the indices of the choices of the plans, shape (N, steps)."""
    count = len(choices.speeds)
    owner, cost, state = np.arange(len(start.block)), np.zeros(len(start.block)), start
    ends, scrap = simulation.kinds[:, ENDS_PART], simulation.kinds[:, SCRAP]
    margin = MARGIN + 2.0 * surcharge.execution
    parents, taken = [], []
    for k in range(simulation.task.blocks):
        if simulation.over(state).all():
            break
        # two rows of tape, so that only the last block is charged for the wheel it leaves behind
        here = state.window(start.tape, owner, k, 2)
        branches = here.pick(np.repeat(np.arange(len(owner)), count))
        decision = np.tile(choices.speeds, len(owner)), np.tile(choices.executions, len(owner))
        outcomes, results = advance(simulation, branches, *decision)
        cost = np.repeat(cost, count) + outcomes[:, COST]
        cost += surcharge.second * outcomes[:, SECONDS] + surcharge.execution * results[:, DRESSES]
        # the lost survival probability of a part in work is charged with its last block, but must count now
        number = simulation.branches.rows_of(here.coming())
        finished = np.repeat(ends[number] > 0.0, count) | simulation.over(branches)
        at_stake = np.where(finished, 0.0, np.repeat(scrap[number], count))
        rank = cost + at_stake * (1.0 - branches.memory[:, SURVIVAL])
        whose = np.repeat(owner, count)
        kept = cheapest_of_each(rank, wheel_class(branches), whose)
        kept = kept[rank[kept] <= rank[cheapest_of_each(rank, whose)][whose[kept]] + margin]
        parents.append(kept // count)
        taken.append(kept % count)
        owner, cost, state = owner[kept // count], cost[kept], branches.pick(kept)
    plan, at = np.empty((len(start.block), len(taken)), np.int64), cheapest_of_each(cost, owner)
    for k in reversed(range(len(taken))):
        plan[:, k], at = taken[k][at], parents[k][at]
    return plan


def wheel_class(episodes: Episodes) -> Index:
    """Return the class of the wheel of each episode, shape (N,)."""
    area = np.digitize(episodes.wheels[:, AREA], AREA_CLASSES)
    return area * (len(VOLUME_CLASSES) + 1) + np.digitize(episodes.wheels[:, VOLUME], VOLUME_CLASSES)


def cheapest_of_each(cost: Array, *groups: Index) -> Index:
    """Return the index of the cheapest member of each group, in the order of the groups (the last key leads)."""
    order = np.lexsort((cost, *groups))
    keys = np.stack(groups)[:, order]
    first = np.ones(len(order), bool)
    first[1:] = (keys[:, 1:] != keys[:, :-1]).any(axis=0)
    return order[first]
