"""A script run for many machines at once, in compiled code: every block with an E and a D of its own."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.control import Dwell, Line
from grind_env.control.cycles import RULES
from grind_env.control.rules import DEPTH_TOLERANCE, INSTANT
from grind_env.kernel import entry, inlined
from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.batch import FEEDS, NO_MOTIONS, WHOLE, ZONED, ZONED_FEEDS
from grind_env.machine.courses import COURSES
from grind_env.machine.cycle import Cycle, PartState
from grind_env.machine.dress_program import DressPlan
from grind_env.machine.feeding import ENDS, FULL, GOES_ON, Feeding, Motion, deepest_pick
from grind_env.machine.job import Job
from grind_env.machine.loops import Loops
from grind_env.machine.rows import read_part, read_zone, write_cycle
from grind_env.machine.rules import motion_time
from grind_env.machine.script import Script, ScriptBlock, depth_of, edge_of
from grind_env.machine.tally import Tally
from grind_env.machine.zones import EDGES, strip_centres, strip_zones, zones_of
from grind_env.process.cost import Limits

NO_COURSE = 0.0
NUMBERS = {code: float(number) for number, code in enumerate(COURSES, 1)}
"""Of the cycles that plunge."""

NO_BLOCK = -1.0
NO_DRESS = DressPlan(passes=0, feed=0.0, depth=0.0, seconds=0.0)

Table = NDArray[Any]


class BlockRow(NamedTuple):
    """A cycle block of a script in numbers. Depths are mm from the touched-off surface, into the part."""

    cycle: float
    """Its number in `NUMBERS`; `NO_COURSE` if all its strokes lie beside motions."""
    first_length: float
    """From the start point to the primary point, mm."""
    away: float
    """1 if the table sets out from elsewhere than its secondary point, else 0."""
    stroke_length: float
    """Between the reversal points, mm."""
    dwell: float
    """At a reversal point, s."""
    acceleration: float
    """mm/s2."""
    start: float
    target: float
    primary_pick: float
    secondary_pick: float
    at_depth: float
    pre_dress: float
    """1 for the .1 forms, else 0."""
    takes_dresses: float
    """1 if it may have a D word, else 0."""
    finish: float
    """Depth of the deepest block of its stage of the part."""
    reached: float
    """Depth to which the program has led on the part when the block is over."""
    width: float
    """Of the part, mm."""
    length: float
    """Of the part, mm."""
    dress_passes: float
    dress_feed: float
    """mm/s."""
    dress_depth: float
    dress_seconds: float
    cross_start: float
    cross_end: float
    primary_cross_pick: float
    secondary_cross_pick: float
    motion: float
    """Row of its first motion beside the table; `NO_BLOCK` without any."""
    gauged_at: float
    """Time beside these motions at which the operator gauges the part, s; infinite if he does not."""
    to_secondary: float
    """1 if the next cycle takes over the table, else 0."""
    before_from_secondary: float
    """Time on the way to the next block until the part is taken off, s, if the table rests at its secondary point."""
    before_from_primary: float
    after_from_secondary: float
    """Time from then on, s."""
    after_from_primary: float
    starts_part: float
    """1 if it is the first on its part, else 0."""
    ends_part: float
    """1 if the part is taken off after it, else 0."""
    gauged: float
    """1 if the operator gauges or takes off the part after it, so that the wear of the wheel is known; else 0."""
    judged: float
    """1 if a stage of the part ends after it, else 0."""
    counts_all: float
    """1 if the heat of every plunge of the stage counts, else 0."""
    rise: float
    """Limit of the stage, as of `process.cost.Limits`, like the next three."""
    power: float
    roughness: float
    size: float
    stock: float
    """To be off by the end of the stage, mm; 0 at the end of the part, whose own true stock counts."""


read_block = column_reader(BlockRow)
write_feeding = column_writer(Feeding)
CYCLE_FIELDS, FEEDING_FIELDS = len(Cycle._fields), len(Feeding._fields)
STROKES = Tally._fields.index("strokes")


class ScriptTables(NamedTuple):
    """A script in numbers."""

    blocks: Table
    """Shape (blocks, fields of `BlockRow`)."""
    motions: Table
    """Beside the tables of all blocks, shape (motions, fields of `Motion`)."""
    zones: Table
    """A new part, shape (zones, fields of `Zone`); one zone if the wheel covers it in every stroke."""


def tables_of(script: Script) -> ScriptTables:
    """A script in numbers."""
    motions: list[Motion] = []
    rows: list[BlockRow] = []
    starts, reached, first_of_stage, stage = True, 0.0, 0, 0
    job, stages = script.job, script.job.part.stages
    for number, block in enumerate(script.blocks):
        if starts:
            reached, first_of_stage, stage = 0.0, number, 0
        beside = _motions_of(block, job)
        reached = max(reached, _deepest(block, job))
        ends_stage = block.stops > 0 and stage < len(stages)
        judged = block.ends_part or ends_stage
        asked = stages[stage] if ends_stage else job.part
        limits = job.limits_at(asked)
        rows.append(
            _row(block, job, limits, reached, starts, len(motions) if beside else NO_BLOCK)._replace(
                judged=float(judged),
                counts_all=float(asked.rise_allowance > 0.0),
                stock=asked.stock if ends_stage else 0.0,
            )
        )
        motions += beside
        if judged:
            rows[first_of_stage:] = [row._replace(finish=reached) for row in rows[first_of_stage:]]
            first_of_stage, stage = number + 1, stage + 1
        starts = block.ends_part
    return ScriptTables(_table(rows, BlockRow), _table(motions, Motion), _zones(script, rows))


def is_whole(script: Script, tables: ScriptTables) -> bool:
    """Whether the wheel covers the parts of a script in every stroke, and no cycle of it crosses."""
    return len(tables.zones) == 1 and all(block.plan.cross_axis is None for block in script.blocks)


def _table(rows: list[Any], kind: type[Any]) -> Table:
    return np.array(rows, np.float64).reshape(len(rows), len(kind._fields))


def _row(block: ScriptBlock, job: Job, limits: Limits, reached: float, starts: bool, motion: float) -> BlockRow:
    plan, dress, part = block.plan, block.dress or NO_DRESS, job.part
    from_secondary, from_primary = block.ways
    first = block.start[plan.axis]
    start = depth_of(block.start, plan, job)
    edge = edge_of(block.start, plan)
    crosses = plan.cross_axis is not None
    return BlockRow(
        cycle=NUMBERS[plan.code] if plan.plunges else NO_COURSE,
        first_length=abs(plan.primary - first),
        away=float(first != plan.secondary and not block.taken_over),
        stroke_length=abs(plan.primary - plan.secondary),
        dwell=job.control.reversal_dwell,
        acceleration=job.control.acceleration,
        start=start,
        target=start if plan.plunge_axis is None else job.part.surface - plan.depth_target,
        primary_pick=plan.primary_pick,
        secondary_pick=plan.secondary_pick,
        at_depth=float(job.control.coverage_pass + plan.spark_out),
        pre_dress=float(plan.pre_dress and block.dress is not None),
        takes_dresses=float(block.takes_dresses),
        finish=reached,
        reached=reached,
        width=part.width,
        length=part.length,
        dress_passes=float(dress.passes),
        dress_feed=dress.feed,
        dress_depth=dress.depth,
        dress_seconds=dress.seconds,
        cross_start=plan.cross_start if crosses else edge,
        cross_end=plan.cross_end if crosses else edge,
        primary_cross_pick=plan.primary_cross_pick,
        secondary_cross_pick=plan.secondary_cross_pick,
        motion=motion,
        gauged_at=sum(each.seconds for each in block.beside) + INSTANT if block.gauged_on_the_way else math.inf,
        to_secondary=float(block.to_secondary),
        before_from_secondary=from_secondary.before,
        before_from_primary=from_primary.before,
        after_from_secondary=from_secondary.after,
        after_from_primary=from_primary.after,
        starts_part=float(starts),
        ends_part=float(block.ends_part),
        gauged=float(block.gauged),
        judged=0.0,
        counts_all=0.0,
        rise=limits.rise,
        power=limits.power,
        roughness=limits.roughness,
        size=limits.size,
        stock=0.0,
    )


def _deepest(block: ScriptBlock, job: Job) -> float:
    """Depth to which the program leads in a block, mm."""
    plan = block.plan
    depths = [depth_of(position, plan, job) for motion in block.beside for position in (motion.start, motion.end)]
    if plan.plunge_axis is not None:
        depths.append(job.part.surface - plan.depth_target)
    return max([depth_of(block.start, plan, job), *depths])


def _motions_of(block: ScriptBlock, job: Job) -> list[Motion]:
    """The motions beside the table; one of no time if its strokes go on without."""
    control, plan, time, rows = job.control, block.plan, 0.0, []
    total = sum(motion.seconds for motion in block.beside)
    for motion in block.beside:
        depth, edge = depth_of(motion.start, plan, job), edge_of(motion.start, plan)
        way, across = depth_of(motion.end, plan, job) - depth, edge_of(motion.end, plan) - edge
        feed = motion.feed if isinstance(motion, Line) else control.rapid_feed
        rows.append(
            Motion(
                begin=time,
                end=time + motion.seconds,
                depth=depth,
                way=way,
                cross=edge,
                cross_way=across,
                path=0.0 if isinstance(motion, Dwell) else float(np.hypot(way, across)),
                rate=feed / 60.0,
                last_begin=total - INSTANT,
                leg_seconds=total,
                after=GOES_ON,
            )
        )
        time += motion.seconds
    if rows:
        return [*rows[:-1], rows[-1]._replace(after=ENDS)]
    if not (block.to_secondary or block.gauged_on_the_way) and plan.plunges:
        return []
    depth = depth_of(block.start, plan, job) if plan.plunge_axis is None else job.part.surface - plan.depth_target
    edge = edge_of(block.start, plan)
    return [Motion(0.0, 0.0, depth, 0.0, edge, 0.0, 0.0, 1.0, -INSTANT, 0.0, ENDS)]


def _zones(script: Script, rows: Sequence[BlockRow]) -> Table:
    """A new part in zones: strip by strip where the wheel crosses beside the table, at any place."""
    part, wheel = script.job.part, script.job.setup.wheel
    centres, edges = strip_centres(part.across, part.width), set()
    for block, row in zip(script.blocks, rows, strict=True):
        places = {edge_of(position, block.plan) for motion in block.beside for position in (motion.start, motion.end)}
        if len(places) > 1:
            return strip_zones(centres)
        edges |= {row.cross_start, *places}
        if block.plan.cross_axis is not None:
            code, coverage = block.plan.code, script.job.control.coverage_pass
            edges |= set(EDGES[code](RULES[code].cycle_of(block.plan, coverage), row.cross_start, row.cross_end))
    return zones_of(centres, edges, wheel.width)


@inlined
def cycle_of(row: BlockRow, E: float, D: float) -> Cycle:
    """The cycle of a block with E (mm/min) and D."""
    speed = E / 60.0
    return Cycle(
        speed=speed,
        first_seconds=motion_time(row.first_length, speed, row.acceleration) + row.dwell,
        stroke_seconds=motion_time(row.stroke_length, speed, row.acceleration) + row.dwell,
        start=row.start,
        target=row.target,
        primary_pick=row.primary_pick,
        secondary_pick=row.secondary_pick,
        at_depth=row.at_depth,
        executions=D,
        pre_dress=row.pre_dress,
        full_plunge=max(row.primary_pick, row.secondary_pick) - DEPTH_TOLERANCE,
        finish=row.finish,
        width=row.width,
        length=row.length,
        dress_passes=row.dress_passes,
        dress_feed=row.dress_feed,
        dress_depth=row.dress_depth,
        dress_seconds=row.dress_seconds,
        cross_start=row.cross_start,
        cross_end=row.cross_end,
        primary_cross_pick=row.primary_cross_pick,
        secondary_cross_pick=row.secondary_cross_pick,
    )


@inlined
def feeding_of(row: BlockRow, E: float, made: float, full_plunge: float) -> Feeding:
    """The strokes beside the motions of a block with E (mm/min), after those that its cycle has `made`."""
    speed = E / 60.0
    first = motion_time(row.first_length, speed, row.acceleration)
    travel = motion_time(row.stroke_length, speed, row.acceleration)
    pre_dress = row.pre_dress if row.cycle == NO_COURSE else 0.0  # numba takes no condition among many keywords
    return Feeding(
        speed=speed,
        first_seconds=first + row.dwell,
        stroke_seconds=travel + row.dwell,
        pre_dress=pre_dress,
        full_plunge=full_plunge,
        finish=row.finish,
        width=row.width,
        length=row.length,
        dress_passes=row.dress_passes,
        dress_feed=row.dress_feed,
        dress_depth=row.dress_depth,
        dress_seconds=row.dress_seconds,
        first_middle=0.5 * first,
        middle=0.5 * travel,
        acceleration=row.acceleration,
        made=made,
        away=row.away,
        to_secondary=row.to_secondary,
        motion=row.motion,
        gauged_at=row.gauged_at,
    )


@inlined
def _none(numbers: Any, cycles: Any, parameters: Any, wheels: Any, surfaces: Any, tallies: Any) -> None:
    pass


def _in_turn(loops: Mapping[str, Loops]) -> Callable[..., None]:
    """`run(numbers, cycles, parameters, wheels, surfaces, tallies)`: machines by the numbers of their cycles."""
    (code, first), *others = loops.items()
    number, grind_cycles = NUMBERS[code], first.lanes
    grind_others = _in_turn(dict(others)) if others else _none

    @entry
    def run(numbers: Any, cycles: Any, parameters: Any, wheels: Any, surfaces: Any, tallies: Any) -> None:
        order = np.flatnonzero(numbers == number)
        grind_cycles(cycles, parameters, wheels, surfaces, tallies, NO_MOTIONS, order, 0, 1)
        grind_others(numbers, cycles, parameters, wheels, surfaces, tallies)

    return run


def blocks_of(loops: Mapping[str, Loops], feeds: Loops, deepest: Callable[..., float]) -> Callable[..., None]:
    """The compiled run of a block of each of some machines, made of the loops over surfaces of one kind.

    Args:
        loops: of the cycles that plunge, by their codes.
        feeds: of the strokes beside motions.
        deepest: `deepest(surfaces, i)`: depth of the deepest stroke on machine i, mm.
    """
    grind_cycles, grind_feedings = _in_turn(loops), feeds.lanes

    @entry
    def grind_blocks(
        script: ScriptTables,
        block: Any,
        speeds: Any,
        executions: Any,
        parameters: Any,
        wheels: Any,
        surfaces: Any,
        tallies: Any,
        picks: Any,
        active: Any,
    ) -> None:
        """Run a block on each of some machines.

        Args:
            script: the program.
            block: number of the block of each machine, shape (N,), int64.
            speeds: E, mm/min, shape (N,).
            executions: D, shape (N,).
            parameters: shape (N, fields of `StrokeParameters`).
            wheels: shape (N, fields of `WheelState`); updated.
            surfaces: shape (N, fields of `PartState`) or (N, zones, fields of `Zone`); updated.
            tallies: shape (N, fields of `Tally`); updated.
            picks: by how much a stroke has gone deeper at most, mm, shape (N,); written.
            active: machines to run, int64.
        """
        n = block.size
        cycles, feedings = np.empty((n, CYCLE_FIELDS)), np.empty((n, FEEDING_FIELDS))
        numbers, feeding, feeds = np.full(n, NO_COURSE), np.empty(n, np.int64), 0
        for i in active:
            row = read_block(script.blocks, block[i])
            D = executions[i] if row.takes_dresses > 0.0 else 0.0
            picks[i] = max(
                min(max(row.primary_pick, row.secondary_pick), row.target - row.start), row.start - deepest(surfaces, i)
            )
            numbers[i] = row.cycle
            if row.cycle != NO_COURSE:
                write_cycle(cycles, i, cycle_of(row, speeds[i], D))
        grind_cycles(numbers, cycles, parameters, wheels, surfaces, tallies)
        for i in active:
            row = read_block(script.blocks, block[i])
            if row.motion >= 0.0:
                full = max(row.primary_pick, row.secondary_pick) - DEPTH_TOLERANCE
                made, reached = tallies[i, STROKES], deepest(surfaces, i)
                most = deepest_pick(feeding_of(row, speeds[i], made, full), reached, script.motions)
                if row.cycle == NO_COURSE:
                    full = FULL * most
                    picks[i] = most
                write_feeding(feedings, i, feeding_of(row, speeds[i], made, max(full, DEPTH_TOLERANCE)))
                feeding[feeds] = i
                feeds += 1
        grind_feedings(feedings, parameters, wheels, surfaces, tallies, script.motions, feeding[:feeds], 0, 1)

    return grind_blocks


@inlined
def _deepest_whole(surfaces: Any, i: int) -> float:
    part: PartState = read_part(surfaces, i)
    return part.Z


@inlined
def _deepest_zoned(surfaces: Any, i: int) -> float:
    reached = 0.0
    for number in range(surfaces.shape[1]):
        reached = max(reached, read_zone(surfaces[i], number).reached)
    return reached


grind_blocks = blocks_of(WHOLE, FEEDS, _deepest_whole)
"""On parts that the wheel covers, in cycles that do not cross."""
grind_zoned_blocks = blocks_of(ZONED, ZONED_FEEDS, _deepest_zoned)
"""On parts in zones."""
