"""The task itself: N episodes side by side, without Gymnasium.

One compiled call steps all of them: cycle parameters from (E, D), the block kernel, cost, and the readings of
the next observation. The single environment runs it with N = 1, the vector environment and the planners with
many.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grind_env.control.rules import motion_time
from grind_env.envs.episode import TapeRow, draw
from grind_env.envs.observations import HIDDEN, Reading, Readings, readings
from grind_env.envs.tasks import Kind, Task
from grind_env.kernel import entry, inlined
from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.batch import longest_first
from grind_env.machine.block import run_blocks
from grind_env.machine.cycle import Cycle, CycleResult, PartState, dress_lead
from grind_env.process.cost import Limits, Rates, handover_cost, running_cost, survival
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.state import Stroke, StrokeParameters, WheelState

Table = NDArray[np.float64]

GAUGE_EVERY = 3
"""Parts between two roughness gaugings."""


WEAR = WheelState._fields.index("W")
TARGET = Cycle._fields.index("target")
GROWTH, PRESSURE = StrokeParameters._fields.index("kA"), StrokeParameters._fields.index("pm")
CONVECTION, FRACTURE = StrokeParameters._fields.index("hf"), StrokeParameters._fields.index("fc")
G_RATIO, ROUGHNESS = StrokeParameters._fields.index("Gref"), StrokeParameters._fields.index("ra_scale")
CYCLE_FIELDS, STROKE_FIELDS, READINGS = len(Cycle._fields), len(Stroke._fields), len(Readings._fields)


class KindRow(NamedTuple):
    """The numbers of a block kind that a step needs; see `tasks.Kind`."""

    stock: float
    pick: float
    sparkout: float
    width: float
    length: float
    stroke: float
    """Distance between the reversal points, mm."""
    scrap: float
    starts_part: float
    ends_part: float
    counts_all: float
    """1 if heat counts over all plunges, because a rise allowance is given."""
    load: float
    rise: float
    power: float
    roughness: float
    size: float


class Shop(NamedTuple):
    """The numbers of a task that are the same for all its blocks."""

    acceleration: float
    dwell: float
    dress_passes: float
    dress_feed: float
    dress_depth: float
    dress_seconds: float
    hourly: float
    wheel_price: float
    dress_price: float
    reference_cost: float


class Memory(NamedTuple):
    """What the shop floor remembers from block to block."""

    speed: float
    executions: float
    pick: float
    width: float
    mean_power: float
    first_power: float
    peak_power: float
    size_error: float
    roughness: float
    gauged: float
    """Roughness gauged on the last gauged part, not yet known; negative if none."""
    since_gauged: float
    blocks_since_dress: float
    dresses: float
    parts: float
    survival: float
    """Probability that the part in work is still good."""


class Outcome(NamedTuple):
    """What one step gives back. Costs in $."""

    time_cost: float
    wheel_cost: float
    dress_cost: float
    scrap_cost: float
    handover_cost: float
    cost: float
    """Sum of the five terms, $."""
    reward: float
    """Minus that sum over the reference cost of a block."""
    good: float
    """Probability that the part that this block finished is good; 0 if it finished none."""
    finished: float
    """1 if the block finished a part."""
    seconds: float
    burn_ratio: float
    rise: float
    peak_power: float
    roughness: float
    size_error: float


read_kind, read_row = column_reader(KindRow), column_reader(TapeRow)
read_parameters, write_parameters = column_reader(StrokeParameters), column_writer(StrokeParameters)
read_wheel, write_wheel = column_reader(WheelState), column_writer(WheelState)
read_part, write_part = column_reader(PartState), column_writer(PartState)
read_memory, write_memory = column_reader(Memory), column_writer(Memory)
read_result, write_cycle, write_outcome = (
    column_reader(CycleResult),
    column_writer(Cycle),
    column_writer(Outcome),
)
write_readings = column_writer(Readings)


@dataclass(slots=True)
class Episodes:
    """The state of N episodes: arrays with one row an episode.

    `tape` has shape (N, blocks, fields of `TapeRow`); the others (N, fields of the named tuple).
    """

    tape: Table
    block: NDArray[np.int64]
    wheels: Table
    parts: Table
    memory: Table

    def pick(self, index: ArrayLike) -> "Episodes":
        """Copies of the episodes at `index` (which may repeat): what-if branches for a planner."""
        return Episodes(**{f.name: getattr(self, f.name)[np.asarray(index)] for f in fields(self)})


class Simulation:
    """Steps episodes of one task.

    Args:
        task: the task.
        full: whether observations show the hidden state.
        threads: kernel threads; the numbers do not depend on them.
    """

    def __init__(self, task: Task, *, full: bool = False) -> None:
        self.task = task
        self.entries: tuple[Reading, ...] = readings(task, full=full)
        self.kinds = np.array([kind_row(task, kind) for kind in task.kinds])
        self.base = np.array([task.parameters(kind) for kind in task.kinds])
        self.shop = Shop(
            acceleration=task.machine.acceleration,
            dwell=task.machine.reversal_dwell,
            dress_passes=float(task.dress.passes),
            dress_feed=task.dress_feed,
            dress_depth=task.dress.depth,
            dress_seconds=task.dress_seconds,
            hourly=task.rates.hourly,
            wheel_price=task.rates.wheel,
            dress_price=task.rates.dress,
            reference_cost=task.reference_cost,
        )
        self._offset = np.array([entry.offset for entry in self.entries])
        self._scale = np.array([entry.scale for entry in self.entries])
        self._low = np.array([entry.low for entry in self.entries])
        self._high = np.array([entry.high for entry in self.entries])
        self._plain = len(Readings._fields) if full else HIDDEN
        self._start = np.array(task.start_wheel())

    def start(self, rngs: Sequence[np.random.Generator]) -> Episodes:
        """New episodes, one from each generator."""
        n = len(rngs)
        episodes = Episodes(
            np.empty((n, self.task.blocks, len(TapeRow._fields))),
            np.zeros(n, np.int64),
            np.empty((n, len(WheelState._fields))),
            np.empty((n, len(PartState._fields))),
            np.empty((n, len(Memory._fields))),
        )
        for i, rng in enumerate(rngs):
            self.restart(episodes, i, rng)
        return episodes

    def restart(self, episodes: Episodes, i: int, rng: np.random.Generator) -> None:
        """Put a new episode in place of episode i."""
        episodes.tape[i], diamond_flat = draw(self.task, rng)
        if diamond_flat > 0.0:
            episodes.wheels[i] = self.task.start_wheel(diamond_flat)
        else:
            episodes.wheels[i] = self._start
        episodes.block[i] = 0
        episodes.parts[i] = PartState(0.0, 0.0, INITIAL_ROUGHNESS)
        episodes.memory[i] = Memory(*[0.0] * len(Memory._fields))._replace(gauged=-1.0, survival=1.0)

    def step(
        self, episodes: Episodes, speeds: Table, executions: Table, active: NDArray[np.int64] | None = None
    ) -> tuple[Table, Table]:
        """Grind the next block of the episodes in `active` (indices; all by default).

        Args:
            episodes: changed in place.
            speeds: E in mm/min, shape (N,).
            executions: D, shape (N,).
            active: indices of the episodes to step; they must not be over.

        Returns:
            Outcomes, shape (N, fields of `Outcome`), and results of the cycles, shape (N, fields of
            `CycleResult`); rows of the others are 0.
        """
        n = len(episodes.block)
        active = np.arange(n) if active is None else active
        outcomes = np.zeros((n, len(Outcome._fields)))
        results = np.zeros((n, len(CycleResult._fields)))
        _step(
            self.kinds,
            self.base,
            self.shop,
            episodes.tape,
            episodes.block,
            episodes.wheels,
            episodes.parts,
            episodes.memory,
            speeds,
            executions,
            active,
            results,
            outcomes,
        )
        return outcomes, results

    def observe(self, episodes: Episodes) -> NDArray[np.float32]:
        """Observations of the coming blocks, shape (N, entries), float32.

        After the last block of an episode the coming block reads as zeros.
        """
        observations = np.zeros((len(episodes.block), len(self.entries)), np.float32)
        _observe(
            self.kinds,
            episodes.tape,
            episodes.block,
            episodes.wheels,
            episodes.memory,
            self._plain,
            self._offset,
            self._scale,
            self._low,
            self._high,
            observations,
        )
        return observations

    def over(self, episodes: Episodes) -> NDArray[np.bool_]:
        """Which episodes have ground their last block, shape (N,)."""
        return episodes.block >= self.task.blocks


def kind_row(task: Task, kind: Kind) -> KindRow:
    """The numbers of a block kind."""
    limits = task.limits(kind)
    return KindRow(
        stock=kind.stock,
        pick=kind.pick,
        sparkout=float(kind.sparkout),
        width=kind.width,
        length=kind.length,
        stroke=kind.length + 2.0 * task.setup.overrun,
        scrap=kind.scrap,
        starts_part=float(kind.starts_part),
        ends_part=float(kind.ends_part),
        counts_all=float(kind.rise_allowance > 0.0),
        load=task.setup.load if kind.starts_part else 0.0,
        rise=limits.rise,
        power=limits.power,
        roughness=limits.roughness,
        size=limits.size,
    )


@inlined
def cycle_of(kind: KindRow, row: TapeRow, part: PartState, E: float, D: float, shop: Shop) -> Cycle:
    """The cycle of a block.

    The wheel is set to the first depth before the first stroke, off the part, so the cycle itself makes one
    pick less than there are depths, and one spark-out stroke more follows its last cut.
    """
    surface = 0.0 if kind.starts_part > 0.0 else part.Z
    speed = E / 60.0
    seconds = motion_time(kind.stroke, speed, shop.acceleration) + shop.dwell
    target = surface + row.stock
    return Cycle(
        speed,
        seconds,
        seconds,
        min(surface + kind.pick, target),
        target,
        kind.pick,
        kind.pick,
        kind.sparkout + 1.0,
        1.0,
        D,
        0.0,
        kind.width,
        kind.length,
        shop.dress_passes,
        shop.dress_feed,
        shop.dress_depth,
        shop.dress_seconds,
    )


@inlined
def measured(power: float, z: float) -> float:
    """A power reading with 3 % and 20 W of noise, W."""
    return max(power * (1.0 + 0.03 * z) + 20.0 * z, 0.0)


@entry
def _step(
    kinds: Any,
    base: Any,
    shop: Any,
    tape: Any,
    block: Any,
    wheels: Any,
    parts: Any,
    memory: Any,
    speeds: Any,
    executions: Any,
    active: Any,
    results: Any,
    outcomes: Any,
) -> None:
    n = block.size
    cycles = np.empty((n, CYCLE_FIELDS))
    parameters = np.empty((n, base.shape[1]))
    for i in active:
        row = read_row(tape[i], block[i])
        number = int(row.kind)
        kind = read_kind(kinds, number)
        cycle = cycle_of(kind, row, read_part(parts, i), speeds[i], executions[i], shop)
        write_cycle(cycles, i, cycle)
        parameters[i] = base[number]
        _apply_factors(parameters, i, row)
        # the part is touched off or gauged before every block: wear of the wheel up to now is known
        wheels[i, WEAR] = 0.0
        if kind.starts_part > 0.0:
            write_part(parts, i, PartState(0.0, 0.0, INITIAL_ROUGHNESS))
    order = np.empty(active.size, np.int64)
    longest_first(cycles, active, order)
    run_blocks(cycles, parameters, wheels, parts, results, np.empty((n, 0, STROKE_FIELDS)), order, 0, 1)

    rates = Rates(shop.hourly, shop.wheel_price, shop.dress_price)
    for i in active:
        row = read_row(tape[i], block[i])
        kind = read_kind(kinds, int(row.kind))
        wheel, part, p = read_wheel(wheels, i), read_part(parts, i), read_parameters(parameters, i)
        result, old = read_result(results, i), read_memory(memory, i)
        ends = kind.ends_part > 0.0

        rise = result.plunge_rise if kind.counts_all > 0.0 else result.finish_rise
        size_error = 1000.0 * (cycles[i, TARGET] - part.S)
        limits = Limits(kind.rise, kind.power, kind.roughness, kind.size)
        alive = (1.0 if kind.starts_part > 0.0 else old.survival) * survival(
            rise, result.peak_power, part.Rs, size_error, limits
        )
        time_cost = running_cost(result.seconds + kind.load, 0.0, 0.0, rates)
        wheel_cost = running_cost(0.0, result.worn + result.dressed_off, 0.0, rates)
        dress_cost = running_cost(0.0, 0.0, result.dresses, rates)
        scrap_cost = kind.scrap * (1.0 - alive) if ends else 0.0
        handover = 0.0
        if block[i] + 1 == tape.shape[1]:
            lead = dress_lead(wheel, shop.dress_feed, p)
            handover = handover_cost(wheel, shop.dress_passes, lead, shop.dress_depth, shop.dress_seconds, p, rates)
        cost = time_cost + wheel_cost + dress_cost + scrap_cost + handover
        outcome = Outcome(
            time_cost=time_cost,
            wheel_cost=wheel_cost,
            dress_cost=dress_cost,
            scrap_cost=scrap_cost,
            handover_cost=handover,
            cost=cost,
            reward=-cost / shop.reference_cost,
            good=alive if ends else 0.0,
            finished=1.0 if ends else 0.0,
            seconds=result.seconds + kind.load,
            burn_ratio=result.burn_ratio,
            rise=rise,
            peak_power=result.peak_power,
            roughness=part.Rs,
            size_error=size_error,
        )
        write_outcome(outcomes, i, outcome)
        mean = result.last_power / result.last_count if result.last_count > 0.0 else 0.0
        begin = result.first_power / result.first_count if result.first_count > 0.0 else 0.0
        gauge_now = ends and int(old.parts) % GAUGE_EVERY == 0
        ratio = part.Rs / kind.roughness if kind.roughness > 0.0 else 0.0
        known = ends and old.gauged >= 0.0
        write_memory(
            memory,
            i,
            Memory(
                speeds[i] / 1000.0,
                executions[i],
                kind.pick,
                kind.width,
                measured(mean, row.mean_noise) if result.last_count > 0.0 else 0.0,
                measured(begin, row.first_noise) if result.first_count > 0.0 else 0.0,
                measured(result.peak_power, row.peak_noise),
                size_error + 0.7 * row.size_noise if ends else old.size_error,
                old.gauged if known else old.roughness,
                ratio * (1.0 + 0.06 * row.roughness_noise) if gauge_now else (-1.0 if ends else old.gauged),
                1.0 if known else old.since_gauged + (1.0 if ends else 0.0),
                0.0 if result.dresses > 0.0 else old.blocks_since_dress + 1.0,
                old.dresses + result.dresses,
                old.parts + (1.0 if ends else 0.0),
                alive,
            ),
        )
        block[i] += 1


@inlined
def _apply_factors(parameters: Any, i: int, row: TapeRow) -> None:
    parameters[i, GROWTH] *= row.kA
    parameters[i, PRESSURE] *= row.pm
    parameters[i, CONVECTION] *= row.hf
    parameters[i, FRACTURE] *= row.fc
    parameters[i, G_RATIO] *= row.Gref
    parameters[i, ROUGHNESS] *= row.ra_scale


@entry
def _observe(
    kinds: Any,
    tape: Any,
    block: Any,
    wheels: Any,
    memory: Any,
    plain: int,
    offset: Any,
    scale: Any,
    low: Any,
    high: Any,
    observations: Any,
) -> None:
    values = np.empty((1, READINGS))
    total = tape.shape[1]
    for i in range(block.size):
        wheel, seen = read_wheel(wheels, i), read_memory(memory, i)
        ahead = block[i] < total
        row = read_row(tape[i], min(block[i], total - 1))
        number = int(row.kind)
        kind = read_kind(kinds, number)
        here = 1.0 if ahead else 0.0
        reading = Readings(
            mean_power=seen.mean_power,
            first_power=seen.first_power,
            peak_power=seen.peak_power,
            last_speed=seen.speed,
            last_executions=seen.executions,
            last_pick=seen.pick,
            last_width=seen.width,
            size_error=seen.size_error,
            roughness=seen.roughness,
            parts_since_gauged=seen.since_gauged,
            volume=wheel.V,
            blocks_since_dress=seen.blocks_since_dress,
            dresses=seen.dresses,
            diameter=wheel.ds,
            pick=here * kind.pick,
            width=here * kind.width,
            length=here * kind.length,
            sparkout=here * kind.sparkout,
            stock=here * row.gauged / kind.stock,
            roughness_limit=here * kind.roughness,
            tolerance=here * kind.size,
            scrap=here * kind.scrap,
            new_lot=here * row.new_lot,
            remaining=(total - block[i]) / total,
            wear_flat=wheel.A,
            loading=wheel.lam,
            waviness=wheel.alw,
            diamond_flat=wheel.wd,
            dressed_roughness=wheel.Rd,
            dressed_density=wheel.Cd,
            growth=row.kA,
            pressure=row.pm,
            fracture=row.fc,
            wear=row.Gref,
            convection=row.hf,
            roughness_scale=row.ra_scale,
        )
        write_readings(values, 0, reading)
        for k in range(plain):
            observations[i, k] = min(max((values[0, k] - offset[k]) / scale[k], low[k]), high[k])
        if kinds.shape[0] > 1 and ahead:
            observations[i, plain + number] = 1.0
            if block[i] + 1 < total:
                after = int(read_row(tape[i], block[i] + 1).kind)
                observations[i, plain + kinds.shape[0] + after] = 1.0
