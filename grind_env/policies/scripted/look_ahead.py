"""One-block look-ahead on the belief, with a price for the dullness of the wheel after the block."""

from dataclasses import dataclass
from statistics import NormalDist
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.belief.wheel_belief import WheelBelief
from grind_env.envs.cost import Outcome
from grind_env.envs.episode_state import Episodes
from grind_env.envs.filter_members import MemberModel
from grind_env.envs.past_readings import History
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.policies.choices import Decision, cheapest_choice
from grind_env.policies.episode_columns import AREA, COST, LOADING, PRESSURE, ROUGHNESS
from grind_env.policies.policy import Sees
from grind_env.policies.scripted.handbook import handbook_speeds
from grind_env.policies.scripted.rules import LOADED_AREA, REFERENCE_AREA
from grind_env.policies.scripted.sharpness_estimator import thrift

MEMBERS = 8  #: number of wheels on which a choice is tried: as many as the kernel runs at a time
HASTE_WIDTH = 0.1  #: width of the change from a safe to a lost due date, in the log of work over time left

SECONDS, SCRAP = (Outcome._fields.index(name) for name in ("seconds", "scrap_cost"))
SURVIVAL, DRESSES = (History._fields.index(name) for name in ("survival", "dresses"))


class Prices(NamedTuple):
    """Prices in addition to the cost of the coming block; each shape (N,)."""

    wheel: Array  #: price of a wheel of reference dullness left behind, $
    growth: Array  #: exponent of the price of the wheel
    second: Array  #: price of time that is missing for due dates, $/s
    execution: Array  #: price of a dress execution on a wheel that has to last, $


def member_roughness(task: Task, members: int) -> Array:
    """Return the factor of each member on the roughness of a part, shape (members,).

    Power does not show these factors, so the members divide their spread evenly.
    """
    levels = [NormalDist().inv_cdf((m + 0.5) / members) for m in range(members)]
    return np.asarray(np.exp(np.hypot(task.spread.wheel_roughness, task.spread.part_roughness) * np.array(levels)))


def member_wheels(simulation: Simulation, belief: WheelBelief, burnt: Array, roughness: Array, block: int) -> Episodes:
    """Return every member of every episode as a separate episode, from a block to the end of the part.

    Args:
        simulation: simulation that the belief follows.
        belief: belief of N episodes.
        burnt: probability that the last block burnt the part, shape (N,).
        roughness: roughness factors of the members.
        block: number of the coming block.
    """
    members = len(roughness)
    everyone = np.arange(len(burnt) * members)
    wheels: Episodes = belief.members.pick(everyone)
    belief.model.write_factors(wheels, everyone, belief.factors().reshape(len(everyone), -1))
    wheels.tape[:, 0, ROUGHNESS] = np.tile(roughness, len(burnt))
    wheels.memory[:] = 0.0
    wheels.memory[:, SURVIVAL] = 1.0 - np.repeat(burnt, members)
    return simulation.branches.lengthened(wheels, simulation.branches.part_from(block))


