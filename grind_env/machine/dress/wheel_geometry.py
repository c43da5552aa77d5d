"""The wheel as a cylinder with a radius and a width."""

import math

from grind_env.control import Motion, Position
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.control.path_geometry import Straight
from grind_env.machine.axis_roles import cross_axis, plunge_axis


def over_diamond(tip: Position, motion: Motion, axis: int, radius: float, width: float) -> tuple[float, float]:
    """Return how far a straight move takes the wheel below the diamond tip, and the width that passes over it, mm.

    The depth is negative if the wheel stays above the tip, and minus infinity if the wheel does not pass over the tip.
    An arc counts as its chord.
    """
    cross, plunge = cross_axis(axis), plunge_axis(axis)
    start, end = motion.start, motion.end
    low, high = shares_within(start, end, cross, tip[cross] - width, tip[cross])
    if high <= low:
        return -math.inf, 0.0
    path = Straight(start, end)
    nearest = [path.point(low), path.point(high)]
    along = end[axis] - start[axis]
    if abs(along) >= DEPTH_TOLERANCE and low < (share := (tip[axis] - start[axis]) / along) < high:
        nearest.append(path.point(share))
    depth = max(tip[plunge] - here[plunge] - rise(radius, abs(here[axis] - tip[axis])) for here in nearest)
    return depth, (high - low) * abs(end[cross] - start[cross])


def shares_within(start: Position, end: Position, axis: int, near: float, far: float) -> tuple[float, float]:
    """Return the shares of a straight way between which a coordinate is from `near` to `far`; (1, 0) for none."""
    way = end[axis] - start[axis]
    if abs(way) < DEPTH_TOLERANCE:
        # at the very edge counts as outside
        return (0.0, 1.0) if near + DEPTH_TOLERANCE < start[axis] < far - DEPTH_TOLERANCE else (1.0, 0.0)
    first, last = sorted(((near - start[axis]) / way, (far - start[axis]) / way))
    return max(0.0, first), min(1.0, last)


def half_chord(radius: float, depth: float) -> float:
    """Return the distance from the wheel's middle at which its surface is `depth` higher, mm."""
    deep = min(depth, radius)
    return math.sqrt(deep * (2.0 * radius - deep))


def rise(radius: float, distance: float) -> float:
    """Return how much higher the wheel surface is at a distance from its middle, mm; infinite beyond its radius."""
    return radius - math.sqrt(radius * radius - distance * distance) if distance < radius else math.inf
