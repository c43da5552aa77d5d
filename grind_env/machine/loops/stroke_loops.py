"""The compiled loops over strokes, built from the `CycleKernel` of a cycle and a `Process`, eight machines at once.

When the cycle of a SIMD lane ends, its results are stored and the next machine is loaded. The numbers of one machine
are the same, bit by bit, with any others beside it (tests/machine).
"""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.kernel import entry, inlined, runs_alone
from grind_env.kernel.row_accessors import column_reader, column_writer, lane_reader, lane_writer
from grind_env.machine.loops.compiled_cycles import CycleKernel
from grind_env.machine.loops.cycle import PartState, Stroking, cycle_functions_of, grown_of, measured, stroke_seconds
from grind_env.machine.loops.part_surfaces import Buffer, Place, SurfaceLanes, covered_surface, zoned_surface
from grind_env.machine.loops.row_io import (
    OWN_FROM,
    RULES_FROM,
    read_parameters,
    read_stroking,
    read_tally,
    read_wheel,
    write_tally,
    write_wheel,
)
from grind_env.machine.loops.stroke_totals import Tally, wheel_depth
from grind_env.process.process_interface import PROCESS, Process
from grind_env.process.stroke_types import StrokeParameters, WheelState

LANES = 8  #: number of machines at once: one AVX-512 or two AVX2 registers wide

IDLE = -1  #: machine number of an empty lane


class Loops(NamedTuple):
    """The loops over the strokes of one kind of cycle."""

    #: `lanes(cycles, parameters, wheels, surfaces, tallies, motions, order, first, step)`: run the machines
    #: `order[first::step]` in SIMD lanes
    lanes: Callable[..., None]
    advance_lanes: Callable[..., None]  #: `advance_lanes(rows)`: make one stroke in every lane of a buffer


def loops_of(course: CycleKernel, process: Process = PROCESS) -> Loops:
    """Return the compiled loops over a cycle on parts that the wheel covers.

    Tables have one row a machine: `cycles` with the fields of `Stroking` and then of `course.cycle`, `parameters`
    of `StrokeParameters`, `wheels` of `WheelState` and then of `process.own`, `surfaces` of `PartState`, `tallies` of
    `Tally`.
    Wheels, surfaces and tallies are updated; a tally continues from its values. `course.find` finds strokes in the
    table `motions`. A table may have more columns.
    """
    return _loops(course, process, covered_surface)


def zoned_loops_of(course: CycleKernel, process: Process = PROCESS) -> Loops:
    """Return the compiled loops over a cycle on parts in zones; `surfaces` has shape (N, zones, fields of `Zone`)."""
    return _loops(course, process, zoned_surface)


