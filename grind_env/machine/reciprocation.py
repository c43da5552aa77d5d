"""Plain reciprocation with an infeed by the program: G81, `G01 Y.. F..`, a dwell for spark-out, G80.

The table reciprocates on its own while the program feeds the wheel down, so that a stroke is as deep as the infeed has
come when the table passes its middle. G81 has no auto-dress: the operator asks for the dresses. For D of them the
infeed is programmed in D + 1 blocks of equal depth; at the end of each but the last the request is made, and a dwell
gives the table the time to come to its next reversal point, where the control runs the dress (22-11).

`machine.grind` runs the program of such a block to the same strokes (tests/machine/test_reciprocation.py).
"""

import math
from typing import NamedTuple

import numpy as np

from grind_env.control.rules import DEPTH_TOLERANCE, INSTANT
from grind_env.kernel import entry, inlined
from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.cycle import FINISHING_DEPTH, POWER_WINDOW, CycleResult, PartState, dress_lead
from grind_env.machine.rows import (
    Table,
    read_parameters,
    read_part,
    read_wheel,
    write_part,
    write_result,
    write_stroke,
    write_wheel,
)
from grind_env.machine.rules import motion_time, travelled
from grind_env.process.stroke import dress_wheel, grind_stroke

FULL = 0.9
"""Share of what the infeed covers in a stroke from which a plunge counts as a full one when power is averaged."""

WINDOW = int(POWER_WINDOW)


class Feeding(NamedTuple):
    """A G81 block with its infeed. Depths are mm from the touched-off surface, where the wheel stands at first."""

    speed: float
    """Table speed E/60, mm/s."""
    travel: float
    """Time of a stroke without its reversal dwell, s."""
    dwell: float
    """Reversal dwell, s."""
    infeed: float
    """Infeed F/60, mm/s."""
    acceleration: float
    """Of the infeed, mm/s2."""
    target: float
    """Depth Y, mm; a whole number of um, like the ends of the infeed blocks."""
    requests: float
    """Dresses that the operator asks for."""
    pre_dress: float
    """1 for G81.1, else 0."""
    sparkout: float
    """Strokes after the first one at full depth; at least 1."""
    width: float
    """Engaged width b, mm."""
    length: float
    """Ground length Lw, mm."""
    dress_passes: float
    """Diamond passes of one execution."""
    dress_feed: float
    """Traverse feed of the diamond, mm/s."""
    dress_depth: float
    """Depth of each pass, mm."""
    dress_seconds: float
    """Time of one execution with set-up, approach and retrace, s."""


class Segment(NamedTuple):
    """One infeed block and the dwell after it."""

    start: float
    """Depth at which it begins, mm."""
    end: float
    """Depth at which it ends, mm."""
    seconds: float
    """Time of the infeed, s."""
    strokes: float
    """Strokes from its begin to the dress, or to G80."""
    dwell: float
    """Programmed dwell after the infeed, s; whole ms."""


@inlined
def segment(feeding: Feeding, number: float) -> Segment:
    """Infeed block `number`, from 0; the last one is followed by the spark-out.

    The dwell before a dress lasts until just after the table has come to its reversal point; that before G80 until the
    middle of the last spark-out stroke, which G80 lets come to its end.
    """
    blocks = feeding.requests + 1.0
    start = np.floor(1000.0 * feeding.target * number / blocks + 0.5) / 1000.0
    end = np.floor(1000.0 * feeding.target * (number + 1.0) / blocks + 0.5) / 1000.0
    seconds = motion_time(end - start, feeding.infeed, feeding.acceleration)
    stroke = feeding.travel + feeding.dwell
    at_depth = max(math.ceil((seconds - 0.5 * feeding.travel) / stroke), 0.0)
    last = number + 1.0 >= blocks
    strokes = at_depth + 1.0 + feeding.sparkout if last else math.floor((seconds + INSTANT) / stroke) + 1.0
    wait = (strokes - 0.5) * stroke - seconds if last else strokes * stroke - seconds
    dwell = (math.floor(1000.0 * wait) + (0.0 if last else 2.0)) / 1000.0
    return Segment(start=start, end=end, seconds=seconds, strokes=strokes, dwell=dwell)


@inlined
def depth_of(feeding: Feeding, part: Segment, stroke: float) -> float:
    """Depth of the wheel in the middle of a stroke of an infeed block, counted from 0, mm."""
    elapsed = stroke * (feeding.travel + feeding.dwell) + 0.5 * feeding.travel
    return part.start + travelled(elapsed, part.end - part.start, feeding.infeed, feeding.acceleration)


