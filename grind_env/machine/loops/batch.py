"""Cycles of many machines at once.

Machines are dealt to the lanes longest predicted cycle first, so that these end together; very many as they come.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from grind_env.control.cycles.plunge import PlungeCycle
from grind_env.control.cycles.traverse import TraverseCycle
from grind_env.kernel import entry
from grind_env.kernel.columns import column_reader, dtype_of
from grind_env.machine.loops.courses import COURSES
from grind_env.machine.loops.cycle import PartState, Stroking
from grind_env.machine.loops.feeding import FEED
from grind_env.machine.loops.loops import LANES, loops_of, zoned_loops_of
from grind_env.machine.loops.rows import RULES_FROM, Table
from grind_env.machine.loops.tally import Tally
from grind_env.process.state import StrokeParameters, WheelState

FEEDS, PLUNGES, TRAVERSES = loops_of(FEED), loops_of(COURSES["G82"]), zoned_loops_of(COURSES["G83"])
"""Of the process of the package."""

LONGEST_BUCKET = 1024
"""Cycles of at least this many predicted strokes are not sorted among themselves."""

MANY = 1024
"""Machines from which on they are not sorted at all."""

CYCLE = dtype_of(Stroking, PlungeCycle)
"""Of a G82; other cycles have the numbers of their own rules after those of `Stroking`."""
CYCLE_FIELDS = len(Stroking._fields) + max(len(course.cycle._fields) for course in (FEED, *COURSES.values()))
"""Of the longest row of a cycle."""
PARAMETERS = dtype_of(StrokeParameters)
WHEEL = dtype_of(WheelState)
PART = dtype_of(PartState)
TALLY = dtype_of(Tally)

NO_MOTIONS = np.empty((0, 0))
"""Of cycles whose strokes lie where their picks have led."""


def longest_first_of(rules: type[Any]) -> Callable[[Table, Table, Table], None]:
    """Compiled `longest_first(cycles, machines, order)` for cycles whose rules have these numbers.

    It writes `machines` into `order`, longest predicted cycle first (counting sort, stable). Very few begin together
    anyway. Of very many the order matters to the last ones only, and rows are read faster in their own.
    """
    read_cycle = column_reader(rules, RULES_FROM)

    @entry
    def longest_first(cycles: Table, machines: Table, order: Table) -> None:
        if machines.size <= LANES or machines.size >= MANY:
            # a loop: for a copy of all numba compiles what it would say of unequal shapes
            for k in range(machines.size):
                order[k] = machines[k]
            return
        count = np.zeros(LONGEST_BUCKET + 1, np.int64)
        bucket = np.empty(machines.size, np.int64)
        for k in range(machines.size):
            cycle = read_cycle(cycles, machines[k])
            picks = 2.0 * cycle.depth / (cycle.primary_pick + cycle.secondary_pick)
            strokes = min(picks + cycle.at_depth - 1.0, float(LONGEST_BUCKET - 1))
            bucket[k] = LONGEST_BUCKET - 1 - int(strokes)
            count[bucket[k] + 1] += 1
        for k in range(LONGEST_BUCKET):
            count[k + 1] += count[k]
        for k in range(machines.size):
            order[count[bucket[k]]] = machines[k]
            count[bucket[k]] += 1

    return longest_first


longest_plunges, longest_traverses = longest_first_of(PlungeCycle), longest_first_of(TraverseCycle)


def grind_cycles(cycles: Table, parameters: Table, wheels: Table, parts: Table, *, threads: int = 1) -> Table:
    """Run one cycle on each of N machines.

    Args:
        cycles: shape (N,), dtype `CYCLE`.
        parameters: shape (N,), dtype `PARAMETERS`.
        wheels: shape (N,), dtype `WHEEL`; updated in place.
        parts: shape (N,), dtype `PART`; updated in place.
        threads: threads to use; the result does not depend on it.

    Returns:
        Tallies, shape (N,), dtype `TALLY`.

    Raises:
        ValueError: if the arrays do not have one record a machine, or a cycle would not end.
    """
    _check(cycles, parameters=parameters, wheels=wheels, parts=parts)
    tallies, order = np.zeros(len(cycles), TALLY), np.empty(len(cycles), np.int64)
    longest_plunges(as_table(cycles), np.arange(len(cycles)), order)
    tables = as_table(cycles), as_table(parameters), as_table(wheels), as_table(parts), as_table(tallies)
    if threads == 1:
        PLUNGES.lanes(*tables, NO_MOTIONS, order, 0, 1)
    else:
        # the kernel releases the GIL, and threads take machines in turn: all get long and short cycles alike
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(lambda first: PLUNGES.lanes(*tables, NO_MOTIONS, order, first, threads), range(threads)))
    return tallies


def _check(cycles: Table, **tables: Table) -> None:
    for name, table in tables.items():
        if table.shape != cycles.shape:
            raise ValueError(
                f"{name} has shape {table.shape}, but there are {len(cycles)} cycles: give one record a machine"
            )
    idle = np.flatnonzero((cycles["depth"] <= 0.0) & (cycles["at_depth"] <= 0.0))
    if idle.size > 0:
        raise ValueError(f"cycle {idle[0]} makes no stroke: give it a depth, a coverage or a spark-out stroke")
    picks = np.maximum(cycles["primary_pick"], cycles["secondary_pick"])
    endless = np.flatnonzero(~((picks > 0.0) & (cycles["depth"] >= 0.0)))
    if endless.size > 0:
        raise ValueError(f"cycle {endless[0]} would not end: give it a pick above 0 and a depth of 0 or more")


def as_table(records: Table) -> Table:
    """View a contiguous array of records, shape (N,), as float64, shape (N, fields)."""
    return records.view(np.float64).reshape(records.shape[0], -1)
