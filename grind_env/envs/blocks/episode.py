"""The noise tape: everything random in an episode, drawn at reset.

The same seed therefore means the same stock, lots, wheels and measurement noise, whatever the policy does, and
policies can be compared on common random numbers.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Table
from grind_env.envs.contexts import Fixed, Given, from_ranges
from grind_env.envs.tape import Sigmas, deal_orders, fill, fill_dates, unless
from grind_env.envs.tasks import Task
from grind_env.kernel import entry
from grind_env.kernel.columns import column_reader
from grind_env.machine.loops import compiled
from grind_env.machine.loops.rows import read_parameters, write_wheel
from grind_env.process.state import WheelState
from grind_env.process.stroke import dressed_wheel

NORMALS = 10
"""Standard normal numbers drawn for a block; a row after the last block holds those of the episode."""
LOT = slice(2, 4)
EPISODE = slice(0, 5)
TOGETHER = 16
"""Episodes begun in one go, few enough that their numbers stay in the nearest cache."""


read_fixed = column_reader(Fixed)

DEALT = -1
"""Kind of a block that the orders decide."""


class Numbers(NamedTuple):
    """Random numbers of M episodes, before anything is made of them."""

    normals: Any
    """Shape (M, blocks + 1, NORMALS); the last row holds those of the episode."""
    wheel_normals: Any
    """Of the gauged wheel diameter, shape (M, blocks)."""
    uniforms: Any
    """Shape (M, blocks + 1); the last column holds those of the episode."""
    orders: Any
    """Of the kind and the size of each order, shape (M, blocks, 2)."""
    kinds: Any
    """Kind of every block, shape (M, blocks); `DEALT` where orders deal them."""
    slack: Any
    """Of each due date, shape (M, dates)."""
    ageing: Any
    """Of the ageing rate of the coolant, shape (M,)."""
    left: Any
    """Of the dress executions left, shape (M,)."""
    spare: Any
    """Of the spare wheel, shape (M, 2)."""


class Opening(NamedTuple):
    """How the episodes of a task begin."""

    diameter: float
    """Of the wheel where nothing is drawn, mm."""
    least_diameter: float
    execution_depth: float
    """Diameter that one dress execution takes off, mm."""
    least_left: float
    """Fewest dress executions left; NaN if the diameter is not drawn."""
    most_left: float
    lead: float
    """Of the dress before the first block, mm."""
    depth: float
    wear_flat_area: float
    """NaN for that of a dressed wheel."""
    volume: float
    """Ground since that dress, mm3/mm."""
    least_slack: float
    """Time to a due date over the nominal time."""
    most_slack: float


@entry
def begin_episodes(
    tape: Any,
    wheels: Any,
    index: Any,
    stocks: Any,
    least: Any,
    starts: Any,
    materials: Any,
    nominal: Any,
    most_parts: int,
    numbers: Numbers,
    sigmas: Sigmas,
    opening: Opening,
    parameters: Any,
    fixed: Any,
) -> None:
    """Write the tapes and the first wheels of M episodes.

    Args:
        tape: shape (N, blocks, fields of `TapeRow`); written in the rows `index`.
        wheels: shape (N, fields of `WheelState`); written likewise.
        index: episodes that begin, shape (M,).
        stocks: as for `fill`, like the next three.
        least: by kind.
        starts: by kind.
        materials: by kind.
        nominal: seconds of each kind, for the due dates.
        most_parts: of an order; 0 in a task without orders.
        numbers: random numbers; the kinds are dealt in place.
        sigmas: spreads of the task.
        opening: how its episodes begin.
        parameters: of the dress before the first block, shape (1, fields of `StrokeParameters`).
        fixed: what a context fixes, shape (M, fields of `Fixed`).
    """
    blocks, dates = tape.shape[1], numbers.slack.shape[1]
    factors, begins = np.empty(dates), np.empty(blocks, np.bool_)
    p = read_parameters(parameters, 0)
    for j in range(index.size):
        i, given, kinds = index[j], read_fixed(fixed, j), numbers.kinds[j]
        begins[0] = True
        for k in range(1, blocks):
            begins[k] = most_parts > 0 and kinds[k] != kinds[k - 1]
        if kinds[0] == DEALT:
            deal_orders(kinds, begins, numbers.orders[j], stocks.size, most_parts)
        fill(
            tape[i],
            kinds,
            begins,
            stocks,
            least,
            starts,
            materials,
            numbers.normals[j],
            numbers.wheel_normals[j],
            numbers.uniforms[j],
            numbers.ageing[j],
            numbers.spare[j],
            sigmas,
            given,
        )
        if dates > 0:
            for k in range(dates):
                drawn = opening.least_slack + (opening.most_slack - opening.least_slack) * numbers.slack[j, k]
                factors[k] = unless(given.slack, drawn)
            fill_dates(tape[i], kinds, nominal, factors)
        left = opening.least_left + (opening.most_left - opening.least_left) * numbers.left[j]
        found = opening.least_diameter + opening.execution_depth * unless(given.executions_left, left)
        ds = opening.diameter if np.isnan(opening.least_left) else found
        flat = unless(given.diamond_flat, sigmas.diamond_flat * numbers.uniforms[j, blocks])
        wheel = dressed_wheel(ds, flat, opening.lead, opening.depth, p)
        A = unless(opening.wear_flat_area, wheel.A)
        write_wheel(
            wheels,
            i,
            WheelState(
                ds=wheel.ds,
                A=A,
                lam=wheel.lam,
                V=opening.volume,
                Rd=wheel.Rd,
                Cd=wheel.Cd,
                W=wheel.W,
                wd=wheel.wd,
            ),
        )


class EpisodeGenerator:
    """Draws the episodes of a task."""

    def __init__(self, task: Task) -> None:
        self.task = task
        names = task.materials
        self.stocks = np.array([kind.stock for kind in task.kinds])
        self.least = np.array([kind.least_stock for kind in task.kinds])
        self.starts = np.array([kind.starts_part for kind in task.kinds])
        self.materials = np.array([float(names.index(kind.material)) for kind in task.kinds])
        spread = {name: getattr(task.spread, name) for name in task.spread.__slots__}
        self.sigmas = Sigmas(**spread, ageing=task.setup.coolant_ageing)
        self.sequence = np.full(task.blocks, DEALT) if task.orders else np.array(task.numbers(task.sequence, ""))
        self.most_parts = task.orders.most_parts if task.orders else 0
        self.dates = task.blocks // task.due.blocks if task.due else 0
        speed = task.due.speed if task.due else 1.0
        self.nominal = np.array([task.nominal_seconds(kind, speed) for kind in task.kinds])
        self.parameters = task.parameters(task.kinds[0])
        self.opening = _opening(task)
        self._parameter_row = np.array([self.parameters])
        self._numbers = _room(task.blocks, self.dates)

    def begin(
        self,
        tape: Table,
        wheels: Table,
        index: NDArray[np.int64],
        rngs: Sequence[np.random.Generator],
        given: Sequence[Given],
    ) -> None:
        """Draw an episode from each of M generators, and write its tape and its first wheel.

        Args:
            tape: shape (N, blocks, fields of `TapeRow`); written in the rows `index`.
            wheels: shape (N, fields of `WheelState`); written likewise.
            index: rows of the new episodes, shape (M,).
            rngs: their generators.
            given: what is given of each.
        """
        for first in range(0, len(index), TOGETHER):
            some = slice(first, first + TOGETHER)
            for j, (rng, each) in enumerate(zip(rngs[some], given[some], strict=True)):
                self._draw(j, rng, each)
            begin_episodes(
                tape,
                wheels,
                index[some],
                self.stocks,
                self.least,
                self.starts,
                self.materials,
                self.nominal,
                self.most_parts,
                self._numbers,
                self.sigmas,
                self.opening,
                self._parameter_row,
                np.array([each.fixed for each in given[some]]),
            )

    def _draw(self, j: int, rng: np.random.Generator, given: Given) -> None:
        """Draw the numbers of one episode into row j.

        The count of random numbers depends on the task only, never on what they turn out to be or on what is given.
        """
        task, numbers, blocks = self.task, self._numbers, self.task.blocks
        rng.standard_normal(out=numbers.normals[j])
        rng.random(out=numbers.uniforms[j])
        if task.orders:
            rng.random(out=numbers.orders[j])
        if self.dates:
            rng.random(out=numbers.slack[j])
        if self.sigmas.ageing:
            numbers.ageing[j] = rng.random()
        if task.start.executions_left:
            numbers.left[j] = rng.random()
        if task.wheel_change:
            rng.standard_normal(out=numbers.spare[j])
        rng.standard_normal(out=numbers.wheel_normals[j])
        if given.ranges:
            for drawn in (numbers.normals[j, :blocks, LOT], numbers.normals[j, blocks, EPISODE], numbers.spare[j]):
                drawn[:] = from_ranges(drawn, given.ranges)
        numbers.kinds[j] = self.sequence if given.kinds is None else given.kinds

    def wheel(self, diamond_flat: float) -> WheelState:
        """The new wheel at the start of an episode, dressed with a diamond of that wear flat, mm."""
        opening = self.opening
        wheel = compiled.dressed_wheel(opening.diameter, diamond_flat, opening.lead, opening.depth, self.parameters)
        area = opening.wear_flat_area
        return wheel._replace(A=wheel.A if math.isnan(area) else area, V=opening.volume)


def _room(blocks: int, dates: int) -> Numbers:
    """Room for the numbers of as many episodes as are begun in one go; those that a task does not draw stay as here."""
    return Numbers(
        normals=np.empty((TOGETHER, blocks + 1, NORMALS)),
        wheel_normals=np.empty((TOGETHER, blocks)),
        uniforms=np.empty((TOGETHER, blocks + 1)),
        orders=np.empty((TOGETHER, blocks, 2)),
        kinds=np.empty((TOGETHER, blocks), np.int64),
        slack=np.empty((TOGETHER, dates)),
        ageing=np.full(TOGETHER, 0.5),
        left=np.zeros(TOGETHER),
        spare=np.zeros((TOGETHER, 2)),
    )


def _opening(task: Task) -> Opening:
    left = task.start.executions_left or (math.nan, math.nan)
    slack = task.due.slack if task.due else (1.0, 1.0)
    area = task.start.wear_flat_area
    return Opening(
        task.wheel.diameter,
        task.wheel.minimum_diameter,
        task.execution_depth,
        float(left[0]),
        float(left[1]),
        task.dress_lead,
        task.dress.depth,
        math.nan if area is None else area,
        task.start.volume,
        float(slack[0]),
        float(slack[1]),
    )
