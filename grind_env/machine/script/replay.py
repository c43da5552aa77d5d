"""Replay a script for many machines at once in compiled code, each block with settings of its own."""

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.control.cycles import RULES, Rules
from grind_env.kernel import entry, inlined, inlined_rule
from grind_env.kernel.row_accessors import column_reader, column_writer, replacer
from grind_env.machine.loops.compiled_cycles import CYCLE_KERNELS, CycleKernel, never
from grind_env.machine.loops.compiled_motion import motion_time
from grind_env.machine.loops.concurrent_strokes import FEED, FULL, Feeding, deepest_pick
from grind_env.machine.loops.cycle import PartState, Stroking
from grind_env.machine.loops.machine_lanes import NO_MOTIONS, longest_first_of
from grind_env.machine.loops.part_surfaces import deepest_zone
from grind_env.machine.loops.row_io import RULES_FROM, read_part, write_stroking
from grind_env.machine.loops.stroke_loops import Loops, loops_of, zoned_loops_of
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.loops.table_speed import pace_of
from grind_env.machine.script.block_settings import BlockSettings, read_settings
from grind_env.machine.script.script_tables import CYCLE, NO_CYCLE, NUMBERS, BlockRow, PlanRow
from grind_env.process.process_interface import Drive, Process

read_block, read_plan = column_reader(BlockRow), column_reader(PlanRow)
write_feeding = column_writer(Feeding, RULES_FROM)
with_settings = replacer(PlanRow, "primary_pick", "secondary_pick", "spark_out", "dresses")
with_finish = replacer(Stroking, "full_plunge", "finish")
STROKES = Tally._fields.index("strokes")


class BlockPlace(NamedTuple):
    """Place of a block on the part of one machine, from `BlockRow` and its plan.

    `start`, `bottom`, `finish` and `finish_of_other_blocks` are mm. `share`, a ratio, and `dwell`, s, are true values
    of the table, as in `Drive`.
    """

    start: float
    bottom: float
    finish: float
    finish_of_other_blocks: float
    depth: float  #: from `start` to `bottom`, mm
    pre_dress: float  #: 1 for a dress before the first stroke, else 0
    motion: float  #: index of its first motion beside the table; `NO_BLOCK` without any
    pick: float  #: largest gain in depth of a stroke, mm; negative if unknown: a run of the block finds it
    share: float
    dwell: float
    #: 1 if its cycle, once run, ended where its crossover ends, else 0; negative before the run if nobody asks, which
    #: saves time
    across: float


MOTION, PICK, ACROSS = (BlockPlace._fields.index(name) for name in ("motion", "pick", "across"))
read_place, write_place = column_reader(BlockPlace), column_writer(BlockPlace)
with_place = replacer(BlockRow, "start", "bottom", "finish", "finish_of_other_blocks", "motion")
with_depth = replacer(PlanRow, "depth", "pre_dress")


@inlined
def place_as_programmed(places: Any, i: int, row: BlockRow, plan: Any, drive: Drive) -> None:
    """Place the block of machine i as the program does."""
    here = row.start, row.bottom, row.finish, row.finish_of_other_blocks, plan.depth, plan.pre_dress
    write_place(places, i, BlockPlace(*here, row.motion, -1.0, drive.share, drive.dwell, 0.0))


@inlined
def plan_of(row: BlockRow, own: Any, settings: BlockSettings) -> Any:
    """Return the plan of a block with chosen settings; without a Q of its own, Q is J (ruling 4)."""
    Q = own.secondary_pick if own.secondary_pick >= 0.0 else settings.J
    D = settings.D if row.takes_dresses > 0.0 else 0.0
    return with_settings(own, (settings.J, Q, settings.L, D))


@inlined
def chosen_block(script: Any, i: int) -> tuple[BlockRow, Any, BlockSettings, BlockPlace]:
    """Return the block of machine i at its place on this machine, its plan, its chosen settings and its place."""
    number, chosen, place = script.rows[i], read_settings(script.settings, i), read_place(script.places, i)
    row = read_block(script.blocks, number)
    row = with_place(row, (place.start, place.bottom, place.finish, place.finish_of_other_blocks, place.motion))
    plan = with_depth(read_plan(script.plans, number), (place.depth, place.pre_dress))
    return row, plan_of(row, plan, chosen), chosen, place


@inlined
def deepest_plunge(plan: Any) -> float:
    """Return the larger one of J and Q, mm."""
    deepest: float = max(plan.primary_pick, plan.secondary_pick)
    return deepest


