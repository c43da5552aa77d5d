"""A cycle block as the compiled loops see it, and its strokes and dresses: control and process model joined."""

import math
from typing import Any, NamedTuple

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.kernel import inlined
from grind_env.machine.tally import FINISHING_DEPTH, Tally, count_dress, count_stroke, wheel_depth
from grind_env.process.equations import wheel_speed
from grind_env.process.state import StrokeConstants, StrokeParameters, StrokeResult, WheelState
from grind_env.process.stroke import dress_wheel, grind_stroke


class Cycle(NamedTuple):
    """A cycle block. Depths are mm into the part, `start` and `target` from wherever the program counts."""

    speed: float
    """Table speed E/60, mm/s."""
    first_seconds: float
    """Time of the first stroke, from the start point to the primary point, s."""
    stroke_seconds: float
    """Time of every other stroke, s."""
    start: float
    """Depth at which the wheel stands when the cycle begins, mm."""
    target: float
    """Depth Y, mm."""
    surface: float
    """Of the touched-off surface above the zero of these two, mm; what they are below it, they are with it added."""
    bottom: float
    """Depth of a stroke at `target` below the touched-off surface, mm."""
    primary_pick: float
    """J, mm."""
    secondary_pick: float
    """Q, mm."""
    at_depth: float
    """Number of strokes, in a G83 traverses, at full depth: that of coverage (PD-13) and L."""
    executions: float
    """D, the number of auto-dresses."""
    pre_dress: float
    """1 for the .1 forms, else 0."""
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
    """Cross coordinate of the wheel's edge where the crossover of a G83 begins, mm; 0 in the other cycles."""
    cross_end: float
    """Where it ends, mm."""
    primary_cross_pick: float
    """K of a G83, mm."""
    secondary_cross_pick: float
    """R of a G83, mm."""


class PartState(NamedTuple):
    """The surface under the wheel."""

    Z: float
    """Depth of the deepest stroke, mm."""
    S: float
    """Stock removed, mm."""
    Rs: float
    """Roughness Ra, um."""


@inlined
def advance(
    cycle: Cycle,
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
        cycle: of the stroke.
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
    finishing = cycle.finish - Z <= FINISHING_DEPTH + DEPTH_TOLERANCE
    plunge, full = reached + DEPTH_TOLERANCE < Z, cycle.full_plunge <= deeper
    tally = count_stroke(tally, stroke, seconds, deeper, plunge, full, finishing, k.stall_time)
    return wheel, PartState(Z=max(part.Z, Z), S=part.S + stroke.ae, Rs=stroke.Ra), tally, stroke


@inlined
def dress_lead(wheel: WheelState, feed: float, p: StrokeParameters) -> float:
    """Dress lead, mm per wheel revolution, of a diamond that traverses with `feed` mm/s."""
    return feed * math.pi * wheel.ds / (1000.0 * wheel_speed(wheel.ds, p.n, p.vs_set))


@inlined
def measured(wheel: WheelState) -> WheelState:
    """The wheel once its wear is known, which is then compensated."""
    return WheelState(
        ds=wheel.ds, A=wheel.A, lam=wheel.lam, V=wheel.V, Rd=wheel.Rd, Cd=wheel.Cd, alw=wheel.alw, W=0.0, wd=wheel.wd
    )


@inlined
def stroke_seconds(cycle: Any, reversal: float) -> float:
    """Time of the stroke after so many reversals of the cycle, s."""
    seconds: float = cycle.stroke_seconds if reversal > 0.0 else cycle.first_seconds
    return seconds


@inlined
def dress(
    cycle: Cycle, wheel: WheelState, tally: Tally, p: StrokeParameters, waited: float
) -> tuple[WheelState, Tally]:
    """One dress execution within a cycle, for which the table has waited so many s."""
    lead = dress_lead(wheel, cycle.dress_feed, p)
    wheel, removed = dress_wheel(wheel, cycle.dress_passes, lead, cycle.dress_depth, p)
    return wheel, count_dress(tally, cycle.dress_seconds + waited, removed)
