"""Motions of G81 with a programmed infeed: G81, `G01 Y.. F..`, a dwell for spark-out, G80.

The table reciprocates on its own while the program feeds the wheel down, so that a stroke is as deep as the infeed has
come when the table passes its middle. G81 has no auto-dress: the operator asks for the dresses. For D of them the
infeed is programmed in D + 1 blocks of equal depth; at the end of each but the last the request is made, and a dwell
gives the table the time to come to its next reversal point, where the control runs the dress (22-11).

`machine.grind` runs the program of such a block to the same strokes (tests/envs/test_reciprocation_strokes.py).
"""

import math
from typing import Any, NamedTuple

import numpy as np

from grind_env.control.rules import INSTANT
from grind_env.kernel import entry, inlined
from grind_env.machine.loops.feeding import DRESSES, ENDS, GOES_ON, FeedMotion, write_motion
from grind_env.machine.loops.rules import motion_time


class Infeed(NamedTuple):
    """The infeed of a G81 block. Depths are mm from the touched-off surface, where the wheel stands at first."""

    travel: float
    """Time of a stroke without its reversal dwell, s."""
    dwell: float
    """Reversal dwell, s."""
    rate: float
    """F/60, mm/s."""
    acceleration: float
    """Acceleration of the infeed, mm/s2."""
    target: float
    """Depth Y, mm; a whole number of um, like the ends of the infeed blocks."""
    requests: float
    """Dresses that the operator asks for."""
    sparkout: float
    """Strokes after the first one at full depth; at least 1."""


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


@entry
def infeed_of(
    stroke: float, sparkout: float, stock: float, E: float, dwell: float, D: float, acceleration: float, rate: float
) -> Infeed:
    """The infeed of the G81 block that grinds `stock` mm with D requests and F `rate` (mm/s).

    The table goes at E (mm/min) over the `stroke`, mm, rests for `dwell` s, and makes `sparkout` strokes in the end;
    `acceleration` is mm/s2.

    An entry and not inlined, because the program text needs it in every step of the single environment, too.
    """
    return Infeed(
        travel=motion_time(stroke, E / 60.0, acceleration),
        dwell=dwell,
        rate=rate,
        acceleration=acceleration,
        target=stock,
        requests=D,
        sparkout=sparkout + 1.0,
    )


@inlined
def segment(infeed: Infeed, number: float) -> Segment:
    """Infeed block `number`, from 0; the last one is followed by the spark-out.

    The dwell before a dress lasts until just after the table has come to its reversal point; that before G80 until the
    middle of the last spark-out stroke, which G80 lets come to its end.
    """
    blocks = infeed.requests + 1.0
    start = np.floor(1000.0 * infeed.target * number / blocks + 0.5) / 1000.0
    end = np.floor(1000.0 * infeed.target * (number + 1.0) / blocks + 0.5) / 1000.0
    seconds = motion_time(end - start, infeed.rate, infeed.acceleration)
    stroke = infeed.travel + infeed.dwell
    at_depth = max(math.ceil((seconds - 0.5 * infeed.travel) / stroke), 0.0)
    last = number + 1.0 >= blocks
    strokes = at_depth + 1.0 + infeed.sparkout if last else math.floor((seconds + INSTANT) / stroke) + 1.0
    wait = (strokes - 0.5) * stroke - seconds if last else strokes * stroke - seconds
    dwell = (math.floor(1000.0 * wait) + (0.0 if last else 2.0)) / 1000.0
    return Segment(start=start, end=end, seconds=seconds, strokes=strokes, dwell=dwell)


@inlined
def write_motions(motions: Any, row: int, infeed: Infeed) -> None:
    """Write the motions of a block into the rows of a table from `row` on: an infeed and a dwell for each segment.

    A request that the operator makes at the end of an infeed is met at the next reversal point: no stroke begins
    after it.
    """
    for number in range(int(infeed.requests) + 1):
        block = segment(infeed, float(number))
        total = block.seconds + block.dwell
        last = number == int(infeed.requests)
        last_begin = total - INSTANT if last else block.seconds + 2.0 * INSTANT
        down = FeedMotion(
            begin=0.0,
            end=block.seconds,
            depth=block.start,
            way=block.end - block.start,
            cross=0.0,
            cross_way=0.0,
            path=block.end - block.start,
            rate=infeed.rate,
            last_begin=last_begin,
            leg_seconds=total,
            after=GOES_ON,
        )
        rest = FeedMotion(
            begin=block.seconds,
            end=total,
            depth=block.end,
            way=0.0,
            cross=0.0,
            cross_way=0.0,
            path=0.0,
            rate=infeed.rate,
            last_begin=last_begin,
            leg_seconds=total,
            after=ENDS if last else DRESSES,
        )
        write_motion(motions, row + 2 * number, down)
        write_motion(motions, row + 2 * number + 1, rest)


def segments(infeed: Infeed) -> list[Segment]:
    """Return the infeed blocks of a block, for a program text."""
    return [segment(infeed, float(number)) for number in range(int(infeed.requests) + 1)]
