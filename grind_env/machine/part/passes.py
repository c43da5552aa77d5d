"""Strokes of the table over the strips of a part in sequence, with the dresses between them."""

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array
from grind_env.kernel import entry
from grind_env.kernel.columns import column_reader, column_writer
from grind_env.machine.dress.program import DressPlan
from grind_env.machine.loops.cycle import dress_lead, idle_of
from grind_env.machine.loops.pace import pace_of
from grind_env.machine.loops.strips import IDLE, Strips, strips_of
from grind_env.machine.loops.tally import Tally, count_dress, count_stroke, wheel_depth
from grind_env.machine.part.rows import NUMBERS_FROM, TableStroke, WheelSeen
from grind_env.process.process import Process
from grind_env.process.state import StrokeParameters, StrokeResult, WheelState


class Dressed(NamedTuple):
    """Result of a dress between strokes."""

    A: float
    """Wear-flat area after it."""
    ds: float
    """Wheel diameter after it, mm."""
    removed: float
    """Wheel volume that it took off, mm3."""
    lead: float
    """Lead of the diamond, mm per wheel revolution."""
    wd: float
    """Wear flat of the diamond before it, mm."""


class PassedOver(NamedTuple):
    """Stretch of the table's passes between two reversal points."""

    Lw: float
    """Ground length, mm; 0 if it is beside the part."""
    whole: bool
    """Whether that is the whole length of the part."""


RESULT_FROM = NUMBERS_FROM + len(TableStroke._fields)
read_table_stroke, write_table_stroke = (
    column_reader(TableStroke, NUMBERS_FROM),
    column_writer(TableStroke, NUMBERS_FROM),
)
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
        first_way: PassedOver,
        later_way: PassedOver,
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
        lived: float,
    ) -> tuple[WheelState, Tally, float]:
        """Make strokes over a part, and the dresses that fall due between them.

        Args:
            wheel: before them.
            strips: as for `grind_strips`; updated.
            travel: as of `pace_of`, like the next two; mm.
            off: mm.
            acceleration: mm/s2.
            covered: deepest Z so far of a stroke over the whole length, mm; updated.
            rows: as of `table_of`; where they lie is read, the rest written.
            first_way: of the first one.
            later_way: of the others.
            first: first strip under the wheel in each.
            last: the strip after the last one.
            plunged: whether the wheel went deeper into a strip than before in each; written.
            due: after how many strokes each dress falls due.
            dress: what each of them does.
            dressed: what each has come to, shape (dresses, fields of `Dressed`); written.
            width: of the part, mm.
            p: parameters.
            tally: before them.
            own: as for `grind_strips`; updated.
            lived: time of the job up to which that is as it is, s.

        Returns:
            Wheel and tally after them, and the time up to which `own` then is as it is, s.
        """
        executed = 0
        for k in range(len(rows) + 1):
            while executed < due.size and due[executed] == k:
                lead = dress_lead(wheel, dress.feed, p)
                wd = wheel.wd
                wheel, left, removed = dress_wheel(wheel, read_own(own, 0), float(dress.passes), lead, dress.depth, p)
                wheel, left = idle(wheel, left, p, dress.seconds, False)
                write_own(own, 0, left)
                lived += dress.seconds
                tally = count_dress(tally, dress.seconds, removed)
                write_dressed(dressed, executed, Dressed(wheel.A, wheel.ds, removed, lead, wd))
                executed += 1
            if k == len(rows):
                break
            made, stroke, b, grown, plunged[k] = read_table_stroke(rows, k), IDLE, 0.0, 0.0, False
            wheel, left = idle(wheel, read_own(own, 0), p, made.time - lived, False)
            write_own(own, 0, left)
            lived = made.time + made.seconds
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
                if way.whole:
                    for i in range(first[k], last[k]):
                        covered[i] = max(covered[i], made.Z)
            else:
                wheel, left = idle(wheel, left, p, made.seconds, False)
                write_own(own, 0, left)
            tally = count_stroke(tally, stroke, made.seconds, 0.0, plunged[k], False, False, p.stall_time)
            made = TableStroke(time=made.time, seconds=made.seconds, E=made.E, Z=made.Z, b=b, Lw=Lw, grown=grown)
            write_table_stroke(rows, k, made)
            write_stroke(rows, k, stroke)
            seen = WheelSeen(A=wheel.A, lam=wheel.lam, V=wheel.V, ds=wheel.ds, W=wheel.W)
            write_wheel_seen(rows, k, seen)
        return wheel, tally, lived

    return grind_passes