read_feeding, write_segment = column_reader(Feeding), column_writer(Segment)


@entry
def write_segments(feeding: Feeding, table: Table) -> None:
    """Write the infeed blocks of a block into the rows of `table`, shape (D + 1, fields of `Segment`)."""
    for number in range(table.shape[0]):
        write_segment(table, number, segment(feeding, float(number)))


def segments(feeding: Feeding) -> list[Segment]:
    """The infeed blocks of a block, for a program text."""
    table = np.empty((int(feeding.requests) + 1, len(Segment._fields)))
    write_segments(feeding, table)
    return [Segment(*row) for row in table.tolist()]


@entry
def feed_blocks(
    feedings: Table, parameters: Table, wheels: Table, parts: Table, results: Table, log: Table, machines: Table
) -> None:
    """Run one block on each of some machines.

    Args:
        feedings: shape (N, fields of `Feeding`), like all tables one row a machine.
        parameters: shape (N, fields of `StrokeParameters`).
        wheels: shape (N, fields of `WheelState`); updated in place.
        parts: shape (N, fields of `PartState`); updated in place.
        results: shape (N, fields of `CycleResult`); written.
        log: shape (N, strokes, fields of `Stroke`), written; strokes beyond its length are not logged.
        machines: machine numbers.
    """
    ring = np.zeros(WINDOW)  # power of the latest full plunges; 0 for those before a dress
    for i in machines:
        feeding, p = read_feeding(feedings, i), read_parameters(parameters, i)
        wheel, part = read_wheel(wheels, i), read_part(parts, i)
        full_plunge = FULL * feeding.infeed * (feeding.travel + feeding.dwell)
        seconds, strokes, dresses, dressed_off, worn = 0.0, 0, 0.0, 0.0, 0.0
        first_power, first_count, full = 0.0, 0.0, 0
        peak, plunge_rise, finish_rise, burn_ratio = 0.0, 0.0, 0.0, 0.0
        ring[:] = 0.0
        blocks = int(feeding.requests) + 1
        for number in range(blocks):
            if number > 0 or feeding.pre_dress > 0.0:
                lead = dress_lead(wheel, feeding.dress_feed, p)
                wheel, removed = dress_wheel(wheel, feeding.dress_passes, lead, feeding.dress_depth, p)
                seconds += feeding.dress_seconds
                dresses += 1.0
                dressed_off += removed
                ring[:] = 0.0
            block = segment(feeding, float(number))
            for k in range(int(block.strokes)):
                Z = depth_of(feeding, block, float(k))
                wheel, stroke = grind_stroke(wheel, part.S, part.Rs, Z, feeding.speed, feeding.width, feeding.length, p)
                deeper = Z - part.Z
                part = PartState(Z=Z, S=part.S + stroke.ae, Rs=stroke.Ra)
                if strokes < log.shape[1]:
                    write_stroke(log[i], strokes, stroke)
                strokes += 1
                worn += stroke.worn
                peak = max(peak, stroke.power)
                if deeper > 0.0:
                    plunge_rise = max(plunge_rise, stroke.T)
                    burn_ratio = max(burn_ratio, stroke.Br)
                    if feeding.target - Z <= FINISHING_DEPTH + DEPTH_TOLERANCE:
                        finish_rise = max(finish_rise, stroke.T)
                if deeper >= full_plunge:
                    ring[full % WINDOW] = stroke.power
                    full += 1
                    if first_count < POWER_WINDOW:
                        first_power += stroke.power
                        first_count += 1.0
            stroke_seconds = feeding.travel + feeding.dwell
            seconds += block.strokes * stroke_seconds if number + 1 == blocks else block.seconds + block.dwell
        last_count = 0.0
        for k in range(WINDOW):
            last_count += 1.0 if ring[k] > 0.0 else 0.0
        write_wheel(wheels, i, wheel)
        write_part(parts, i, part)
        result = CycleResult(
            seconds=seconds,
            strokes=float(strokes),
            dresses=dresses,
            first_power=first_power,
            first_count=first_count,
            last_power=np.sum(ring),
            last_count=last_count,
            peak_power=peak,
            plunge_rise=plunge_rise,
            finish_rise=finish_rise,
            burn_ratio=burn_ratio,
            worn=worn,
            dressed_off=dressed_off,
        )
        write_result(results, i, result)
