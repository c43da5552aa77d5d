"""Cycles of many machines at once.

Machines are dealt to the block kernel longest predicted cycle first, so that its lanes end together.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from grind_env.kernel import entry
from grind_env.kernel.rows import dtype_of
from grind_env.machine.cycle import Cycle, CycleResult, PartState, advance, begin, dress, finished
from grind_env.machine.lanes import LANES, run_blocks
from grind_env.machine.rows import (
    Table,
    read_cycle,
    read_parameters,
    read_part,
    read_wheel,
    write_part,
    write_result,
    write_stroke,
    write_wheel,
)
from grind_env.process.state import Stroke, StrokeParameters, WheelState

LONGEST_BUCKET = 1024
"""Cycles of at least this many predicted strokes are not sorted among themselves."""

CYCLE = dtype_of(Cycle)
PARAMETERS = dtype_of(StrokeParameters)
WHEEL = dtype_of(WheelState)
PART = dtype_of(PartState)
RESULT = dtype_of(CycleResult)
STROKE = dtype_of(Stroke)


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
        ValueError: if the arrays do not have one record a machine, or a cycle would not end.
    """
    n = cycles.shape[0]
    for name, table in (("parameters", parameters), ("wheels", wheels), ("parts", parts)):
        if table.shape != (n,):
            raise ValueError(f"{name} has shape {table.shape}, but there are {n} cycles: give one record a machine")
    picks = np.maximum(cycles["primary_pick"], cycles["secondary_pick"])
    endless = np.flatnonzero(~((picks > 0.0) & (cycles["start"] <= cycles["target"])))
    if endless.size > 0:
        raise ValueError(
            f"cycle {endless[0]} would not end: give it a pick above 0 and a target as deep as its start or deeper"
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
