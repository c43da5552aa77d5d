"""Table of the remaining cost of an episode: dynamic programming on the model, once per simulation.

Axes are block, kind of the coming block, lot (dulling rate and pressure of wear flats), dullness of the wheel and, in
tasks with due dates, spare time. Costs and transitions come from the compiled cycle, tried with every E and D
of a grid on wheels, lots and stocks that the task draws. So the table needs no tuning and holds for any simulated task,
material or machine. It assumes a known state from the next block on, as QMDP does (Littman, Cassandra, Kaelbling, ICML
1995), and usual values for all else.
"""

from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from grind_env.array_types import Array, Numbers
from grind_env.belief.filter_quantities import FACTORS
from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.cost import Outcome
from grind_env.envs.episode_state import Episodes
from grind_env.envs.filter_members import MemberModel
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.past_readings import History
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision, all_choices
from grind_env.policies.episode_columns import AREA, COST, LOADING, NEW_LOT, NOMINAL_STOCK, PRESSURE, STOCK
from grind_env.policies.scripted.handbook import handbook_speeds
from grind_env.policies.scripted.rules import LOADED_AREA

EPISODES = 128  #: number of sampled episodes in which lots, stocks and the order of kinds are counted
#: numbers of E, levels of dullness, scenarios of stock and roughness, levels of spare time, and due dates tried
SPEEDS, DULL, SCENARIOS, MARGINS, DATES = 12, 16, 16, 9, 4
DOUBT = 0.6  #: share of the variation of lots that a belief leaves open: with known lots the table would dress too late
#: quantiles of the dulling rate and of the pressure at which lots are tried
GROWTH, PRESS = (0.0, 0.2, 0.5, 0.8, 1.0), (0.0, 0.5, 1.0)
MARGIN = (-0.75, 1.25)  #: least and largest spare time, over the work between two due dates
#: largest number of blocks without a dress, and ratio of the dullest wheel of the table to a dressed wheel
LONGEST, DULLEST = 400, 12.0
SLOWLY = np.array([[0.3, *[1.0] * (len(FACTORS) - 1)]])  #: factors of a lot that dulls the wheel in small steps
LEAST = 1e-6  #: least dullness, for a wheel without flats and loading

KA = TapeRow._fields.index("kA")
ENDS_PART, SCRAP = KindRow._fields.index("ends_part"), KindRow._fields.index("scrap")
SURVIVAL = History._fields.index("survival")
HANDOVER, SECONDS = (Outcome._fields.index(name) for name in ("handover_cost", "seconds"))


class AxisPlace(NamedTuple):
    """Places of numbers between two nodes of an axis; both fields have the shape of the numbers."""

    below: Numbers
    share: Array  #: share of the node above


def place(axis: Array, values: Array, *, beyond: bool = False) -> AxisPlace:
    """Return the places of values between nodes of an axis; values outside are clipped, or extrapolated if `beyond`."""
    if len(axis) == 1:
        return AxisPlace(np.zeros(np.shape(values), np.int64), np.zeros(np.shape(values)))
    below = np.clip(np.searchsorted(axis, values) - 1, 0, len(axis) - 2)
    share = (values - axis[below]) / (axis[below + 1] - axis[below])
    return AxisPlace(below, share if beyond else np.clip(share, 0.0, 1.0))


def between(table: Array, first: Numbers, *places: AxisPlace) -> Array:
    """Interpolate in a table of shape (any, nodes of each axis).

    Args:
        table: the table.
        first: indices on the first axis of the table.
        places: places on the other axes; all of one shape.
    """
    total = np.zeros(np.shape(first))
    for corner in range(1 << len(places)):
        index, weight = [first], np.ones(np.shape(first))
        for k, at in enumerate(places):
            above = corner >> k & 1
            index.append(np.minimum(at.below + above, table.shape[k + 1] - 1))
            weight = weight * (at.share if above else 1.0 - at.share)
        total += weight * table[tuple(index)]
    return total


def dullness(wheels: Array) -> Array:
    """Return the log of A + 0.02 lam of wheels, shape (..., fields of `WheelState`)."""
    return np.asarray(np.log(np.maximum(wheels[..., AREA] + LOADED_AREA * wheels[..., LOADING], LEAST)))


