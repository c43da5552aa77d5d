"""Cycles of many machines at once.

Machines are dealt to the block kernel longest predicted cycle first, so that its lanes end together.
"""

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

MANY = 1024
"""Machines from which on they are not sorted at all."""

CYCLE = dtype_of(Cycle)
PARAMETERS = dtype_of(StrokeParameters)
WHEEL = dtype_of(WheelState)
PART = dtype_of(PartState)
RESULT = dtype_of(CycleResult)
STROKE = dtype_of(Stroke)


@entry
def run_scalar(cycles: Table, parameters: Table, wheels: Table, parts: Table, results: Table, log: Table) -> None:
    """One machine after the other, with a log: what the block kernel must reproduce bit by bit.

    Args:
        cycles: as for `lanes.run_blocks`, like the next four.
        parameters: of each machine.
        wheels: updated in place.
        parts: updated in place.
        results: written.
        log: shape (N, strokes, fields of `Stroke`), written; strokes beyond its length are not logged.
    """
    for i in range(len(cycles)):
        cycle, p = read_cycle(cycles, i), read_parameters(parameters, i)
        wheel, part = read_wheel(wheels, i), read_part(parts, i)
        progress, ahead, result = begin(cycle, part)
        for _ in range(int(progress.dresses)):
            wheel, result = dress(cycle, wheel, result, p)
        while not finished(cycle, progress):
            progress, ahead, wheel, part, result, stroke = advance(cycle, progress, ahead, wheel, part, result, p)
            number = int(progress.reversal) - 1
            if number < log.shape[1]:
                write_stroke(log[i], number, stroke)
            for _ in range(int(progress.dresses)):
                wheel, result = dress(cycle, wheel, result, p)
        write_wheel(wheels, i, wheel)
        write_part(parts, i, part)
        write_result(results, i, result)


@entry
def longest_first(cycles: Table, machines: Table, order: Table) -> None:
    """Write `machines` into `order`, longest predicted cycle first (counting sort, stable).

    Very few begin together anyway. Of very many the order matters to the last ones only, and rows are read faster in
    their own.
    """
    if machines.size <= LANES or machines.size >= MANY:
        # a loop: for a copy of all numba compiles what it would say of unequal shapes
        for k in range(machines.size):
            order[k] = machines[k]
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


def grind_cycles(cycles: Table, parameters: Table, wheels: Table, parts: Table, *, threads: int = 1) -> Table:
    """Run one cycle on each of N machines.

    Args:
        cycles: shape (N,), dtype `CYCLE`.
        parameters: shape (N,), dtype `PARAMETERS`.
        wheels: shape (N,), dtype `WHEEL`; updated in place.
        parts: shape (N,), dtype `PART`; updated in place.
        threads: threads to use; the result does not depend on it.

    Returns:
        Results, shape (N,), dtype `RESULT`.

    Raises:
        ValueError: if the arrays do not have one record a machine, or a cycle would not end.
    """
    _check(cycles, parameters=parameters, wheels=wheels, parts=parts)
    results, order = np.zeros(len(cycles), RESULT), np.empty(len(cycles), np.int64)
    longest_first(as_table(cycles), np.arange(len(cycles)), order)
    tables = as_table(cycles), as_table(parameters), as_table(wheels), as_table(parts), as_table(results)
    if threads == 1:
        run_blocks(*tables, order, 0, 1)
    else:
        # the kernel releases the GIL, and threads take machines in turn: all get long and short cycles alike
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(lambda first: run_blocks(*tables, order, first, threads), range(threads)))
    return results


def log_cycles(cycles: Table, parameters: Table, wheels: Table, parts: Table, strokes: int) -> tuple[Table, Table]:
    """Run the same cycles, slower, and log the first strokes of each.

    Args:
        cycles: as for `grind_cycles`, like the next three.
        parameters: of each machine.
        wheels: updated in place.
        parts: updated in place.
        strokes: how many to log.

    Returns:
        Results, shape (N,), dtype `RESULT`, and the log, shape (N, strokes), dtype `STROKE`.

    Raises:
        ValueError: as for `grind_cycles`.
    """
    _check(cycles, parameters=parameters, wheels=wheels, parts=parts)
    results, log = np.zeros(len(cycles), RESULT), np.zeros((len(cycles), strokes), STROKE)
    tables = as_table(cycles), as_table(parameters), as_table(wheels), as_table(parts), as_table(results)
    run_scalar(*tables, log.view(np.float64).reshape(*log.shape, len(Stroke._fields)))
    return results, log


def _check(cycles: Table, **tables: Table) -> None:
    for name, table in tables.items():
        if table.shape != cycles.shape:
            raise ValueError(
                f"{name} has shape {table.shape}, but there are {len(cycles)} cycles: give one record a machine"
            )
    idle = np.flatnonzero((cycles["start"] >= cycles["target"]) & (cycles["coverage"] + cycles["sparkout"] <= 0.0))
    if idle.size > 0:
        raise ValueError(f"cycle {idle[0]} makes no stroke: give it a depth, a coverage or a spark-out stroke")
    picks = np.maximum(cycles["primary_pick"], cycles["secondary_pick"])
    endless = np.flatnonzero(~((picks > 0.0) & (cycles["start"] <= cycles["target"])))
    if endless.size > 0:
        raise ValueError(
            f"cycle {endless[0]} would not end: give it a pick above 0 and a target as deep as its start or deeper"
        )


def as_table(records: Table) -> Table:
    """View a contiguous array of records, shape (N,), as float64, shape (N, fields)."""
    return records.view(np.float64).reshape(records.shape[0], -1)
