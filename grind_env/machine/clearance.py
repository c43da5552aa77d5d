"""Whether the moves of a program outside its cycles keep clear of the part: only strokes grind it.

They are judged with the cycle that comes after them, for its axis says how the part lies. Those of a program that cuts
grooves alone are not: a job says how long an infeed grinds, and not where on the part.
"""

from grind_env.control import Motion, Position
from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.machine.axes import cross_axis, plunge_axis
from grind_env.machine.coverage import CELL
from grind_env.machine.part import PartRun

CRASH = 0.005
"""mm; a move that goes no deeper rubs: wheel and machine yield by as much, and a finishing pick is no more."""


def into_part(part: PartRun, motion: Motion, axis: int, *, found: bool = True) -> float:
    """How far a move takes the wheel into the part, deeper than strokes have been there, mm; 0 if it keeps clear of it.

    An arc counts as its chord. A move that only lifts the wheel keeps clear, wherever it begins; of one that begins
    where an operator has left the wheel, the end alone is judged, even if it lifts.

    Args:
        part: the part, with what strokes have done to it before the move.
        motion: the move.
        axis: the reciprocating axis.
        found: whether it begins where the control takes the wheel to be, and not where an operator has left it.
    """
    cross, plunge = cross_axis(axis), plunge_axis(axis)
    start, end = motion.start if found else motion.end, motion.end
    lifts = end[plunge] >= start[plunge] and (start[axis], start[cross]) == (end[axis], end[cross])
    if lifts and found:
        return 0.0
    low, high = 0.0, 1.0
    lying, width = part.job.part, part.job.setup.wheel.width
    # a wheel at the very edge does not touch
    sides = (
        (axis, lying.start, lying.start + lying.length),
        (cross, lying.across - width, lying.across + lying.width),
    )
    for along, near, far in sides:
        way = end[along] - start[along]
        if abs(way) < DEPTH_TOLERANCE:
            if not near + DEPTH_TOLERANCE < start[along] < far - DEPTH_TOLERANCE:
                return 0.0
            continue
        first, last = sorted(((near - start[along]) / way, (far - start[along]) / way))
        low, high = max(low, first), min(high, last)
    if (high - low) * _length(start, end) < DEPTH_TOLERANCE and start != end:
        return 0.0
    return _deepest(part, _at(start, end, low), _at(start, end, high), axis)


def _deepest(part: PartRun, start: Position, end: Position, axis: int) -> float:
    """How far a straight move over the part goes deeper than strokes have been, mm; of a harmless one a bound on it."""
    bound = _deeper(part, start, end, axis)  # as if it were as deep as its deeper end all the way
    if bound <= CRASH:
        return bound
    if max(abs(end[along] - start[along]) for along in (axis, cross_axis(axis))) <= CELL:
        return max(_deeper(part, start, start, axis), _deeper(part, end, end, axis))
    half = _at(start, end, 0.5)
    return max(_deepest(part, start, half, axis), _deepest(part, half, end, axis))


def _deeper(part: PartRun, start: Position, end: Position, axis: int) -> float:
    """How much deeper the deeper end of a straight move is than strokes have been in what the move sweeps, mm."""
    cross, plunge = cross_axis(axis), plunge_axis(axis)
    reached = part.reached((start[cross], end[cross]), (start[axis], end[axis]))
    return part.job.part.surface - min(start[plunge], end[plunge]) - reached


def _at(start: Position, end: Position, share: float) -> Position:
    x, y, z = (a + share * (b - a) for a, b in zip(start, end, strict=True))
    return x, y, z


def _length(start: Position, end: Position) -> float:
    return max(abs(b - a) for a, b in zip(start, end, strict=True))