class Coming(NamedTuple):
    """Frequencies of coming blocks in episodes of a simulation, counted in a sample."""

    rows: Numbers  #: rows of `Simulation.kinds`, in the order of the tables
    #: index in `rows` of every row of `Simulation.kinds`; a row that does not come gets the first index of its kind
    number: Numbers
    follows: Array  #: probability of the second row after the first row, shape (rows, rows)
    anew: Array  #: probability that the second row then begins a lot, shape (rows, rows)
    growth: Array  #: log of the sampled dulling rates of lots and wheels, shape (any,)
    pressure: Array  #: log of the sampled factors on the pressure of wear flats, shape (any,)
    #: stock over nominal stock, and `FACTORS` (first two: the belief's doubt), shape (rows, scenarios, 1 + factors)
    scenarios: Array


def course(simulation: Simulation) -> Coming:
    """Return the frequencies of coming blocks."""
    start = simulation.start([np.random.default_rng(k) for k in range(EPISODES)])
    tape, numbers = start.tape, simulation.branches.rows_of(start.tape)
    rows = np.unique(numbers)
    at = np.searchsorted(rows, numbers)
    follows, new = np.zeros((len(rows), len(rows))), np.zeros((len(rows), len(rows)))
    np.add.at(follows, (at[:, :-1], at[:, 1:]), 1.0)
    np.add.at(new, (at[:, :-1], at[:, 1:]), tape[:, 1:, NEW_LOT])
    # every quantity has each quantile once, in its own random order
    levels, rng = (np.arange(SCENARIOS) + 0.5) / SCENARIOS, np.random.default_rng(0)
    fields = [STOCK, *(TapeRow._fields.index(name) for name in FACTORS)]
    scenarios = np.stack([np.quantile(tape[at == k][:, fields], levels, axis=0) for k in range(len(rows))])
    scenarios[..., 0] /= simulation.kinds[rows, NOMINAL_STOCK][:, None]
    normal = np.array([NormalDist().inv_cdf(level) for level in levels])[:, None]
    growth, pressure = (np.log(tape[..., field]).ravel() for field in (KA, PRESSURE))
    scenarios[..., 1:3] = np.exp(DOUBT * normal * [growth.std(), pressure.std()])
    scenarios = rng.permuted(scenarios, axis=1)
    kinds = simulation.branches.kind_of_row
    number = np.argmax(kinds[rows] == kinds[:, None], axis=1)
    number[rows] = np.arange(len(rows))
    return Coming(
        rows,
        number,
        follows / np.maximum(follows.sum(axis=1, keepdims=True), 1.0),
        new / np.maximum(follows, 1.0),
        growth,
        pressure,
        scenarios,
    )


class Tried(NamedTuple):
    """Mean results of every choice in every state over scenarios; shape (rows, growth, pressure, dull, choices)."""

    cost: Array  #: cost without the price of the wheel left behind, $
    handover: Array  #: price of the wheel left behind if the episode ends, $
    dull: Array  #: log of the dullness after the block
    seconds: Array  #: time of the block, s


