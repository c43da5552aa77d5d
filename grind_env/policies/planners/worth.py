"""The value of a wheel before and after every block: dynamic programming on the model, once per episode.

A table over the blocks of an episode, the kind of the coming block, the lot (dulling rate and pressure of wear flats),
the dullness of the wheel, and in tasks with due dates the spare time. Costs and transitions come from the compiled
cycle, tried with every E and D of a grid on wheels, lots and stocks that the task draws; so the table needs no tuning
and holds for any simulated task, material or machine. It assumes that the state is known from the next block on, as
QMDP does (Littman, Cassandra, Kaelbling, ICML 1995), and usual values for all else.
"""

from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from grind_env.arrays import Array, Numbers
from grind_env.belief.hidden import FACTORS
from grind_env.envs.cost import Outcome
from grind_env.envs.episodes import Episodes
from grind_env.envs.history import History
from grind_env.envs.model import MemberModel
from grind_env.envs.simulation import Simulation
from grind_env.envs.tables import KindRow
from grind_env.envs.tape import TapeRow
from grind_env.policies.choices import Decision, all_choices
from grind_env.policies.columns import AREA, COST, LOADING, NEW_LOT, PRESSURE, STOCK
from grind_env.policies.policy import NOMINAL_STOCK
from grind_env.policies.scripted.handbook import handbook_speeds
from grind_env.policies.scripted.rules import LOADED_AREA

EPISODES = 128
"""Episodes in which lots, stocks and the order of kinds are counted."""
SPEEDS, DULL, SCENARIOS, MARGINS, DATES = 12, 16, 16, 9, 4
"""E tried; levels of dullness; stocks and roughnesses of a state; levels of the time in hand; dates that may come."""
DOUBT = 0.6
"""Share of the variation of lots that a belief leaves open: with known lots the table would dress too late."""
GROWTH, PRESS = (0.0, 0.2, 0.5, 0.8, 1.0), (0.0, 0.5, 1.0)
"""Quantiles of what is drawn at which lots are tried."""
MARGIN = (-0.75, 1.25)
"""Ends of the time in hand, in the work between two dates."""
LONGEST, DULLEST = 400, 12.0
"""Blocks without a dress in which a wheel gets as dull as the table goes: so many times as dull as a dressed one."""
SLOWLY = np.array([[0.3, *[1.0] * (len(FACTORS) - 1)]])
"""Factors of the lot that it grinds, which dulls it in small steps."""
LEAST = 1e-6
"""Dullness of a wheel that has none."""

KA = TapeRow._fields.index("kA")
ENDS_PART, SCRAP = KindRow._fields.index("ends_part"), KindRow._fields.index("scrap")
SURVIVAL = History._fields.index("survival")
HANDOVER, SECONDS = (Outcome._fields.index(name) for name in ("handover_cost", "seconds"))


class AxisPlace(NamedTuple):
    """Places of numbers on an axis: between two of its nodes, both of the shape of the numbers."""

    below: Numbers
    share: Array
    """Share of the node above."""


def place(axis: Array, values: Array, *, beyond: bool = False) -> AxisPlace:
    """Return the places of values between the nodes of an axis: beyond it at its ends, or along its last piece."""
    if len(axis) == 1:
        return AxisPlace(np.zeros(np.shape(values), np.int64), np.zeros(np.shape(values)))
    below = np.clip(np.searchsorted(axis, values) - 1, 0, len(axis) - 2)
    share = (values - axis[below]) / (axis[below + 1] - axis[below])
    return AxisPlace(below, share if beyond else np.clip(share, 0.0, 1.0))


