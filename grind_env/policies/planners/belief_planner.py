"""Planner on the belief: tries every choice on possible wheels, with a table of costs for the later blocks."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array, Table
from grind_env.belief.wheel_belief import WheelBelief
from grind_env.envs.episode_state import Episodes
from grind_env.envs.filter_members import MemberModel
from grind_env.envs.observations import LEAST_SLACK
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision, cheapest_choice
from grind_env.policies.episode_columns import COST, PRESSURE
from grind_env.policies.planners.cost_to_go import KA, between, dullness, worth
from grind_env.policies.policy import Sees
from grind_env.policies.scripted.look_ahead import SECONDS, member_roughness, member_wheels

CLEAR = 1e-3  #: tolerance of the log of the slack, which is rounded to single precision


class CostLeft(NamedTuple):
    """Remaining cost of N episodes after the coming part."""

    table: Array  #: table of the remaining cost, $, shape (any, nodes of the axes of `Worth`)
    number: NDArray[np.int64]  #: index on the first axis of `table`, shape (N,)
    margin: Array  #: spare time before the coming block, s, shape (N,)


@dataclass
class BeliefPlanner:
    """Scenario MPC: try every E and D of the coming block on each ensemble member; choose the cheapest on average.

    An ensemble filter estimates the wheel from the power readings (`grind_env.belief`). Each member grinds the coming
    block with every choice, and the rest of the part with the choices of the table of `worth`, by the same compiled
    cycle as the true wheel. The table also gives the cost of the later blocks, from wheel, lot and spare time. Nothing
    is tuned: the table is computed from the simulation.
    """

    members: int = 32  #: size of the ensemble; each member has a wheel, a lot and a roughness
    # number of E tried first in a range of E, geometrically spaced; then `speeds` - 1 between the best E's neighbours
    speeds: int = 10
    name: ClassVar[str] = "belief_planner"
    sees: ClassVar[Sees] = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        if getattr(self, "simulation", None) is not simulation:
            self.table = worth(simulation)
        self.simulation, self.block = simulation, 0
        self.belief = WheelBelief(MemberModel(simulation), self.members)
        self.belief.begin(episodes)
        self.roughness = member_roughness(simulation.task, self.members)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        task, n = self.simulation.task, len(observation)
        burnt = self.belief.update(observation).burnt
        wheels = member_wheels(self.simulation, self.belief, burnt, self.roughness, self.block)
        left = self._left(self.simulation.read(observation))
        best = cheapest_choice(task, n, self.speeds, lambda choices: self._cheapest(wheels, choices, left))
        self.block += 1
        return best

    def _left(self, seen: dict[str, Table]) -> CostLeft:
        """Return the remaining cost after the coming part, from the readings before it."""
        branches, table = self.simulation.branches, self.table
        part, rows = branches.part_from(self.block), table.course.number[self.belief.rows]
        margin = np.zeros(len(rows))
        if table.period:
            to_go = table.period - self.block % table.period
            time = seen["time_to_due"]
            # a slack at the end of its range does not show the work, which is then taken as the mean
            shown = seen["slack"] > np.log(LEAST_SLACK) + CLEAR
            margin = time - np.where(shown, time / np.exp(seen["slack"]), to_go * table.work.mean())
        if part[-1] + 1 >= self.simulation.task.blocks:
            return CostLeft(np.zeros((1, *table.before.shape[2:])), np.zeros_like(rows), margin)
        following = [f"following_{kind.name}" for kind in self.simulation.task.kinds]
        if len(part) == 1 and all(name in seen for name in following):
            kind = np.argmax([seen[name] for name in following], axis=0)
            coming = np.argmax(branches.kind_of_row[table.course.rows] == kind[:, None], axis=1)
            ahead = table.ahead(self.block)
            return CostLeft(ahead.reshape(-1, *ahead.shape[2:]), rows * len(ahead) + coming, margin)
        if len(part) > 1:
            rows = np.full_like(rows, self._number(self.simulation.task.kind_of_block(part[-1])))
        return CostLeft(table.after(part[-1]), rows, margin)

    def _cheapest(self, wheels: Episodes, choices: Decision, left: CostLeft) -> Decision:
        """Return the cheapest of each episode's choices, given as shape (N, C), over its M wheels."""
        task, table, (n, count) = self.simulation.task, self.table, choices.speeds.shape
        branches = wheels.pick(np.repeat(np.arange(n * self.members), count))
        rows, margin = (
            np.repeat(each, self.members * count) for each in (table.course.number[self.belief.rows], left.margin)
        )
        lot = np.log(branches.tape[:, 0, KA]), np.log(branches.tape[:, 0, PRESSURE])
        decision = Decision(*(np.repeat(values, self.members, axis=0).ravel() for values in choices))
        cost = np.zeros(len(margin))
        for block in self.simulation.branches.part_from(self.block):
            if block > self.block:
                rows = np.full_like(rows, self._number(task.kind_of_block(block)))
                decision = table.choose(block, rows, *table.places(*lot, dullness(branches.wheels), margin))
            outcomes, _ = self.simulation.step(branches, *decision)
            cost += outcomes[:, COST]
            margin = margin + table.work[rows] - outcomes[:, SECONDS]
        number = np.repeat(left.number, self.members * count)
        cost += between(left.table, number, *table.places(*lot, dullness(branches.wheels), margin))
        best = cost.reshape(n, self.members, count).mean(axis=1).argmin(axis=1)
        return Decision(choices.speeds[np.arange(n), best], choices.executions[np.arange(n), best])

    def _number(self, kind: int) -> int:
        return int(np.argmax(self.simulation.branches.kind_of_row[self.table.course.rows] == kind))