@dataclass(frozen=True)
class Worth:
    """Table of the remaining cost of an episode with the cheapest later choices, $."""

    course: Coming  #: frequencies of coming blocks
    growth: Array  #: nodes of the log of the dulling rate
    pressure: Array  #: nodes of the log of the factor on the pressure of wear flats
    dull: Array  #: nodes of the log of the dullness
    margin: Array  #: spare time before the next due date beyond the nominal work, s; one node in a task without dates
    lots: Array  #: probability of each growth and pressure, shape (growth, pressure)
    period: int  #: number of blocks from due date to due date; 0 without due dates
    dates: Array  #: probabilities of the margins after a date, by the margin before, shape (margin, margin)
    late: Array  #: cost of each margin at a date, $
    work: Array  #: nominal time of a block of each row, s, from which due dates are made
    choices: Decision  #: all choices of E and D
    before: Array  #: remaining cost before a block, $, shape (blocks + 1, rows, growth, pressure, dull, margin)
    cheapest: Numbers  #: index of the best choice, shape (blocks, rows, growth, pressure, dull, margin)

    def ahead(self, block: int) -> Array:
        """Return the cost after a block, by its row and the next block's: shape (rows, rows, nodes of each axis)."""
        later = self.before[block + 1]
        unknown = np.einsum("gp,rgpxz->rxz", self.lots, later)[:, None, None]
        anew = self.course.anew[:, :, None, None, None, None]
        left = (1.0 - anew) * later[None] + anew * unknown[None]
        if self.period and (block + 1) % self.period == 0:
            left = left @ self.dates.T + self.late
        return np.asarray(left)

    def after(self, block: int) -> Array:
        """Return the mean cost after a block over the next rows, shape (rows, nodes of each axis)."""
        return np.asarray(np.einsum("qr,qrgpxz->qgpxz", self.course.follows, self.ahead(block)))

    def places(
        self, growth: Array, pressure: Array, dull: Array, margin: Array
    ) -> tuple[AxisPlace, AxisPlace, AxisPlace, AxisPlace]:
        return (
            place(self.growth, growth),
            place(self.pressure, pressure),
            place(self.dull, dull),
            place(self.margin, margin, beyond=True),
        )

    def choose(self, block: int, rows: Numbers, *places: AxisPlace) -> Decision:
        """Return the best choice at the upper nodes: no wheel counts as sharper, and no lot as milder, than it is."""
        above = (np.where(each.share > 0.0, each.below + 1, each.below) for each in places)
        ends = zip(above, self.before.shape[2:], strict=True)
        best = self.cheapest[(block, rows, *(np.minimum(k, n - 1) for k, n in ends))]
        return Decision(self.choices.speeds[best], self.choices.executions[best])


def worth(simulation: Simulation) -> Worth:
    """Return the table of a simulation whose steps are compiled blocks."""
    task, found, model = simulation.task, course(simulation), MemberModel(simulation)
    growth, pressure = (
        np.unique(np.round(np.quantile(values, levels), 6))
        for values, levels in ((found.growth, GROWTH), (found.pressure, PRESS))
    )
    lots = spread_over(growth, found.growth).T @ spread_over(pressure, found.pressure) / len(found.growth)
    wheels, choices = dulling(model, found.rows), all_choices(task, SPEEDS)
    states = np.meshgrid(growth, pressure, np.arange(len(wheels)), np.arange(len(choices.speeds)), indexing="ij")
    tried = Tried(
        *np.stack([_tried(model, found, k, wheels, choices, *states) for k in range(len(found.rows))], axis=1)
    )
    period, margin, dates, late, work = 0, np.zeros(1), np.ones((1, 1)), np.zeros(1), np.zeros(len(found.rows))
    if task.due is not None:
        period = task.due.blocks
        work = simulation.branches.seconds(found.rows, np.full(len(found.rows), task.due.speed))
        usual = float(work.mean()) * period
        margin = usual * np.linspace(*MARGIN, MARGINS)
        slack = np.linspace(*task.due.slack, 2 * DATES + 1)[1::2]
        dates = np.mean([spread_over(margin, margin + (each - 1.0) * usual) for each in slack], axis=0)
        late = task.due.late / 3600.0 * np.maximum(-margin, 0.0)
    shape = (len(found.rows), len(growth), len(pressure), len(wheels), len(margin))
    before, cheapest = np.zeros((task.blocks + 1, *shape)), np.zeros((task.blocks, *shape), np.int64)
    table = Worth(
        found, growth, pressure, dullness(wheels), margin, lots, period, dates, late, work, choices, before, cheapest
    )
    rows, g, p = (np.arange(n).reshape(-1, *[1] * (4 - k)) for k, n in enumerate(shape[:3]))
    dull = place(table.dull, tried.dull)
    passed = work[:, None, None, None, None] - tried.seconds
    for block in reversed(range(task.blocks)):
        left, last = table.after(block), block + 1 == task.blocks
        for k, hand in enumerate(margin):
            later = place(margin, hand + passed, beyond=True)
            total = tried.cost + (tried.handover if last else 0.0)
            for x, share in ((dull.below, 1.0 - dull.share), (np.minimum(dull.below + 1, len(wheels) - 1), dull.share)):
                for z, part in ((later.below, 1.0 - later.share), (later.below + 1, later.share)):
                    total = total + share * part * left[rows, g, p, x, np.minimum(z, len(margin) - 1)]
            cheapest[block, ..., k] = total.argmin(axis=-1)
            before[block, ..., k] = total.min(axis=-1)
    return table


