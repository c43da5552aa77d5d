"""Whether the moves of a program outside its cycles keep clear of the part: only strokes grind it."""

from grind_env.control import Motion, Position
from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.machine.axes import cross_axis, plunge_axis
from grind_env.machine.part import PartRun

CRASH = 0.005
"""mm; a move that goes no deeper rubs: wheel and machine yield by as much, and a finishing pick is no more."""


def into_part(part: PartRun, motion: Motion, axis: int, *, found: bool = True) -> float:
    """How far a move takes the wheel into the part, deeper than strokes have been there, mm; 0 if it keeps clear of it.

    An arc counts as its chord. A move that only lifts the wheel keeps clear, wherever it begins.

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
    return max(
        lying.surface - _at(start, end, share)[plunge] - part.reached(_at(start, end, 0.5 * (low + high))[cross])
        for share in (low, high)
    )


def _at(start: Position, end: Position, share: float) -> Position:
    x, y, z = (a + share * (b - a) for a, b in zip(start, end, strict=True))
    return x, y, z


def _length(start: Position, end: Position) -> float:
    return max(abs(b - a) for a, b in zip(start, end, strict=True))
