"""A script run for many machines at once, in compiled code: every block with settings of its own."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import column_reader, column_writer
from grind_env.machine.batch import FEEDS, NO_MOTIONS, WHOLE, ZONED, ZONED_FEEDS
from grind_env.machine.cycle import Cycle, PartState
from grind_env.machine.feeding import FULL, Feeding, deepest_pick
from grind_env.machine.loops import Loops
from grind_env.machine.rows import read_part, read_zone, write_cycle
from grind_env.machine.rules import depth_after_pick, motion_time
from grind_env.machine.script_tables import NO_COURSE, NUMBERS, BlockRow, ScriptTables
from grind_env.machine.settings import BlockSettings, read_settings
from grind_env.machine.tally import Tally

read_block = column_reader(BlockRow)
write_feeding = column_writer(Feeding)
CYCLE_FIELDS, FEEDING_FIELDS = len(Cycle._fields), len(Feeding._fields)
STROKES = Tally._fields.index("strokes")


@inlined
def secondary_pick(row: BlockRow, settings: BlockSettings) -> float:
    """Q, mm; as J if the block has none (ruling 4)."""
    return row.secondary_pick if row.secondary_pick >= 0.0 else settings.J


@inlined
def deepest_plunge(row: BlockRow, settings: BlockSettings) -> float:
    """The larger one of J and Q, mm."""
    return max(settings.J, secondary_pick(row, settings))


@inlined
def cycle_of(row: BlockRow, settings: BlockSettings) -> Cycle:
    """The cycle of a block with settings of its own."""
    speed = settings.E / 60.0
    executions = settings.D if row.takes_dresses > 0.0 else 0.0  # numba takes no condition among many keywords
    return Cycle(
        speed=speed,
        first_seconds=motion_time(row.first_length, speed, row.acceleration) + row.dwell,
        stroke_seconds=motion_time(row.stroke_length, speed, row.acceleration) + row.dwell,
        start=row.start,
        target=row.target,
        surface=row.surface,
        bottom=row.bottom,
        primary_pick=settings.J,
        secondary_pick=secondary_pick(row, settings),
        at_depth=row.coverage + settings.L,
        executions=executions,
        pre_dress=row.pre_dress,
        full_plunge=deepest_plunge(row, settings) - DEPTH_TOLERANCE,
        finish=row.finish,
        width=row.width,
        length=row.length,
        dress_passes=settings.dress_passes,
        dress_feed=settings.dress_feed,
        dress_depth=settings.dress_depth,
        dress_seconds=settings.dress_seconds,
        cross_start=row.cross_start,
        cross_end=row.cross_end,
        primary_cross_pick=row.primary_cross_pick,
        secondary_cross_pick=row.secondary_cross_pick,
    )


@inlined
def feeding_of(row: BlockRow, settings: BlockSettings, made: float, full_plunge: float, reached: float) -> Feeding:
    """The strokes beside the motions of a block, after those that its cycle has `made`, down to a depth, mm."""
    speed = settings.E / 60.0
    first = motion_time(row.first_length, speed, row.acceleration)
    travel = motion_time(row.stroke_length, speed, row.acceleration)
    pre_dress = row.pre_dress if row.cycle == NO_COURSE else 0.0
    own = reached if row.cycle == NO_COURSE else max(reached, row.bottom)
    return Feeding(
        speed=speed,
        first_seconds=first + row.dwell,
        stroke_seconds=travel + row.dwell,
        pre_dress=pre_dress,
        full_plunge=full_plunge,
        finish=max(row.finish_besides, own),
        width=row.width,
        length=row.length,
        dress_passes=settings.dress_passes,
        dress_feed=settings.dress_feed,
        dress_depth=settings.dress_depth,
        dress_seconds=settings.dress_seconds,
        first_middle=0.5 * first,
        middle=0.5 * travel,
        acceleration=row.acceleration,
        surface=row.surface,
        made=made,
        away=row.away,
        to_secondary=row.to_secondary,
        motion=row.motion,
        gauged_at=row.gauged_at,
    )


@inlined
def ends_across(row: BlockRow, settings: BlockSettings) -> bool:
    """Whether the cycle comes to its end where its crossover ends, and not where that begins."""
    total, plunges, depth = row.target - row.start, 0.0, 0.0
    if row.cross_end == row.cross_start:
        return False
    while depth < total:
        plunges += 1.0
        depth = depth_after_pick(plunges, depth, total, settings.J, secondary_pick(row, settings))
    crossed = max(plunges, 1.0) - 1.0 + row.coverage + settings.L
    odd: bool = crossed > 2.0 * np.floor(0.5 * crossed)
    return odd


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
        settings: Any,
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
            settings: of that block, shape (N, fields of `BlockSettings`).
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
            row, chosen = read_block(script.blocks, block[i]), read_settings(settings, i)
            stands = row.start + row.surface
            picks[i] = max(min(deepest_plunge(row, chosen), row.target - row.start), stands - deepest(surfaces, i))
            numbers[i] = row.cycle
            if row.cycle != NO_COURSE:
                write_cycle(cycles, i, cycle_of(row, chosen))
        grind_cycles(numbers, cycles, parameters, wheels, surfaces, tallies)
        for i in active:
            row, chosen = read_block(script.blocks, block[i]), read_settings(settings, i)
            if row.motion >= 0.0:
                full = deepest_plunge(row, chosen) - DEPTH_TOLERANCE
                made, before = tallies[i, STROKES], deepest(surfaces, i)
                most, reached = deepest_pick(feeding_of(row, chosen, made, full, before), before, script.motions)
                if row.cycle == NO_COURSE:
                    full = FULL * most
                    picks[i] = most
                write_feeding(feedings, i, feeding_of(row, chosen, made, max(full, DEPTH_TOLERANCE), reached))
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
