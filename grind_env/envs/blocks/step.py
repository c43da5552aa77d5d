"""The step of G82 blocks: cycle parameters from E and D, the block kernel, and what `settling` says of it."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from grind_env.belief.hidden import FACTORS
from grind_env.control.cycles.plunge import PlungeCycle
from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.envs.blocks.settling import (
    booked_diameter,
    counted_rise,
    good_so_far,
    handover_of,
    legible,
    noise_of,
    outcome_of,
    remembered,
    truth_of,
)
from grind_env.envs.step import Work, step_of
from grind_env.envs.tables import (
    FOUND,
    KindRow,
    Shop,
    ShopMemory,
    read_kind,
    read_memory,
    read_shop,
    write_memory,
    write_outcome,
)
from grind_env.envs.tape import BLOCKS, SPARE_FACTORS, TapeRow, draw_rows, place_of, read_row
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import column_reader, column_writer
from grind_env.machine.loops.batch import NO_MOTIONS, longest_plunges
from grind_env.machine.loops.courses import COURSES
from grind_env.machine.loops.cycle import PartState, Stroking, dress_lead
from grind_env.machine.loops.loops import loops_of
from grind_env.machine.loops.rows import (
    OWN_FROM,
    RULES_FROM,
    read_parameters,
    read_part,
    read_stroking,
    read_tally,
    read_wheel,
    write_part,
    write_stroking,
    write_wheel,
)
from grind_env.machine.loops.rules import motion_time
from grind_env.machine.loops.shift import shift_of
from grind_env.machine.loops.tally import Tally
from grind_env.process.cost import STALL
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.gauge import Gauge
from grind_env.process.process import Drive, Moment, Process, joined
from grind_env.process.state import StrokeParameters, WheelState
from grind_env.process.stroke import dressed_wheel

DIAMETER, WEAR = WheelState._fields.index("ds"), WheelState._fields.index("W")
FACTOR_COLUMNS = tuple(TapeRow._fields.index(name) for name in FACTORS)
SPARE_COLUMNS = tuple(TapeRow._fields.index(name) for name in SPARE_FACTORS)
PARAMETER_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FACTORS)
CHANGES = ShopMemory._fields.index("wheel_changes")
TORQUE = Tally._fields.index("peak_torque")
NEW_PART = PartState(Z=0.0, S=0.0, Rs=INITIAL_ROUGHNESS)
write_plunge = column_writer(PlungeCycle, RULES_FROM)


class Tables(NamedTuple):
    """What a task is made of, and room for N cycles."""

    kinds: Any
    """Of `tables.kind_table`, shape (kinds x materials, fields of `KindRow`)."""
    base: Any
    """Of `tables.parameter_table`, shape (kinds x materials, fields of `StrokeParameters`)."""
    shops: Any
    """Numbers of the task, shape (1, fields of `Shop`)."""
    drawn: Any
    """Numbers of its kinds that rows of the tape are drawn with, shape (kinds, fields of `DrawnKind`)."""
    spreads: Any
    """Shape (1, fields of `Sigmas`)."""
    cycles: Any
    """Room for the cycles, shape (N, `CYCLE_FIELDS`)."""
    parameters: Any
    """Room for their parameters, shape (N, fields of `StrokeParameters`)."""


class EpisodeArrays(NamedTuple):
    """The state of N episodes, as in `simulation.Episodes`. All but the schedule is updated by a step."""

    tape: Any
    """Shape (N, rows, fields of `TapeRow`)."""
    block: Any
    """Number of the coming block, shape (N,), int64."""
    wheels: Any
    """Shape (N, fields of `WheelState`, of the `own` of the process, and of that of the gauge)."""
    parts: Any
    """Shape (N, fields of `PartState`)."""
    memory: Any
    """Shape (N, fields of `ShopMemory`)."""
    source: Any
    """Shape (N, SOURCE)."""
    schedule: Any
    """Shape (N, blocks), int16."""


class Choices(NamedTuple):
    """What is chosen for the coming block of N episodes, each shape (N,)."""

    speeds: Any
    """E, mm/min."""
    executions: Any
    """D."""
    pre_dresses: Any
    """1 for a dress before the first plunge, else 0."""


@inlined
def stroking_of(
    kind: KindRow, shop: Shop, E: float, seconds: float, waited: float, start: float, target: float, finish: float
) -> Stroking:
    """Strokes of some seconds at E (mm/min), from depth `start` to `target` on a part that is to come to `finish`.

    All three are mm. So many s are `waited` before the first one.
    """
    return Stroking(
        speed=E / 60.0,
        first_seconds=seconds + waited,
        stroke_seconds=seconds,
        set_out=seconds,
        start=start,
        surface=0.0,
        bottom=start + (target - start),
        full_plunge=kind.pick - DEPTH_TOLERANCE,
        finish=finish,
        width=kind.width,
        length=kind.length,
        dress_passes=shop.dress_passes,
        dress_feed=shop.dress_feed,
        dress_depth=shop.dress_depth,
        dress_seconds=shop.dress_seconds,
        cross_start=0.0,
        cross_end=0.0,
    )


@inlined
def block_stroking(kind: KindRow, shop: Shop, drive: Drive, E: float, start: float, target: float) -> Stroking:
    """The strokes of a block at E (mm/min), from one depth to that of the block, mm."""
    reached = drive.share * E
    seconds = motion_time(kind.stroke, reached / 60.0, shop.acceleration) + drive.dwell
    return stroking_of(kind, shop, reached, seconds, 0.0, start, target, target)


@inlined
def write_factored(parameters: Any, i: int, base: Any, number: int, tape: Any, place: int, changed: bool) -> None:
    """Write row `number` of the nominal parameters to episode i, with the factors in a row of its tape.

    Those of the spare wheel, if the wheel has been changed.
    """
    # a loop: with numba's copy of a slice, all of `prepare` takes 40 % longer
    for k in range(base.shape[1]):
        parameters[i, k] = base[number, k]
    for k in range(len(FACTOR_COLUMNS)):
        column = SPARE_COLUMNS[k] if changed else FACTOR_COLUMNS[k]
        parameters[i, PARAMETER_COLUMNS[k]] *= tape[i, place, column]


class Floor(NamedTuple):
    """How a block begins and ends: compiled functions."""

    begin: Callable[..., tuple[KindRow, TapeRow, Drive]]
    """`begin(i, tables, episodes, shop, E, results)`: loads or gauges the part of episode i and writes its parameters;
    gives kind and tape of its block, and what the table makes of E, mm/min."""
    settle: Callable[..., None]
    """`settle(i, tables, episodes, choices, shop, results, outcomes)`: writes what the block of episode i has cost and
    shown, and goes on to the next one."""


@functools.cache
def floor_of(process: Process, gauge: Gauge) -> Floor:
    """How blocks begin and end with what grinds them and what is measured of them."""
    (pass_time, before), read, own = shift_of(process), gauge.read, joined(process.own, gauge.own)
    read_own, write_own = column_reader(own, OWN_FROM), column_writer(own, OWN_FROM)

    @inlined
    def begin(i: int, tables: Any, episodes: Any, shop: Shop, E: float, results: Any) -> tuple[KindRow, TapeRow, Drive]:
        place = place_of(episodes.block[i], episodes.tape.shape[1])
        row, old = read_row(episodes.tape[i], place), read_memory(episodes.memory, i)
        variant = row_of(row, shop)
        kind = read_kind(tables.kinds, variant)
        changed = old.wheel_changes > 0.0
        write_factored(tables.parameters, i, tables.base, variant, episodes.tape, place, changed)
        episodes.memory[i, FOUND] = episodes.wheels[i, DIAMETER]
        starts = kind.starts_part > 0.0
        pass_time(episodes.wheels, tables.parameters, i, kind.wait, starts)
        # the part is touched off or gauged before every block: wear of the wheel up to now is known
        episodes.wheels[i, WEAR] = 0.0
        results[i, TORQUE] = 0.0 if starts else old.stalled * STALL
        if starts:
            write_part(episodes.parts, i, NEW_PART)
        number, seconds = float(episodes.block[i]), old.clock + kind.wait
        moment = Moment(number=number, seconds=seconds, place=0.5 * kind.length, E=E)
        return kind, row, before(episodes.wheels, tables.parameters, i, shop.dwell, moment)

    @inlined
    def settle(i: int, tables: Any, episodes: Any, choices: Choices, shop: Shop, results: Any, outcomes: Any) -> None:
        block, tape = episodes.block, episodes.tape
        row, old = read_row(tape[i], place_of(block[i], tape.shape[1])), read_memory(episodes.memory, i)
        kind = read_kind(tables.kinds, row_of(row, shop))
        wheel, part, result = read_wheel(episodes.wheels, i), read_part(episodes.parts, i), read_tally(results, i)
        p = read_parameters(tables.parameters, i)
        lead = dress_lead(wheel, shop.dress_feed, p)
        change = 1.0 if wheel.ds < shop.least_diameter else 0.0
        if change > 0.0:
            wheel = dressed_wheel(shop.new_diameter, wheel.wd, lead, shop.dress_depth, p)
            write_wheel(episodes.wheels, i, wheel)
            pass_time(episodes.wheels, tables.parameters, i, shop.change_seconds, False)
        handover = 0.0
        if block[i] + 1 == episodes.source[i, BLOCKS]:
            handover = handover_of(wheel, lead, shop, p)
        size_error = 1000.0 * (read_stroking(tables.cycles, i).finish - part.S)
        good = good_so_far(kind, part, result, size_error, old)
        rise = counted_rise(kind, result)
        outcome = outcome_of(kind, row, shop, part, result, old, size_error, rise, good, change, handover)
        write_outcome(outcomes, i, outcome)
        truth, clock = truth_of(result, outcome, wheel.ds), old.clock + outcome.seconds
        shown, own = read(truth, read_own(episodes.wheels, i), clock, noise_of(row))
        write_own(episodes.wheels, i, own)
        shown = legible(shown, result, change)
        E, D, pre_dress = choices.speeds[i], choices.executions[i], choices.pre_dresses[i]
        # the executions stand evenly in the depth: an equal share of it is ground after the last one
        volume = row.gauged * kind.length / (result.dresses - pre_dress + 1.0)
        # the next block begins with touching off or gauging
        diameter = booked_diameter(shown, shop, old, 0.0, True, change)
        new = remembered(kind, result, old, shown, outcome, good, change, E, D, pre_dress, volume, diameter)
        write_memory(episodes.memory, i, new)
        block[i] += 1

    return Floor(begin, settle)


@inlined
def draw_coming(tables: Any, episodes: Any, active: Any) -> None:
    """Draw the rows of blocks that have come up on the tapes."""
    draw_rows(
        episodes.tape,
        episodes.block,
        episodes.source,
        episodes.schedule,
        tables.drawn,
        tables.spreads,
        active,
    )


@inlined
def row_of(row: TapeRow, shop: Shop) -> int:
    """Row of the kind of a block in the tables of its task."""
    return int(row.kind) * int(shop.materials) + int(row.material)


@functools.cache
def blocks_step(process: Process, gauge: Gauge) -> Callable[..., None]:
    """The compiled step of G82 blocks."""
    return step_of(blocks_work(process, gauge))


@functools.cache
def blocks_work(process: Process, gauge: Gauge) -> Work:
    """Of what that step is made."""
    (begin, settle_one), grind_plunges = floor_of(process, gauge), loops_of(COURSES["G82"], process).lanes

    @entry
    def prepare(tables: Tables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any) -> None:
        """Write the cycles of the coming blocks; as `Work.prepare`.

        The wheel is set to the first depth before the first stroke, off the part, so the cycle itself makes one
        pick less than there are depths, and one spark-out stroke more follows its last cut.
        """
        shop = read_shop(tables.shops, 0)
        for i in active:
            kind, row, drive = begin(i, tables, episodes, shop, choices.speeds[i], results)
            surface = read_part(episodes.parts, i).Z
            target = surface + row.stock
            start = min(surface + kind.pick, target)
            cycle = PlungeCycle(
                depth=target - start,
                primary_pick=kind.pick,
                secondary_pick=kind.pick,
                at_depth=kind.sparkout + 2.0,
                executions=choices.executions[i],
                pre_dress=choices.pre_dresses[i],
            )
            write_stroking(tables.cycles, i, block_stroking(kind, shop, drive, choices.speeds[i], start, target))
            write_plunge(tables.cycles, i, cycle)

    @entry
    def grind(tables: Tables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any) -> None:
        """Run the cycles; as `Work.grind`."""
        order = np.empty(active.size, np.int64)
        longest_plunges(tables.cycles, active, order)
        grind_plunges(
            tables.cycles, tables.parameters, episodes.wheels, episodes.parts, results, NO_MOTIONS, order, 0, 1
        )

    @entry
    def settle(
        tables: Tables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any, outcomes: Any
    ) -> None:
        """Write what the blocks that were run have cost and shown; as `Work.settle`."""
        shop = read_shop(tables.shops, 0)
        for i in active:
            settle_one(i, tables, episodes, choices, shop, results, outcomes)
        draw_coming(tables, episodes, active)

    return Work(Tables, EpisodeArrays, Choices, prepare, grind, settle)
