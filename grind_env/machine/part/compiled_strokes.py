"""Strokes of the table over the strips of a part in sequence, with the dresses between them."""

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.kernel import entry
from grind_env.kernel.row_accessors import column_reader, column_writer
from grind_env.machine.dress.dress_run import DressPlan
from grind_env.machine.loops.cycle import dress_lead, idle_of
from grind_env.machine.loops.strip_stroke import IDLE, Strips, strips_of
from grind_env.machine.loops.stroke_totals import Tally, count_dress, count_stroke, wheel_depth
from grind_env.machine.loops.table_speed import pace_of
from grind_env.machine.part.stroke_record import NUMBERS_FROM, TableStroke, WheelSeen
from grind_env.process.process_interface import Process
from grind_env.process.stroke_types import StrokeParameters, StrokeResult, WheelState


class Dressed(NamedTuple):
    """Result of a dress between strokes."""

    A: float  #: wear-flat area after the dress
    ds: float  #: wheel diameter after the dress, mm
    removed: float  #: wheel volume dressed off, mm3
    lead: float  #: lead of the diamond, mm per wheel revolution
    wd: float  #: wear flat of the diamond before the dress, mm


class GroundLength(NamedTuple):
    """Length of the part that strokes between two reversal points grind."""

    Lw: float  #: ground length, mm; 0 if it is beside the part
    is_full_length: bool  #: whether the strokes pass over the whole length of the part


RESULT_FROM = NUMBERS_FROM + len(TableStroke._fields)
read_table_stroke = column_reader(TableStroke, NUMBERS_FROM)
write_table_stroke = column_writer(TableStroke, NUMBERS_FROM)
write_stroke = column_writer(StrokeResult, RESULT_FROM)
write_wheel_seen = column_writer(WheelSeen, RESULT_FROM + len(StrokeResult._fields))
write_dressed = column_writer(Dressed)


@functools.cache
def passes_of(process: Process) -> Callable[..., tuple[WheelState, Tally, float]]:
    """Return the compiled strokes of a process over a part, `grind_passes`."""
    dress_wheel, idle, grind_strips = process.dress, idle_of(process), strips_of(process)
    read_own, write_own = column_reader(process.own), column_writer(process.own)

    @entry
    def grind_passes(
        wheel: WheelState,
        strips: Array,
        travel: float,
        off: float,
        acceleration: float,
        covered: Strips,
        rows: Array,
        first_way: GroundLength,
        later_way: GroundLength,
        first: NDArray[np.int64],
        last: NDArray[np.int64],
        plunged: NDArray[np.bool_],
        due: NDArray[np.int64],
        dress: DressPlan,
        dressed: Array,
        width: float,
        p: StrokeParameters,
        tally: Tally,
        own: Array,
        memory_time: float,
    ) -> tuple[WheelState, Tally, float]:
        """Make strokes over a part, and the dresses that fall due between them.

        Args:
            wheel: wheel before the strokes.
            strips: as for `grind_strips`; updated.
            travel: distance between the reversal points, mm; this and the next two as for `pace_of`.
            off: distance of the middle of the part from the middle of the travel, mm.
            acceleration: acceleration of the table, mm/s2.
            covered: deepest Z so far of a stroke over the whole length, mm; updated.
            rows: strokes as of `table_of`; their places are read, all else is written.
            first_way: ground length of the first stroke.
            later_way: ground length of the other strokes.
            first: first strip under the wheel in each stroke.
            last: the strip after the last strip under the wheel.
            plunged: whether the wheel went deeper into a strip than before in each stroke; written.
            due: number of strokes before each dress.
            dress: settings of the dresses.
            dressed: results of the dresses, shape (dresses, fields of `Dressed`); written.
            width: width of the part, mm.
            p: parameters.
            tally: tally before the strokes.
            own: as for `grind_strips`; updated.
            memory_time: time of the job for which `own` holds, s.

        Returns:
            Wheel and tally after the strokes, and the time for which `own` then holds, s.
        """
        executed = 0
        for k in range(len(rows) + 1):
            while executed < due.size and due[executed] == k:
                lead, wd = dress_lead(wheel, dress.feed, p), wheel.wd
                wheel, left, removed = dress_wheel(wheel, read_own(own, 0), float(dress.passes), lead, dress.depth, p)
                wheel, left = idle(wheel, left, p, dress.seconds, False)
                write_own(own, 0, left)
                memory_time += dress.seconds
                tally = count_dress(tally, dress.seconds, removed)
                write_dressed(dressed, executed, Dressed(wheel.A, wheel.ds, removed, lead, wd))
                executed += 1
            if k == len(rows):
                break
            made, stroke, b, grown, plunged[k] = read_table_stroke(rows, k), IDLE, 0.0, 0.0, False
            wheel, left = idle(wheel, read_own(own, 0), p, made.time - memory_time, False)
            write_own(own, 0, left)
            memory_time = made.time + made.seconds
            way = first_way if k == 0 else later_way
            Lw = way.Lw if first[k] < last[k] else 0.0
            if Lw > 0.0:
                wheel, stroke, b, plunged[k], grown = grind_strips(
                    wheel,
                    strips,
                    first[k],
                    last[k],
                    made.Z,
                    pace_of(made.E / 60.0, travel, Lw, off, acceleration),
                    width,
                    Lw,
                    p,
                    wheel_depth(made.Z, tally),
                    own,
                    made.seconds,
                )
                if way.is_full_length:
                    for i in range(first[k], last[k]):
                        covered[i] = max(covered[i], made.Z)
            else:
                wheel, left = idle(wheel, left, p, made.seconds, False)
                write_own(own, 0, left)
            tally = count_stroke(tally, stroke, made.seconds, 0.0, plunged[k], False, False, p.stall_time)
            made = TableStroke(time=made.time, seconds=made.seconds, E=made.E, Z=made.Z, b=b, Lw=Lw, grown=grown)
            write_table_stroke(rows, k, made)
            write_stroke(rows, k, stroke)
            write_wheel_seen(rows, k, WheelSeen(A=wheel.A, lam=wheel.lam, V=wheel.V, ds=wheel.ds, W=wheel.W))
        return wheel, tally, memory_time

    return grind_passes
