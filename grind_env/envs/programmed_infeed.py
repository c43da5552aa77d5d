"""Motions of G81 with a programmed infeed: G81, `G01 Y.. F..`, a dwell for spark-out, G80.

The table reciprocates on its own while the program feeds the wheel down. The depth of a stroke is the depth of the
infeed when the table passes its middle. G81 has no auto-dress: the operator asks for the dresses. For D dresses the
infeed is programmed in D + 1 blocks of equal depth. At the end of each block but the last the operator asks for a
dress, and a dwell gives the table time to reach its next reversal point, where the control runs the dress (22-11).

`machine.grind` runs the program of such a block to the same strokes (tests/envs/test_reciprocation_strokes.py).
"""

import math
from typing import Any, NamedTuple

import numpy as np

from grind_env.control.cycle_formulas import INSTANT
from grind_env.kernel import entry, inlined
from grind_env.machine.loops.compiled_motion import motion_time
from grind_env.machine.loops.concurrent_strokes import DRESSES, ENDS, GOES_ON, FeedMotion, write_motion


class Infeed(NamedTuple):
    """The infeed of a G81 block. Depths are mm from the touched-off surface, where the wheel stands at first."""

    travel: float  #: time of a stroke without its reversal dwell, s
    dwell: float  #: reversal dwell, s
    rate: float  #: feed of the infeed, F/60, mm/s
    acceleration: float  #: acceleration of the infeed, mm/s2
    target: float  #: depth Y, mm; a whole number of um, like the ends of the infeed blocks
    requests: float  #: number of dresses that the operator asks for
    sparkout: float  #: number of strokes after the first one at full depth; at least 1


class Segment(NamedTuple):
    """One infeed block and the dwell after it."""

    start: float  #: depth at the start of the infeed, mm
    end: float  #: depth at the end of the infeed, mm
    seconds: float  #: time of the infeed, s
    strokes: float  #: number of strokes from the start of the infeed to the dress, or to G80
    dwell: float  #: programmed dwell after the infeed, s; whole ms


@entry
def infeed_of(
    stroke: float, sparkout: float, stock: float, E: float, dwell: float, D: float, acceleration: float, rate: float
) -> Infeed:
    """Return the infeed of the G81 block that grinds `stock` mm with D requests and F `rate` (mm/s).

    The table moves at E (mm/min) over the `stroke`, mm, rests for `dwell` s, and makes `sparkout` strokes at the end;
    `acceleration` is mm/s2.

    The function is an entry, not inlined, because each step of the single environment calls it for the program text.
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
    """Return infeed block `number`, from 0; the spark-out follows the last block.

    The dwell before a dress ends just after the table has reached its reversal point. The dwell before G80 ends in the
    middle of the last spark-out stroke, which G80 lets finish.
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

    The control serves a request at the end of an infeed at the next reversal point: no stroke begins after the request.
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
    """Return the infeed blocks of a G81 block, for its program text."""
    return [segment(infeed, float(number)) for number in range(int(infeed.requests) + 1)]
