"""Cycles of many machines at once: memory for their rows, and the assignment of machines to lanes.

The longest predicted cycles come first, so that the lanes end together; very many machines are not sorted.
"""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from grind_env.array_types import Array
from grind_env.kernel import entry
from grind_env.kernel.row_accessors import column_reader
from grind_env.machine.loops.compiled_cycles import CYCLE_KERNELS
from grind_env.machine.loops.concurrent_strokes import FEED
from grind_env.machine.loops.cycle import Stroking
from grind_env.machine.loops.row_io import RULES_FROM
from grind_env.machine.loops.stroke_loops import LANES

LONGEST_BUCKET = 1024  #: cycles of at least this many predicted strokes are not sorted among themselves

MANY = 1024  #: number of machines from which on they are not sorted at all

#: number of columns of a table with a row for any kind of cycle
CYCLE_FIELDS = len(Stroking._fields) + max(len(course.cycle._fields) for course in (FEED, *CYCLE_KERNELS.values()))

NO_MOTIONS = np.empty((0, 0))  #: empty table of motions, for cycles whose strokes follow their picks


@entry
def as_they_come(cycles: Array, machines: Array, order: Array) -> None:
    """Copy `machines` into `order`."""
    # a loop, because numba would also compile the error message of an array copy
    for k in range(machines.size):
        order[k] = machines[k]


@functools.cache
def longest_first_of(rules: Any) -> Callable[[Array, Array, Array], None]:
    """Return the compiled `longest_first(cycles, machines, order)` for cycles whose rules have these numbers.

    It writes `machines` into `order`, longest predicted cycle first (stable counting sort). Few machines begin together
    and are not sorted. Very many are not sorted either: the order matters only to the last ones, and rows are read
    faster one after the other. Cycles with unpredictable strokes keep their order.
    """
    if not {"depth", "primary_pick", "secondary_pick", "at_depth"} <= {*rules._fields}:
        return as_they_come
    read_cycle = column_reader(rules, RULES_FROM)

    @entry
    def longest_first(cycles: Array, machines: Array, order: Array) -> None:
        if machines.size <= LANES or machines.size >= MANY:
            as_they_come(cycles, machines, order)
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
