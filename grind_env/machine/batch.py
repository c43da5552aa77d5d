"""Cycles of many machines at once.

The block kernel runs eight machines in SIMD lanes. When a lane's cycle ends, its results are stored and the next
machine is loaded into it; machines are dealt longest predicted cycle first, so that the lanes end together. The
numbers for one machine are bit by bit those of the scalar loop, whatever runs beside it (tests/machine).
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.kernel import entry, inlined
from grind_env.kernel.rows import column_reader, column_writer, dtype_of, row_reader, row_writer
from grind_env.machine.cycle import Cycle, CycleResult, PartState, Progress, advance, begin, dress, finished
from grind_env.process.state import Stroke, StrokeParameters, WheelState

LANES = 8
"""Machines per block: one AVX-512 or two AVX2 registers wide."""

LONGEST_BUCKET = 1024
"""Cycles of at least this many predicted strokes are not sorted among themselves."""

CYCLE = dtype_of(Cycle)
PARAMETERS = dtype_of(StrokeParameters)
WHEEL = dtype_of(WheelState)
PART = dtype_of(PartState)
RESULT = dtype_of(CycleResult)
STROKE = dtype_of(Stroke)

Table = NDArray[Any]

IDLE = -1
"""Machine number of a lane that has none."""

read_cycle, read_parameters = column_reader(Cycle), column_reader(StrokeParameters)
read_wheel, write_wheel = column_reader(WheelState), column_writer(WheelState)
read_part, write_part = column_reader(PartState), column_writer(PartState)
write_result = column_writer(CycleResult)
write_stroke = column_writer(Stroke)


def block_kernel(lanes: int) -> Callable[..., None]:
    """The kernel for blocks of that many lanes.

    The result takes two-dimensional float64 arrays, one row a machine and one column a field:
    `(cycles, parameters, wheels, parts, results, log, order, first, step)`. Machines `order[first::step]` are
    run; `wheels` and `parts` are updated in place. `log` has shape (machines, strokes, fields of `Stroke`) or is
    empty; strokes beyond its length are not logged.
    """
    records = (Cycle, StrokeParameters, WheelState, PartState, Progress, CycleResult, Stroke)
    starts = np.cumsum([0] + [len(record._fields) for record in records])
    (get_cycle, get_parameters, get_wheel, get_part, get_progress, get_result, get_stroke) = (
        row_reader(record, int(start), lanes) for record, start in zip(records, starts, strict=False)
    )
    (put_cycle, put_parameters, put_wheel, put_part, put_progress, put_result, put_stroke) = (
        row_writer(record, int(start), lanes) for record, start in zip(records, starts, strict=False)
    )
    event_row = int(starts[-1]) * lanes
    buffer_size = event_row + lanes

    @inlined
    def load(
        rows: Table, lane: int, cycles: Table, parameters: Table, wheels: Table, parts: Table, i: int
    ) -> None:
        cycle, part = read_cycle(cycles, i), read_part(parts, i)
        progress, result = begin(cycle, part)
        put_cycle(rows, lane, cycle)
        put_parameters(rows, lane, read_parameters(parameters, i))
        put_wheel(rows, lane, read_wheel(wheels, i))
        put_part(rows, lane, part)
        put_progress(rows, lane, progress)
        put_result(rows, lane, result)

    @inlined
    def store(rows: Table, lane: int, wheels: Table, parts: Table, results: Table, i: int) -> None:
        write_wheel(wheels, i, get_wheel(rows, lane))
        write_part(parts, i, get_part(rows, lane))
        write_result(results, i, get_result(rows, lane))

    @inlined
    def dress_pending(rows: Table, lane: int) -> None:
        cycle, p = get_cycle(rows, lane), get_parameters(rows, lane)
        wheel, result = get_wheel(rows, lane), get_result(rows, lane)
        for _ in range(int(get_progress(rows, lane).pending)):
            wheel, result = dress(cycle, wheel, result, p)
        put_wheel(rows, lane, wheel)
        put_result(rows, lane, result)

    # a function of its own, because the loop vectorises only while nothing but `rows` is in sight
    @entry
    def advance_lanes(rows: Table) -> None:
        for lane in range(lanes):
            cycle = get_cycle(rows, lane)
            progress, wheel, part, result, stroke = advance(
                cycle,
                get_progress(rows, lane),
                get_wheel(rows, lane),
                get_part(rows, lane),
                get_result(rows, lane),
                get_parameters(rows, lane),
            )
            put_progress(rows, lane, progress)
            put_wheel(rows, lane, wheel)
            put_part(rows, lane, part)
            put_result(rows, lane, result)
            put_stroke(rows, lane, stroke)
            event = finished(cycle, progress) | (progress.pending > 0.0)
            rows[event_row + lane] = 1.0 if event else 0.0

    @entry
    def run(
        cycles: Table,
        parameters: Table,
        wheels: Table,
        parts: Table,
        results: Table,
        log: Table,
        order: Table,
        first: int,
        step: int,
    ) -> None:
        if first >= order.size:
            return
        rows = np.empty(buffer_size)
        machine = np.full(lanes, IDLE)
        upcoming = first
        running = 0
        for lane in range(lanes):
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
            if log.shape[1] > 0:
                for lane in range(lanes):
                    number = int(get_progress(rows, lane).reversal) - 1
                    if machine[lane] != IDLE and number < log.shape[1]:
                        write_stroke(log[machine[lane]], number, get_stroke(rows, lane))
            for lane in range(lanes):
                if rows[event_row + lane] > 0.0 and machine[lane] != IDLE:
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

    return run


run_blocks = block_kernel(LANES)


@entry
def run_scalar(
    cycles: Table,
    parameters: Table,
    wheels: Table,
    parts: Table,
    results: Table,
    log: Table,
    order: Table,
    first: int,
    step: int,
) -> None:
    """One machine after the other: what the block kernel must reproduce bit by bit."""
    for k in range(first, order.size, step):
        i = order[k]
        cycle, p = read_cycle(cycles, i), read_parameters(parameters, i)
        wheel, part = read_wheel(wheels, i), read_part(parts, i)
        progress, result = begin(cycle, part)
        for _ in range(int(progress.pending)):
            wheel, result = dress(cycle, wheel, result, p)
        while not finished(cycle, progress):
            progress, wheel, part, result, stroke = advance(cycle, progress, wheel, part, result, p)
            number = int(progress.reversal) - 1
            if number < log.shape[1]:
                write_stroke(log[i], number, stroke)
            for _ in range(int(progress.pending)):
                wheel, result = dress(cycle, wheel, result, p)
        write_wheel(wheels, i, wheel)
        write_part(parts, i, part)
        write_result(results, i, result)


@entry
def longest_first(cycles: Table, machines: Table, order: Table) -> None:
    """Write `machines` into `order`, longest predicted cycle first (counting sort, stable)."""
    if machines.size <= LANES:
        order[:] = machines
        return
    count = np.zeros(LONGEST_BUCKET + 1, np.int64)
    bucket = np.empty(machines.size, np.int64)
    for k in range(machines.size):
        cycle = read_cycle(cycles, machines[k])
        picks = 2.0 * (cycle.target - cycle.start) / (cycle.primary_pick + cycle.secondary_pick)
        strokes = min(picks + cycle.sparkout, float(LONGEST_BUCKET - 1))
        bucket[k] = LONGEST_BUCKET - 1 - int(strokes)
        count[bucket[k] + 1] += 1
    for k in range(LONGEST_BUCKET):
        count[k + 1] += count[k]
    for k in range(machines.size):
        order[count[bucket[k]]] = machines[k]
        count[bucket[k]] += 1


def grind_cycles(
    cycles: Table,
    parameters: Table,
    wheels: Table,
    parts: Table,
    *,
    threads: int = 1,
    log_strokes: int = 0,
    kernel: Callable[..., None] = run_blocks,
) -> tuple[Table, Table]:
    """Run one cycle on each of N machines.

    Args:
        cycles: shape (N,), dtype `CYCLE`.
        parameters: shape (N,), dtype `PARAMETERS`.
        wheels: shape (N,), dtype `WHEEL`; updated in place.
        parts: shape (N,), dtype `PART`; updated in place.
        threads: threads to use; the result does not depend on it.
        log_strokes: strokes of each machine to log.
        kernel: the compiled loop.

    Returns:
        Results, shape (N,), dtype `RESULT`, and the log, shape (N, log_strokes), dtype `STROKE`.

    Raises:
        ValueError: if the arrays do not have one record a machine.
    """
    n = cycles.shape[0]
    for name, table in (("parameters", parameters), ("wheels", wheels), ("parts", parts)):
        if table.shape != (n,):
            raise ValueError(
                f"{name} has shape {table.shape}, but there are {n} cycles: give one record a machine"
            )
    results = np.zeros(n, RESULT)
    log = np.zeros((n, log_strokes), STROKE)
    order = np.empty(n, np.int64)
    longest_first(as_table(cycles), np.arange(n), order)
    arguments = (
        as_table(cycles),
        as_table(parameters),
        as_table(wheels),
        as_table(parts),
        as_table(results),
        log.view(np.float64).reshape(n, log_strokes, len(Stroke._fields)),
        order,
    )
    if threads == 1:
        kernel(*arguments, 0, 1)
    else:
        # the kernel releases the GIL, and threads take machines in turn: all get long and short cycles alike
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(lambda first: kernel(*arguments, first, threads), range(threads)))
    return results, log


def as_table(records: Table) -> Table:
    """View a contiguous array of records, shape (N,), as float64, shape (N, fields)."""
    return records.view(np.float64).reshape(records.shape[0], -1)
