"""A cycle block as the compiled loops see it, and its strokes and dresses: control and process model joined."""

import math
from typing import NamedTuple

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.kernel import inlined
from grind_env.kernel.columns import replacer
from grind_env.machine.loops.tally import FINISHING_DEPTH, Tally, count_dress, count_stroke, wheel_depth
from grind_env.process.equations import wheel_speed
from grind_env.process.state import StrokeConstants, StrokeParameters, StrokeResult, WheelState
from grind_env.process.stroke import dress_wheel, grind_stroke


class Stroking(NamedTuple):
    """The strokes of a cycle block, whatever its rules are.

    Depths are mm into the part, `start` from wherever the program counts. In the row of a machine the numbers of the
    rules follow, as `control.cycles` has them.
    """

    speed: float
    """Table speed E/60, mm/s."""
    first_seconds: float
    """Time of the first stroke, from the start point to the primary point, s."""
    stroke_seconds: float
    """Time of every other stroke, s."""
    start: float
    """Depth at which the wheel stands when the cycle begins, mm."""
    surface: float
    """Of the touched-off surface above the zero of `start`, mm; what is below it, is that with it added."""
    bottom: float
    """Depth of a stroke at the full depth of the cycle, below the touched-off surface, mm."""
    full_plunge: float
    """By how much a stroke goes deeper at least that counts as a full plunge when power is averaged, mm."""
    finish: float
    """Depth of the finished surface, mm: `bottom` unless a later block goes deeper."""
    width: float
    """Width of the part, mm; of one narrower than the wheel the engaged width b."""
    length: float
    """Ground length Lw, mm."""
    dress_passes: float
    """Number of diamond passes of one execution."""
    dress_feed: float
    """Traverse feed of the diamond, mm/s."""
    dress_depth: float
    """Depth of each pass, mm."""
    dress_seconds: float
    """Time of one execution with set-up, approach and retrace, s."""
    cross_start: float
    """Cross coordinate of the wheel's edge on the minus side where the cycle begins, mm."""
    cross_end: float
    """Where its crossover ends, mm; the same without one."""


class PartState(NamedTuple):
    """The surface under the wheel."""

    Z: float
    """Depth of the deepest stroke, mm."""
    S: float
    """Stock removed, mm."""
    Rs: float
    """Roughness Ra, um."""


with_wear = replacer(WheelState, "W")


@inlined
def advance(
    stroking: Stroking,
    Z: float,
    seconds: float,
    b: float,
    reached: float,
    wheel: WheelState,
    part: PartState,
    tally: Tally,
    k: StrokeConstants,
) -> tuple[WheelState, PartState, Tally, StrokeResult]:
    """One stroke.

    Args:
        stroking: of the cycle.
        Z: its depth, mm.
        seconds: its time.
        b: engaged width, mm.
        reached: depth to which the surface under the wheel has been ground at least, mm.
        wheel: before it.
        part: the surface in the cut before it.
        tally: before it.
        k: constants of the cycle.
    """
    wheel, stroke = grind_stroke(wheel, part.S, part.Rs, wheel_depth(Z, tally), b, k)
    deeper = Z - part.Z
    finishing = stroking.finish - Z <= FINISHING_DEPTH + DEPTH_TOLERANCE
    plunge, full = reached + DEPTH_TOLERANCE < Z, stroking.full_plunge <= deeper
    tally = count_stroke(tally, stroke, seconds, deeper, plunge, full, finishing, k.stall_time)
    return wheel, PartState(Z=max(part.Z, Z), S=part.S + stroke.ae, Rs=stroke.Ra), tally, stroke


@inlined
def dress_lead(wheel: WheelState, feed: float, p: StrokeParameters) -> float:
    """Dress lead, mm per wheel revolution, of a diamond that traverses with `feed` mm/s."""
    return feed * math.pi * wheel.ds / (1000.0 * wheel_speed(wheel.ds, p.n, p.vs_set))


@inlined
def measured(wheel: WheelState) -> WheelState:
    """The wheel once its wear is known, which is then compensated."""
    return with_wear(wheel, (0.0,))


@inlined
def stroke_seconds(stroking: Stroking, reversal: float) -> float:
    """Time of the stroke after so many reversals of the cycle, s."""
    return stroking.stroke_seconds if reversal > 0.0 else stroking.first_seconds


@inlined
def dress(
    stroking: Stroking, wheel: WheelState, tally: Tally, p: StrokeParameters, waited: float
) -> tuple[WheelState, Tally]:
    """One dress execution within a cycle, for which the table has waited so many s."""
    lead = dress_lead(wheel, stroking.dress_feed, p)
    wheel, removed = dress_wheel(wheel, stroking.dress_passes, lead, stroking.dress_depth, p)
    return wheel, count_dress(tally, stroking.dress_seconds + waited, removed)