@inlined
def stroking_of(row: BlockRow, plan: Any, settings: BlockSettings, place: BlockPlace) -> tuple[Stroking, float, float]:
    """Return the strokes of a block with chosen settings, and the time of its first stroke and of the others, s."""
    speed, dwell = place.share * settings.E / 60.0, place.dwell
    travel = motion_time(row.stroke_length, speed, row.acceleration)
    first = travel
    if row.first_length != row.stroke_length:
        first = motion_time(row.first_length, speed, row.acceleration)
    pace = pace_of(speed, row.stroke_length, row.length, row.off, row.acceleration)
    stroking = Stroking(
        speed=pace.speed,
        slow=pace.slow,
        slow_share=pace.slow_share,
        slow_time=pace.slow_time,
        first_seconds=first + dwell,
        stroke_seconds=travel + dwell,
        set_out=first + dwell,
        start=row.start,
        surface=row.surface,
        bottom=row.bottom,
        full_plunge=deepest_plunge(plan) - DEPTH_TOLERANCE,
        finish=row.finish,
        width=row.width,
        length=row.length,
        dress_passes=settings.dress_passes,
        dress_feed=settings.dress_feed,
        dress_depth=settings.dress_depth,
        dress_seconds=settings.dress_seconds,
        cross_start=row.cross_start,
        cross_end=row.cross_end,
    )
    return stroking, first, travel


@inlined
def feeding_of(row: BlockRow, plan: Any, first: float, travel: float, dwell: float, made: float) -> Feeding:
    """Return the strokes beside the motions of a block, after `made` strokes of its cycle; times as `stroking_of`."""
    pre_dress = plan.pre_dress if row.cycle == NO_CYCLE else 0.0
    return Feeding(
        pre_dress=pre_dress,
        first_travel=first,
        travel=travel,
        dwell=dwell,
        acceleration=row.acceleration,
        made=made,
        starts_elsewhere=row.starts_elsewhere,
        to_secondary=row.to_secondary,
        motion=row.motion,
        gauged_at=row.gauged_at,
    )


@inlined
def _no_rules(number: float, plan: Any, coverage: Any, asked: bool, cycles: Any, i: int) -> bool:
    return False


def _writer(codes: Sequence[str]) -> Callable[..., bool]:
    """Return `write(number, plan, coverage, asked, cycles, i) -> across`; it writes rule numbers of a cycle to row i.

    `across` is, if `asked`, whether the cycle ends where its crossover ends, and not where the crossover begins.
    """
    if not codes:
        return _no_rules
    code, *others = codes
    own, rules, course = NUMBERS[code], RULES[code], CYCLE_KERNELS[code]
    cycle_of, is_across, write_others = inlined_rule(rules.cycle_of), _ends_across(rules, course), _writer(others)
    write_cycle = column_writer(course.cycle, RULES_FROM)

    @inlined
    def write(number: float, plan: Any, coverage: Any, asked: bool, cycles: Any, i: int) -> bool:
        if number != own:
            return write_others(number, plan, coverage, asked, cycles, i)
        cycle = cycle_of(plan, coverage)
        write_cycle(cycles, i, cycle)
        return asked and is_across(cycle)

    return write


def _ends_across(rules: Rules, course: CycleKernel) -> Callable[[Any], bool]:
    if rules.cross is None:
        return never
    begin, after_reversal, finished = course.begin, course.after_reversal, course.finished
    cross, narrowed = inlined_rule(rules.cross), replacer(course.cycle, "width")

    @inlined
    def ends_across(cycle: Any) -> bool:
        # plunges and traverses at depth decide; the width of the crossover does not matter
        narrow = narrowed(cycle, (0.0,))
        progress = begin(narrow)
        while not finished(narrow, progress):
            progress = after_reversal(narrow, progress)
        return cycle.width > 0.0 and cross(progress, 0.0, 1.0) > 0.0

    return ends_across


@inlined
def _none(script: Any, active: Any, wheels: Any, surfaces: Any, tallies: Any) -> None:
    pass


def _in_turn(loops: Mapping[str, Loops]) -> Callable[..., None]:
    """Return `run(script, active, wheels, surfaces, tallies)`, which runs the blocks cycle by cycle."""
    (code, first), *others = loops.items()
    number, grind_cycles, cycle = NUMBERS[code], first.lanes, CYCLE_KERNELS[code].cycle
    longest_first = longest_first_of(cycle)  # type: ignore[arg-type]
    grind_others = _in_turn(dict(others)) if others else _none

    @entry
    def run(script: Any, active: Any, wheels: Any, surfaces: Any, tallies: Any) -> None:
        mine, count = np.empty(active.size, np.int64), 0
        for i in active:
            if script.blocks[script.rows[i], CYCLE] == number:
                mine[count] = i
                count += 1
        order = np.empty(count, np.int64)
        longest_first(script.cycles, mine[:count], order)
        grind_cycles(script.cycles, script.parameters, wheels, surfaces, tallies, NO_MOTIONS, order, 0, 1)
        grind_others(script, active, wheels, surfaces, tallies)

    return run