def between(table: Array, first: Numbers, *places: AxisPlace) -> Array:
    """Interpolate in a table of shape (any, nodes of each axis).

    Args:
        table: the table.
        first: numbers on its first axis.
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
    """Log of A + 0.02 lam of wheels, shape (..., fields of `WheelState`)."""
    return np.asarray(np.log(np.maximum(wheels[..., AREA] + LOADED_AREA * wheels[..., LOADING], LEAST)))


class Coming(NamedTuple):
    """Frequencies of coming blocks in episodes of a simulation, counted in a sample."""

    rows: Numbers
    """Rows of `Simulation.kinds`, in the order of the tables."""
    number: Numbers
    """Of every row of `Simulation.kinds` in that order; of one that does not come, that of the first of its kind."""
    follows: Array
    """Chance of each row after each, shape (rows, rows)."""
    anew: Array
    """Chance that it begins a lot, likewise."""
    growth: Array
    """Log of the dulling rate of lots and wheels, any number."""
    pressure: Array
    """Log of that on their pressure, likewise."""
    scenarios: Array
    """Stock over the nominal one and `FACTORS`, the first two as doubts, shape (rows, scenarios, 1 + factors)."""


def course(simulation: Simulation) -> Coming:
    """Return the frequencies of coming blocks."""
    start = simulation.start([np.random.default_rng(k) for k in range(EPISODES)])
    tape, numbers = start.tape, simulation.branches.rows_of(start.tape)
    rows = np.unique(numbers)
    at = np.searchsorted(rows, numbers)
    follows, new = np.zeros((len(rows), len(rows))), np.zeros((len(rows), len(rows)))
    np.add.at(follows, (at[:, :-1], at[:, 1:]), 1.0)
    np.add.at(new, (at[:, :-1], at[:, 1:]), tape[:, 1:, NEW_LOT])
    # every quantile of each once, in an order of its own
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

    cost: Array
    """Without that of the wheel left behind, $."""
    handover: Array
    """Price of that wheel where the episode ends, $."""
    dull: Array
    """Log dullness afterwards."""
    seconds: Array
    """Time, s."""


@dataclass(frozen=True)
class Worth:
    """Cost of the rest of an episode that continues as cheaply as the table knows, $.

    Attributes:
        course: frequencies of coming blocks.
        growth: nodes of the log of the dulling rate.
        pressure: nodes of the log of the factor on the pressure of wear flats.
        dull: nodes of the log of the dullness.
        margin: spare time before the next due date beyond the nominal work, s; one node in a task without dates.
        lots: probability of each growth and pressure, shape (growth, pressure).
        period: blocks from due date to due date; 0 without.
        dates: change of the margin at a date, shape (margin, margin).
        late: cost of each margin at a date, $.
        work: nominal time of a block of each row, s, from which due dates are made.
        choices: E and D.
        before: by block, shape (blocks + 1, rows, growth, pressure, dull, margin).
        cheapest: number of the best choice, likewise, without the last.
    """

    course: Coming
    growth: Array
    pressure: Array
    dull: Array
    margin: Array
    lots: Array
    period: int
    dates: Array
    late: Array
    work: Array
    choices: Decision
    before: Array
    cheapest: Numbers

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
        """Return the same where the next row is not known yet, shape (rows, nodes of each axis)."""
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
        """Return the best choice at the nodes above, so for no sharper a wheel and no kinder a lot than there is."""
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
    """Shares of the nodes of an axis in each of the values, shape (values, nodes)."""
    at, index = place(axis, values, beyond=True), np.arange(len(values))
    shares = np.zeros((len(values), len(axis)))
    shares[index, at.below] += 1.0 - at.share
    shares[index, np.minimum(at.below + 1, len(axis) - 1)] += at.share
    return shares


def dulling(model: MemberModel, rows: Numbers) -> Array:
    """Return wheels from dressed to so dull that a dress is far away, shape (dull, fields of `WheelState`)."""
    task = model.simulation.task
    member = model.room(1)
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
    members = model.room(1).pick(np.zeros(n, np.int64))
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
        # what a part in work has lost of its chances is charged with its last block, but decides now
        cost = cost + kind[SCRAP] * (1.0 - members.memory[:, SURVIVAL])
    each = cost, outcomes[:, HANDOVER], dullness(members.wheels), outcomes[:, SECONDS]
    return tuple(values.reshape(shape).mean(axis=-1) for values in each)


def _grind(
    model: MemberModel, members: Episodes, rows: Numbers, stocks: Array, factors: Array, speeds: Array, executions: Any
) -> Array:
    """Grind a block in every member as if it were the first of a part; its outcomes."""
    everyone = np.arange(len(rows))
    model.branches.load(members, everyone, rows, stocks)
    model.write_factors(members, everyone, factors)
    members.memory[:] = 0.0
    members.memory[:, SURVIVAL] = 1.0
    return model.simulation.step(members, speeds, np.broadcast_to(executions, speeds.shape).astype(np.float64))[0]
