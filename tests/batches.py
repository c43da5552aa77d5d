"""Arrays of records for one cycle on each of many machines: input of the loops in tests and benchmark."""

import math
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from grind_env.array_types import Array
from grind_env.control.cycles.plunge import PlungeCycle
from grind_env.envs.programmed_infeed import Infeed
from grind_env.kernel.row_accessors import dtype_of
from grind_env.machine.loops.compiled_cycles import CYCLE_KERNELS
from grind_env.machine.loops.concurrent_strokes import FEED, FULL, Feeding
from grind_env.machine.loops.cycle import PartState, Stroking
from grind_env.machine.loops.machine_lanes import NO_MOTIONS, longest_first_of
from grind_env.machine.loops.stroke_loops import loops_of, zoned_loops_of
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.loops.table_speed import pace_of
from grind_env.process.process_interface import PROCESS
from grind_env.process.stroke_types import StrokeParameters, WheelState

#: compiled loops of the package's process
FEEDS, PLUNGES, TRAVERSES = loops_of(FEED), loops_of(CYCLE_KERNELS["G82"]), zoned_loops_of(CYCLE_KERNELS["G83"])

CYCLE = dtype_of(Stroking, PlungeCycle)  #: record of a G82 cycle
PARAMETERS, PART, TALLY = map(dtype_of, (StrokeParameters, PartState, Tally))
WHEEL = dtype_of(WheelState, PROCESS.own)  #: record of a wheel with the state of the process


def grind_cycles(cycles: Array, parameters: Array, wheels: Array, parts: Array, *, threads: int = 1) -> Array:
    """Run one G82 on each of N machines in lanes; the result does not depend on the threads.

    Args:
        cycles: shape (N,), dtype `CYCLE`.
        parameters: shape (N,), dtype `PARAMETERS`.
        wheels: shape (N,), dtype `WHEEL`; updated in place.
        parts: shape (N,), dtype `PART`; updated in place.
        threads: number of threads that share the machines.

    Returns:
        Tallies, shape (N,), dtype `TALLY`.
    """
    tallies, order = np.zeros(len(cycles), TALLY), np.empty(len(cycles), np.int64)
    longest_first_of(PlungeCycle)(as_table(cycles), np.arange(len(cycles)), order)
    tables = as_table(cycles), as_table(parameters), as_table(wheels), as_table(parts), as_table(tallies)
    # the kernel releases the GIL, and threads take machines in turn: each thread gets long and short cycles
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda first: PLUNGES.lanes(*tables, NO_MOTIONS, order, first, threads), range(threads)))
    return tallies


def cold(wheel: WheelState) -> tuple[float, ...]:
    """Return a row of `WHEEL` before the first stroke of a part."""
    return (*wheel, *PROCESS.own())


def as_table(records: Array) -> Array:
    """View a contiguous array of records, shape (N,), as float64, shape (N, fields)."""
    return records.view(np.float64).reshape(records.shape[0], -1)


def feeding_row(
    infeed: Infeed, E: float, motion: int, pre_dress: float, numbers: Mapping[str, float]
) -> tuple[float, ...]:
    """Return the row of a G81 block at E (mm/min); its motions begin in row `motion`, `numbers` has part and dress.

    The table turns 30 mm beside the part.
    """
    seconds = infeed.travel + infeed.dwell
    given = {name: value for name, value in numbers.items() if name in Stroking._fields}
    stroking = Stroking(
        **given,
        **pace_of(E / 60.0, given["length"] + 60.0, given["length"], 0.0, infeed.acceleration)._asdict(),
        first_seconds=seconds,
        stroke_seconds=seconds,
        set_out=seconds,
        start=0.0,
        surface=0.0,
        bottom=infeed.target,
        full_plunge=FULL * infeed.rate * seconds,
        finish=infeed.target,
        cross_start=0.0,
        cross_end=0.0,
    )
    travels = infeed.travel, infeed.travel, infeed.dwell, infeed.acceleration
    return *stroking, *Feeding(pre_dress, *travels, 0.0, 0.0, 0.0, float(motion), math.inf)
