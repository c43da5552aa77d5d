"""The block kernel: the cycles of eight machines in SIMD lanes.

When a lane's cycle ends, its results are stored and the next machine is loaded into the lane. The numbers for one
machine are bit by bit those of the scalar loop in `batch.py`, whatever runs beside it (tests/machine).
"""

import numpy as np

from grind_env.control.cycles.plunge import PlungeProgress
from grind_env.kernel import entry, inlined
from grind_env.kernel.rows import lane_reader, lane_writer
from grind_env.machine.cycle import Ahead, Cycle, CycleResult, PartState, advance, begin, dress, finished
from grind_env.machine.rows import (
    Table,
    read_cycle,
    read_parameters,
    read_part,
    read_wheel,
    write_part,
    write_result,
    write_wheel,
)
from grind_env.process.state import StrokeParameters, WheelState

LANES = 8
"""Machines per block: one AVX-512 or two AVX2 registers wide."""

IDLE = -1
"""Machine number of a lane that has none."""

# the rows of the lane buffer: the records one after the other, then a row of flags for lanes that need attention
RECORDS = (Cycle, StrokeParameters, WheelState, PartState, PlungeProgress, Ahead, CycleResult)
STARTS = [sum(len(record._fields) for record in RECORDS[:k]) for k in range(len(RECORDS) + 1)]
EVENT_ROW = STARTS[-1] * LANES
BUFFER_SIZE = EVENT_ROW + LANES

get_cycle, put_cycle = lane_reader(Cycle, STARTS[0], LANES), lane_writer(Cycle, STARTS[0], LANES)
get_parameters = lane_reader(StrokeParameters, STARTS[1], LANES)
put_parameters = lane_writer(StrokeParameters, STARTS[1], LANES)
get_wheel, put_wheel = lane_reader(WheelState, STARTS[2], LANES), lane_writer(WheelState, STARTS[2], LANES)
get_part, put_part = lane_reader(PartState, STARTS[3], LANES), lane_writer(PartState, STARTS[3], LANES)
get_progress = lane_reader(PlungeProgress, STARTS[4], LANES)
put_progress = lane_writer(PlungeProgress, STARTS[4], LANES)
get_ahead, put_ahead = lane_reader(Ahead, STARTS[5], LANES), lane_writer(Ahead, STARTS[5], LANES)
get_result, put_result = lane_reader(CycleResult, STARTS[6], LANES), lane_writer(CycleResult, STARTS[6], LANES)


@inlined
def load(rows: Table, lane: int, cycles: Table, parameters: Table, wheels: Table, parts: Table, i: int) -> None:
    """Put machine i into a lane, at the start of its cycle."""
    cycle, part = read_cycle(cycles, i), read_part(parts, i)
    progress, ahead, result = begin(cycle, part)
    put_cycle(rows, lane, cycle)
    put_parameters(rows, lane, read_parameters(parameters, i))
    put_wheel(rows, lane, read_wheel(wheels, i))
    put_part(rows, lane, part)
    put_progress(rows, lane, progress)
    put_ahead(rows, lane, ahead)
    put_result(rows, lane, result)


@inlined
def store(rows: Table, lane: int, wheels: Table, parts: Table, results: Table, i: int) -> None:
    """Write what a lane holds to machine i."""
    write_wheel(wheels, i, get_wheel(rows, lane))
    write_part(parts, i, get_part(rows, lane))
    write_result(results, i, get_result(rows, lane))


@inlined
def dress_pending(rows: Table, lane: int) -> None:
    """Run the dress executions that are due in a lane."""
    cycle, p = get_cycle(rows, lane), get_parameters(rows, lane)
    wheel, result = get_wheel(rows, lane), get_result(rows, lane)
    for _ in range(int(get_progress(rows, lane).dresses)):
        wheel, result = dress(cycle, wheel, result, p)
    put_wheel(rows, lane, wheel)
    put_result(rows, lane, result)


@entry
def advance_lanes(rows: Table) -> None:
    """One stroke in every lane. A function of its own: the loop vectorises only with nothing but `rows` in sight."""
    for lane in range(LANES):
        cycle = get_cycle(rows, lane)
        progress, ahead, wheel, part, result, _ = advance(
            cycle,
            get_progress(rows, lane),
            get_ahead(rows, lane),
            get_wheel(rows, lane),
            get_part(rows, lane),
            get_result(rows, lane),
            get_parameters(rows, lane),
        )
        put_progress(rows, lane, progress)
        put_ahead(rows, lane, ahead)
        put_wheel(rows, lane, wheel)
        put_part(rows, lane, part)
        put_result(rows, lane, result)
        event = finished(cycle, progress) | (progress.dresses > 0.0)
        rows[EVENT_ROW + lane] = 1.0 if event else 0.0


@entry
def run_blocks(
    cycles: Table,
    parameters: Table,
    wheels: Table,
    parts: Table,
    results: Table,
    order: Table,
    first: int,
    step: int,
) -> None:
    """Run the cycles of machines `order[first::step]`.

    Args:
        cycles: shape (N, fields of `Cycle`), like all tables one row a machine.
        parameters: shape (N, fields of `StrokeParameters`).
        wheels: shape (N, fields of `WheelState`); updated in place.
        parts: shape (N, fields of `PartState`); updated in place.
        results: shape (N, fields of `CycleResult`); written.
        order: machine numbers.
        first: position in `order` of the first machine to run.
        step: distance in `order` to the next.
    """
    if first >= order.size:
        return
    rows = np.empty(BUFFER_SIZE)
    machine = np.full(LANES, IDLE)
    upcoming = first
    running = 0
    for lane in range(LANES):
        if upcoming < order.size:
            machine[lane] = order[upcoming]
            running += 1
            upcoming += step
        # an idle lane repeats the first machine: finite numbers that nobody reads
        i = machine[lane] if machine[lane] != IDLE else order[first]
        load(rows, lane, cycles, parameters, wheels, parts, i)
        dress_pending(rows, lane)
    while running > 0:
        advance_lanes(rows)
        for lane in range(LANES):
            if rows[EVENT_ROW + lane] > 0.0 and machine[lane] != IDLE:
                dress_pending(rows, lane)
                if finished(get_cycle(rows, lane), get_progress(rows, lane)):
                    store(rows, lane, wheels, parts, results, machine[lane])
                    running -= 1
                    machine[lane] = IDLE
                    if upcoming < order.size:
                        machine[lane] = order[upcoming]
                        running += 1
                        upcoming += step
                        load(rows, lane, cycles, parameters, wheels, parts, machine[lane])
                        dress_pending(rows, lane)
