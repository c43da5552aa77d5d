"""The speed of the table over the part, and a stroke at this speed.

A table that needs more than its overtravel to reach E is slower than E near the ends of the part. A stroke is then
evaluated at two nodes: right Radau quadrature over the time of acceleration above the part. The fast node has the
highest speed and includes the plateau. Each node has its own surface, stored as a mean over the length and a step, fast
less slow. If the table has E over the whole part, the slow node has no share, and the numbers equal those of one node
to the bit.
"""

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.kernel import inlined
from grind_env.kernel.row_accessors import blend, replacer
from grind_env.process.process_interface import Process
from grind_env.process.stroke_types import StrokeResult, WheelState


class Pace(NamedTuple):
    """Speeds of the table over the part."""

    speed: float  #: highest speed over the part, mm/s
    slow: float  #: speed at the slow node, mm/s; equal to `speed` if the table does not accelerate over the part
    slow_share: float  #: share of the ground length that the slow node stands for
    slow_time: float  #: share of the time over the part that the slow node stands for


over_length = replacer(StrokeResult, "ae", "dw", "worn", "Rg", "Ra")
at_most = replacer(StrokeResult, "load", "torque", "T", "burn_ratio")


@inlined
def steady(speed: float) -> Pace:
    """Return the pace of a table that has one speed over the whole part, mm/s."""
    return Pace(speed=speed, slow=speed, slow_share=0.0, slow_time=0.0)


@inlined
def _slow_node(overtravel: float, highest: float, acceleration: float) -> tuple[float, float]:
    """Return the time and the way that the slow node of the ramp at one end of the part stands for, s and mm."""
    entry = min(math.sqrt(2.0 * acceleration * max(overtravel, 0.0)), highest)
    seconds = 0.75 * (highest - entry) / acceleration
    return seconds, seconds * (entry + (highest - entry) / 3.0)


@inlined
def pace_of(speed: float, travel: float, length: float, off: float, acceleration: float) -> Pace:
    """Return the pace of strokes over a part; one slow node stands for the ramps at both ends.

    Args:
        speed: E of the table, mm/s.
        travel: distance between the reversal points, mm.
        length: ground length, mm.
        off: distance of the middle of the part from the middle of the travel, mm.
        acceleration: acceleration of the table, mm/s2.
    """
    mean = 0.5 * (travel - length)
    # with very unequal overtravels the table is fastest beside the part
    highest = min(speed, math.sqrt(acceleration * min(travel, 2.0 * (mean - off + length))))
    seconds, way = _slow_node(mean - off, highest, acceleration)
    other_seconds, other_way = _slow_node(mean + off, highest, acceleration)
    seconds, way = seconds + other_seconds, way + other_way
    if seconds <= 0.0 or length <= 0.0:
        return steady(speed)
    fast_seconds = (length - way) / highest
    return Pace(
        speed=highest, slow=way / seconds, slow_share=way / length, slow_time=seconds / (seconds + fast_seconds)
    )


@inlined
def at_nodes(mean: float, step: float, share: float) -> tuple[float, float]:
    """Return the values at the slow and at the fast node; `share` is the share of the slow node."""
    fast = mean + share * step
    return fast - step, fast


@functools.cache
def paced_of(process: Process) -> Callable[..., Any]:
    """Return the compiled stroke of a process at a pace, `grind`."""
    stroke = process.stroke

    @inlined
    def grind(
        wheel: WheelState, own: Any, part: Any, Z: float, b: float, pace: Any, slow_held: Any, held: Any, seconds: float
    ) -> tuple[WheelState, Any, StrokeResult, StrokeResult, StrokeResult]:
        """Make one stroke; arguments as of `Process.stroke`, with the surface in the cut and two sets of constants.

        Return wheel and own after it, the stroke, and the stroke at the slow and at the fast node.
        """
        share = pace.slow_share
        slow_S, fast_S = at_nodes(part.S, part.S_step, share)
        slow_Rs, fast_Rs = at_nodes(part.Rs, part.Rs_step, share)
        wheel_slow, own_slow, slow = stroke(wheel, own, slow_S, slow_Rs, Z, b, slow_held, seconds)
        wheel_fast, own_fast, fast = stroke(wheel, own, fast_S, fast_Rs, Z, b, held, seconds)
        mean, done = blend(fast, slow, share), blend(fast, slow, pace.slow_time)
        means = mean.ae, mean.dw, mean.worn, mean.Rg, mean.Ra
        peaks = (
            max(fast.load, slow.load),
            max(fast.torque, slow.torque),
            max(fast.T, slow.T),
            max(fast.burn_ratio, slow.burn_ratio),
        )
        done = at_most(over_length(done, means), peaks)
        return blend(wheel_fast, wheel_slow, share), blend(own_fast, own_slow, share), done, slow, fast

    return grind