def spread_over(axis: Array, values: Array) -> Array:
    """Return the interpolation weights of the nodes of an axis for each value, shape (values, nodes)."""
    at, index = place(axis, values, beyond=True), np.arange(len(values))
    shares = np.zeros((len(values), len(axis)))
    shares[index, at.below] += 1.0 - at.share
    shares[index, np.minimum(at.below + 1, len(axis) - 1)] += at.share
    return shares


def dulling(model: MemberModel, rows: Numbers) -> Array:
    """Return wheels from freshly dressed to very dull, shape (dull, fields of `WheelState`)."""
    task = model.simulation.task
    member = model.empty_episodes(1)
    model.simulation.clear(member, np.zeros(1, np.int64))
    member.wheels[:, : model.branches.first_wheels(1).shape[1]] = model.branches.first_wheels(1)
    usual = handbook_speeds(task)
    seen = [member.wheels[0].copy()]
    for k in range(LONGEST):
        row = rows[k % len(rows)][None]
        _grind(model, member, row, np.ones(1), SLOWLY, usual[model.branches.kind_of_row[row]], 0.0)
        seen.append(member.wheels[0].copy())
        if dullness(seen[-1]) > dullness(seen[0]) + np.log(DULLEST):
            break
    found = np.array(seen)
    dull = np.maximum.accumulate(dullness(found))
    picked = np.unique(np.searchsorted(dull, np.linspace(dull[0], dull[-1], DULL)).clip(max=len(found) - 1))
    return np.asarray(found[picked[np.concatenate([[True], np.diff(dull[picked]) > 0.0])]])


def _tried(
    model: MemberModel, found: Coming, k: int, wheels: Array, choices: Decision, *states: Array
) -> tuple[Array, ...]:
    """Return the fields of `Tried` for the row of index k."""
    shape = (*states[0].shape, SCENARIOS)
    growth, pressure, wheel, choice = (np.repeat(each.ravel(), SCENARIOS) for each in states)
    n = len(growth)
    scenario = np.arange(n) % SCENARIOS
    members = model.empty_episodes(1).pick(np.zeros(n, np.int64))
    model.simulation.clear(members, np.arange(n))
    members.wheels[:, : wheels.shape[1]] = wheels[wheel.astype(np.int64)]
    factors = found.scenarios[k][scenario, 1:]
    factors[:, 0] *= np.exp(growth)
    factors[:, 1] *= np.exp(pressure)
    index, row = choice.astype(np.int64), np.full(n, found.rows[k])
    decision = choices.speeds[index], choices.executions[index]
    outcomes = _grind(model, members, row, found.scenarios[k][scenario, 0], factors, *decision)
    kind = model.simulation.kinds[found.rows[k]]
    cost = outcomes[:, COST] - outcomes[:, HANDOVER]
    if kind[ENDS_PART] == 0.0:
        # the lost survival probability of a part in work is charged with its last block, but must count now
        cost = cost + kind[SCRAP] * (1.0 - members.memory[:, SURVIVAL])
    each = cost, outcomes[:, HANDOVER], dullness(members.wheels), outcomes[:, SECONDS]
    return tuple(values.reshape(shape).mean(axis=-1) for values in each)


def _grind(
    model: MemberModel, members: Episodes, rows: Numbers, stocks: Array, factors: Array, speeds: Array, executions: Any
) -> Array:
    """Grind a block in every member, as the first block of a part; return the outcomes."""
    everyone = np.arange(len(rows))
    model.branches.load(members, everyone, rows, stocks)
    model.write_factors(members, everyone, factors)
    members.memory[:] = 0.0
    members.memory[:, SURVIVAL] = 1.0
    return model.simulation.step(members, speeds, np.broadcast_to(executions, speeds.shape).astype(np.float64))[0]