def blocks_of(loops: Mapping[str, Loops], feeds: Loops, deepest: Callable[..., float]) -> Callable[..., None]:
    """Return the compiled function that runs a block on each machine, for surfaces of one kind.

    Args:
        loops: loops of the cycles that plunge, by code.
        feeds: loops of the strokes beside motions.
        deepest: `deepest(surfaces, i)`: depth of the deepest stroke on machine i, mm.
    """
    write_rules, grind_cycles, grind_feedings = _writer(list(loops)), _in_turn(loops), feeds.lanes

    @entry
    def grind_blocks(script: Any, wheels: Any, surfaces: Any, tallies: Any, active: Any) -> None:
        """Run a block on each of some machines.

        Args:
            script: `blocks`, `plans` and `motions` of `ScriptTables`; `rows`, the block of each machine, shape (N,),
                int64; its `settings`, shape (N, fields of `BlockSettings`), and `parameters`, shape (N, fields of
                `StrokeParameters`); `places`, shape (N, fields of `BlockPlace`), updated; room for `cycles`,
                shape (N, `CYCLE_FIELDS`).
            wheels: shape (N, fields of `WheelState` and of the `own` of the process); updated.
            surfaces: shape (N, fields of `PartState`) or (N, zones, fields of `Zone`); updated.
            tallies: shape (N, fields of `Tally`); updated.
            active: machines to run, int64.
        """
        cycles, places = script.cycles, script.places
        feeding, feeds = np.empty(active.size, np.int64), 0
        for i in active:
            if script.blocks[script.rows[i], CYCLE] == NO_CYCLE:
                continue
            row, plan, chosen, here = chosen_block(script, i)
            if here.pick < 0.0:
                places[i, PICK] = max(
                    min(deepest_plunge(plan), plan.depth), row.start + row.surface - deepest(surfaces, i)
                )
            stroking, _, _ = stroking_of(row, plan, chosen, here)
            write_stroking(cycles, i, stroking)
            asked = here.across >= 0.0
            places[i, ACROSS] = 1.0 if write_rules(row.cycle, plan, row.coverage, asked, cycles, i) else 0.0
        grind_cycles(script, active, wheels, surfaces, tallies)
        for i in active:
            if places[i, MOTION] >= 0.0:
                row, plan, chosen, here = chosen_block(script, i)
                before, (stroking, first, travel) = deepest(surfaces, i), stroking_of(row, plan, chosen, here)
                cycle = feeding_of(row, plan, first, travel, here.dwell, tallies[i, STROKES])
                most, reached = here.pick, row.bottom
                if most < 0.0 or row.cycle != NO_CYCLE:
                    most, reached = deepest_pick(stroking, cycle, before, script.motions)
                full = stroking.full_plunge
                if row.cycle == NO_CYCLE:
                    full = FULL * most
                    places[i, PICK] = most
                else:
                    reached = max(reached, row.bottom)
                finish = max(row.finish_of_other_blocks, reached)
                write_stroking(cycles, i, with_finish(stroking, (max(full, DEPTH_TOLERANCE), finish)))
                write_feeding(cycles, i, cycle)
                feeding[feeds] = i
                feeds += 1
        grind_feedings(cycles, script.parameters, wheels, surfaces, tallies, script.motions, feeding[:feeds], 0, 1)

    return grind_blocks


@inlined
def _deepest_covered(surfaces: Any, i: int) -> float:
    part: PartState = read_part(surfaces, i)
    return part.Z


@functools.cache
def covered_blocks_of(process: Process) -> Callable[..., None]:
    """Return the run of blocks on parts that the wheel covers, in cycles that do not cross."""
    courses = {code: course for code, course in CYCLE_KERNELS.items() if RULES[code].cross is None}
    loops = {code: loops_of(course, process) for code, course in courses.items()}
    return blocks_of(loops, loops_of(FEED, process), _deepest_covered)


@functools.cache
def zoned_blocks_of(process: Process) -> Callable[..., None]:
    """Return the run of blocks on parts in zones, in all cycles."""
    loops = {code: zoned_loops_of(course, process) for code, course in CYCLE_KERNELS.items()}
    return blocks_of(loops, zoned_loops_of(FEED, process), deepest_zone)