@functools.cache
def _loops(
    course: CycleKernel, process: Process, surface_of: Callable[[Buffer], SurfaceLanes], width: int = LANES
) -> Loops:
    records: tuple[type[Any], ...] = (
        Stroking,
        course.cycle,
        StrokeParameters,
        process.held,
        process.held,
        WheelState,
        process.own,
        PartState,
        course.progress,
        Tally,
    )
    starts = [sum(len(record._fields) for record in records[:k]) for k in range(len(records) + 1)]
    event_row = starts[-1] * width
    get_stroking, get_cycle, get_p, get_slow, get_held, get_wheel, get_own, get_part, get_progress, get_tally = (
        lane_reader(record, start, width) for record, start in zip(records, starts, strict=False)
    )
    put_stroking, put_cycle, put_p, put_slow, put_held, put_wheel, put_own, put_part, put_progress, put_tally = (
        lane_writer(record, start, width) for record, start in zip(records, starts, strict=False)
    )
    read_cycle = column_reader(course.cycle, RULES_FROM)
    read_own, write_own = column_reader(process.own, OWN_FROM), column_writer(process.own, OWN_FROM)
    constants, grown, (advance, dress) = process.constants, grown_of(process), cycle_functions_of(process)
    begin, after_reversal, finished = course.begin, course.after_reversal, course.finished
    depth, edge, lost, find, gauged = course.depth, course.edge, course.lost, course.find, course.gauged

    @inlined
    def place_in(rows: Array, lane: int) -> Place:
        """Return the place of the coming stroke of a lane."""
        stroking, progress = get_stroking(rows, lane), get_progress(rows, lane)
        near, Z = edge(stroking, progress), depth(stroking, get_cycle(rows, lane), progress)
        face = wheel_depth(Z, get_tally(rows, lane)) + grown(get_own(rows, lane), get_held(rows, lane))
        return Place(Z=Z, depth=face, edge=near, end=near + get_p(rows, lane).bs)

    @inlined
    def stroke_in(rows: Array, lane: int, b: float, reached: float, part: PartState) -> Any:
        """Make the coming stroke of a lane, and the pick at the reversal that ends it."""
        stroking, cycle, progress = get_stroking(rows, lane), get_cycle(rows, lane), get_progress(rows, lane)
        wheel, own, part, tally, slow, fast = advance(
            stroking,
            depth(stroking, cycle, progress),
            stroke_seconds(stroking, progress.reversal),
            b,
            reached,
            get_wheel(rows, lane),
            get_own(rows, lane),
            part,
            get_tally(rows, lane),
            get_slow(rows, lane),
            get_held(rows, lane),
        )
        progress = after_reversal(cycle, progress)
        put_progress(rows, lane, progress)
        put_wheel(rows, lane, wheel)
        put_own(rows, lane, own)
        put_part(rows, lane, part)
        put_tally(rows, lane, tally)
        event = finished(cycle, progress) | (progress.dresses > 0.0) | lost(progress)
        rows[event_row + lane] = 1.0 if event else 0.0
        return slow, fast

    buffer = Buffer(
        lanes=width,
        rows=starts[-1] + 1,
        stroking=get_stroking,
        wheel=get_wheel,
        part=get_part,
        place=place_in,
        stroke=stroke_in,
    )
    surface = surface_of(buffer)
    buffer_size, part_of, load_surface, store_surface = surface.size, surface.begin, surface.load, surface.store
    advance_lanes = surface.advance_lanes

    @inlined
    def load(
        rows: Array, lane: int, cycles: Array, parameters: Array, wheels: Array, surfaces: Array, tallies: Array, i: int
    ) -> None:
        """Put machine i into a lane, at the start of its cycle."""
        stroking, cycle, p = read_stroking(cycles, i), read_cycle(cycles, i), read_parameters(parameters, i)
        put_stroking(rows, lane, stroking)
        put_cycle(rows, lane, cycle)
        put_p(rows, lane, p)
        put_slow(rows, lane, constants(p, stroking.slow, stroking.length))
        put_held(rows, lane, constants(p, stroking.speed, stroking.length))
        put_wheel(rows, lane, read_wheel(wheels, i))
        put_own(rows, lane, read_own(wheels, i))
        put_part(rows, lane, part_of(surfaces, i))
        put_progress(rows, lane, begin(cycle))
        put_tally(rows, lane, read_tally(tallies, i))
        load_surface(rows, lane, surfaces, i)

    @inlined
    def store(rows: Array, lane: int, wheels: Array, surfaces: Array, tallies: Array, i: int) -> None:
        """Write the state of a lane into the rows of machine i."""
        write_wheel(wheels, i, get_wheel(rows, lane))
        write_own(wheels, i, get_own(rows, lane))
        write_tally(tallies, i, get_tally(rows, lane))
        store_surface(rows, lane, surfaces, i)

    @inlined
    def serve(rows: Array, lane: int, motions: Array) -> None:
        """Find the coming stroke of a lane, and run the dress executions that are due before it."""
        stroking, p = get_stroking(rows, lane), get_p(rows, lane)
        wheel, own, tally = get_wheel(rows, lane), get_own(rows, lane), get_tally(rows, lane)
        progress, waited = find(get_cycle(rows, lane), get_progress(rows, lane), motions)
        if gauged(progress):
            wheel = measured(wheel)
        for number in range(int(progress.dresses)):
            wheel, own, tally = dress(stroking, wheel, own, tally, p, waited if number == 0 else 0.0)
        put_wheel(rows, lane, wheel)
        put_own(rows, lane, own)
        put_progress(rows, lane, progress)
        put_tally(rows, lane, tally)

    @entry
    def lanes(
        cycles: Array,
        parameters: Array,
        wheels: Array,
        surfaces: Array,
        tallies: Array,
        motions: Array,
        order: Array,
        first: int,
        step: int,
    ) -> None:
        if first >= order.size:
            return
        rows = np.empty(buffer_size(surfaces))
        machine = np.full(width, IDLE)
        upcoming, running, started = first, 0, False
        while True:
            for lane in range(width):
                due = rows[event_row + lane] > 0.0 and machine[lane] != IDLE
                while due or (machine[lane] == IDLE and upcoming < order.size):
                    if machine[lane] == IDLE:
                        machine[lane] = order[upcoming]
                        upcoming += step
                        load(rows, lane, cycles, parameters, wheels, surfaces, tallies, machine[lane])
                        running += 1
                    serve(rows, lane, motions)
                    due = False
                    if finished(get_cycle(rows, lane), get_progress(rows, lane)):
                        store(rows, lane, wheels, surfaces, tallies, machine[lane])
                        running -= 1
                        machine[lane] = IDLE
                if not started and machine[lane] == IDLE:
                    # an empty lane copies the first lane: finite numbers that nobody reads
                    for k in range(lane, rows.size, width):
                        rows[k] = rows[k - lane]
            started = True
            if running == 0:
                return
            advance_lanes(rows)

    if width > 1:
        runs_alone(lanes, lambda: _loops(course, process, surface_of, 1).lanes)
    return Loops(lanes, advance_lanes)