@dataclass(kw_only=True)
class LookAhead:
    """Policy that tries every E and D of the coming block on possible wheels and chooses the cheapest on average.

    A process engineer with a simulator beside the machine could do this. An ensemble filter estimates the wheel from
    the power readings (`grind_env.belief`), and each member grinds the coming block with every choice, by the same
    compiled cycle as the true wheel. A part that continues after the block is followed to its end, with the last E of
    such blocks and with or without a dress, whichever is cheaper. The wheel at the end adds a price, in dress
    executions: price[kind] (s / 0.015)^growth[kind] with the dullness s = (A + 0.02 lam) pm. At the end of an episode
    the task itself charges the wheel.
    """

    price: tuple[float, ...]  # price of a wheel of reference dullness, in dress executions, by kind of the coming block
    growth: tuple[float, ...]  #: exponent of the price, by kind of the coming block
    caution: float = 1.0  #: factor on the price of scrap, because few wheels include few of the worst
    haste: float = 0.0  #: price of lost time before a due date, in prices of lateness
    calm: float = 0.0  #: log of the work over the time left at which the chance of a late date is one half
    layer: float = 0.0  #: price of a dress execution, in wheel changes, when as many executions as blocks are left
    scarcity: float = 0.0  #: exponent by which this price rises as fewer executions are left
    # number of E tried first in a range of E, geometrically spaced; then `speeds` - 1 between the best E's neighbours
    speeds: int = 8
    name: ClassVar[str] = "look_ahead"
    sees: ClassVar[Sees] = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        task = simulation.task
        self.simulation, self.belief, self.block = simulation, WheelBelief(MemberModel(simulation), MEMBERS), 0
        self.belief.begin(episodes)
        self.roughness = member_roughness(task, MEMBERS)
        self.usual = np.tile(handbook_speeds(task), (episodes, 1))

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        task, n = self.simulation.task, len(observation)
        burnt = self.belief.update(observation).burnt
        prices = self._prices(self.simulation.read(observation))
        wheels = member_wheels(self.simulation, self.belief, burnt, self.roughness, self.block)
        kind = self._kind()
        best = cheapest_choice(task, n, self.speeds, lambda choices: self._cheapest(wheels, choices, prices))
        self.usual[np.arange(n), kind] = best.speeds
        self.block += 1
        return best

    def _prices(self, seen: dict[str, Array]) -> Prices:
        task, kind = self.simulation.task, self._kind()
        nothing = np.zeros(len(kind))
        second, execution = nothing, nothing
        if task.due is not None:
            lost = 1.0 / (1.0 + np.exp((seen["slack"] + self.calm) / HASTE_WIDTH))
            second = self.haste * task.due.late / 3600.0 * lost
        if task.wheel_change is not None:
            left = thrift(seen["executions_left"], np.full(len(kind), task.blocks - self.block))
            execution = self.layer * task.wheel_change.price * np.exp(-self.scarcity * left)
        # the last part of an episode leaves a wheel that the task itself charges
        branches = self.simulation.branches
        charged = 0.0 if branches.part_from(self.block)[-1] + 1 == task.blocks else branches.dress_price
        return Prices(charged * np.array(self.price)[kind], np.array(self.growth)[kind], second, execution)

    def _kind(self) -> NDArray[np.int64]:
        return self.simulation.branches.kind_of_row[self.belief.rows]

    def _cheapest(self, wheels: Episodes, choices: Decision, prices: Prices) -> Decision:
        """Return the cheapest of each episode's choices, given as shape (N, C), over its M wheels."""
        n, count = choices.speeds.shape
        m = len(wheels.block) // n
        branches = wheels.pick(np.repeat(np.arange(n * m), count))
        cost = self._step(branches, Decision(*(np.repeat(values, m, axis=0).ravel() for values in choices)), prices)
        task, part = self.simulation.task, self.simulation.branches.part_from(self.block)
        later = [task.kind_of_block(block) for block in part[1:]]
        totals = []
        for dresses in (0.0, 1.0) if later else (0.0,):
            ahead = branches.pick(np.arange(len(cost))) if later else branches
            total = cost.copy()
            for number in later:
                speeds = np.repeat(self.usual[:, number], m * count)
                total += self._step(ahead, Decision(speeds, np.full(len(cost), dresses)), prices)
            total += self._left_behind(ahead, prices)
            totals.append(total.reshape(n, m, count).mean(axis=1))
        best = np.min(totals, axis=0).argmin(axis=1)
        return Decision(choices.speeds[np.arange(n), best], choices.executions[np.arange(n), best])

    def _step(self, branches: Episodes, decision: Decision, prices: Prices) -> Array:
        """Grind a block in every branch; return its cost, with time and executions at their prices, $."""
        before = branches.memory[:, DRESSES].copy()
        outcomes, _ = self.simulation.step(branches, *decision)
        share = len(before) // len(prices.second)
        second, execution = np.repeat(prices.second, share), np.repeat(prices.execution, share)
        dressed = branches.memory[:, DRESSES] - before
        cost = outcomes[:, COST] + (self.caution - 1.0) * outcomes[:, SCRAP]
        return np.asarray(cost + second * outcomes[:, SECONDS] + execution * dressed)

    def _left_behind(self, branches: Episodes, prices: Prices) -> Array:
        """Return the price of the wheel at the end of each branch, $."""
        share = len(branches.block) // len(prices.wheel)
        dullness = branches.wheels[:, AREA] + LOADED_AREA * branches.wheels[:, LOADING]
        worth = (dullness * branches.tape[:, 0, PRESSURE] / REFERENCE_AREA) ** np.repeat(prices.growth, share)
        return np.asarray(np.repeat(prices.wheel, share) * worth)
