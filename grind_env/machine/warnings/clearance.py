"""Checks that moves outside the cycles keep clear of part, table and diamond: only strokes grind the part.

A feed move along the table is a stroke, too (`part/feed_moves.py`). Any other feed move over the part would grind where
it is deeper than the surface left by strokes. This is not simulated, and `pass_depths` finds it.

The wheel is a cylinder with its radius and width. Obstacles are the part below the depth that strokes have ground, the
table below the height of the part, and the diamond below its tip. A job may give the places of table and diamond.

Moves of the program are judged with the next cycle, because its axis says how the part lies. A program that cuts only
grooves is not judged, because a job says how long an infeed grinds, but not where on the part.
"""

import itertools
import math
from collections.abc import Callable

from grind_env.control import Arc, Motion, Position
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.control.path_geometry import Circular, Straight
from grind_env.machine.axis_roles import cross_axis, plunge_axis
from grind_env.machine.dress.wheel_geometry import half_chord, rise, shares_within
from grind_env.machine.part.coverage import CELL
from grind_env.machine.part.part import PartRun

#: depth of a harmless move into the part, mm: wheel and machine yield by as much, and a finishing pick is no more. Also
#: the distance of an arc from the chords that stand for it
CRASH = 0.005

Depths = tuple[float, float]  #: least and greatest depth, mm

#: function of edges and ends that returns a depth, mm, such as `PartRun.reached`
Reached = Callable[[tuple[float, float], tuple[float, float]], float]


def into_part(part: PartRun, motion: Motion, axis: int, radius: float, *, found: bool = True) -> float:
    """Return how far a move takes the wheel into the part, deeper than strokes were, mm; 0 if it keeps clear.

    An arc counts as its chord. A move that only lifts the wheel keeps clear. Only the end of a move is judged if the
    program has not `found` its start, because an operator left the wheel there.
    """
    if found and lifts(motion, axis):
        return 0.0
    over = _over(part, motion.start if found else motion.end, motion.end, axis, radius)
    return _deepest(part.reached, part, *over, axis, radius, CRASH) if over is not None else 0.0


def pass_depths(part: PartRun, motion: Motion, axis: int, radius: float, *, found: bool = True) -> Depths | None:
    """Return the least and the greatest depth at which a feed move grinds the part, mm; None if it grinds nothing.

    A move grinds where it is deeper than the surface that strokes have left. Arguments as of `into_part`.
    """
    surface, plunge = part.job.part.surface, plunge_axis(axis)
    depths: list[float] = []
    if found and lifts(motion, axis) and not isinstance(motion, Arc):
        return None
    for start, end in _chords(motion) if found else [(motion.end, motion.end)]:
        over = _over(part, start, end, axis, radius)
        if over is None or _deepest(part.left_at, part, *over, axis, radius, DEPTH_TOLERANCE) <= DEPTH_TOLERANCE:
            continue
        depths += [surface - here[plunge] for here in over]
    return (max(min(depths), 0.0), max(depths)) if depths else None


def _chords(motion: Motion) -> list[tuple[Position, Position]]:
    """Return a move as straight pieces within `CRASH` of its path."""
    if not isinstance(motion, Arc):
        return [(motion.start, motion.end)]
    path = Circular(motion.start, motion.end, motion.centre, motion.rotation, motion.plane)
    step = 2.0 * math.acos(max(1.0 - CRASH / path.radius, 0.0))
    count = math.ceil(path.angle / step)
    points = [path.point(k / count) for k in range(count + 1)]
    return list(itertools.pairwise(points))


def _over(part: PartRun, start: Position, end: Position, axis: int, radius: float) -> tuple[Position, Position] | None:
    """Return the ends of a straight move's path over the part, below its surface; None for no path."""
    cross, plunge = cross_axis(axis), plunge_axis(axis)
    lying, width = part.job.part, part.job.setup.wheel.width
    lowest = min(start[plunge], end[plunge])
    if lowest >= lying.surface:
        return None
    reach = half_chord(radius, lying.surface - lowest)
    begins, ends = zip(
        shares_within(start, end, axis, lying.start - reach, lying.start + lying.length + reach),
        shares_within(start, end, cross, lying.across - width, lying.across + lying.width),
        strict=True,
    )
    low, high = max(begins), min(ends)
    longest = max(abs(b - a) for a, b in zip(start, end, strict=True))
    if high < low or ((high - low) * longest < DEPTH_TOLERANCE and start != end):
        return None
    path = Straight(start, end)
    return path.point(low), path.point(high)


def into_table(part: PartRun, motion: Motion, axis: int) -> float:
    """Return how far a move takes the wheel into the table, mm; 0 if it keeps clear, or the table is unknown."""
    lying, plunge = part.job.part, plunge_axis(axis)
    if lying.height is None or lifts(motion, axis):
        return 0.0
    return max(lying.surface - lying.height - min(motion.start[plunge], motion.end[plunge]), 0.0)


def lifts(motion: Motion, axis: int) -> bool:
    """Return whether a move only takes the wheel off the part."""
    cross, plunge, start, end = cross_axis(axis), plunge_axis(axis), motion.start, motion.end
    return end[plunge] >= start[plunge] and (start[axis], start[cross]) == (end[axis], end[cross])


def _deepest(
    reached: Reached, part: PartRun, start: Position, end: Position, axis: int, radius: float, most: float
) -> float:
    """Return how far a straight move over the part goes below `reached`, mm; up to `most`, an upper bound."""
    bound = _deeper(reached, part, start, end, axis, radius)  # as if it were as deep as its deeper end all the way
    if bound <= most:
        return bound
    if max(abs(end[along] - start[along]) for along in (axis, cross_axis(axis))) <= CELL:
        return max(_deeper(reached, part, here, here, axis, radius) for here in (start, end))
    half = Straight(start, end).point(0.5)
    found = _deeper(reached, part, half, half, axis, radius)
    # the deeper half first: most often the other one cannot come up to it
    for piece in sorted(((start, half), (half, end)), key=lambda ends: min(each[plunge_axis(axis)] for each in ends)):
        if found < bound:
            found = max(found, _deepest(reached, part, *piece, axis, radius, max(found, most)))
    return found


def _deeper(reached: Reached, part: PartRun, start: Position, end: Position, axis: int, radius: float) -> float:
    """Return how far the deeper end of a straight move goes below `reached` in its sweep, mm."""
    cross, plunge, lying = cross_axis(axis), plunge_axis(axis), part.job.part
    low, high = sorted((start[axis], end[axis]))
    near, far = lying.start, lying.start + lying.length
    ends = min(max(low, near), far), min(max(high, near), far)
    beside = max(near - high, low - far, 0.0)
    depth = lying.surface - min(start[plunge], end[plunge]) - rise(radius, beside)
    return depth - reached((start[cross], end[cross]), ends)
