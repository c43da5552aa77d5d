"""The entry and exit moves of the radius compensation, types A and B (`radius-compensation.md` 2.1, 2.4, 2.5)."""

import math

from grind_env.control.compensation.corners import TANGENTIAL, Junction, around, centre_radius, outward
from grind_env.control.compensation.geometry import (
    Element,
    Offset,
    PathArc,
    PathSegment,
    Point,
    between,
    cross,
    dot,
    moved,
    polyline,
    rotated,
    turn,
    unit,
)
from grind_env.control.compensation.intersections import Circle, StraightLine, crossings


def entry(
    move: PathSegment, following: Element | None, offset: Offset, kind: str, circular: bool
) -> tuple[Element, ...]:
    """Return the way from an uncompensated point to the start of the first compensated element.

    Without a `following` motion the way ends beside the end of `move`, at right angles to it (1.8). Type "A" is
    straight, "B" keeps one radius from the start of `following` (15-27), with an arc under G39.1.
    """
    end = offset.beside_end(move) if following is None else offset.beside_start(following)
    if kind == "A" or following is None or offset.radius == 0.0:
        return (PathSegment(move.start, end),)
    out = outward(move, following, offset)
    if out < TANGENTIAL:
        return (PathSegment(move.start, end),)
    perpendicular, ahead, back, _ = around(move.end, move.direction_at_end, following.direction_at_start, offset, out)
    if out < 0.5 * math.pi + TANGENTIAL:
        return polyline(move.start, ahead, end)
    if circular:
        return *polyline(move.start, perpendicular), PathArc(perpendicular, end, move.end, -offset.side)
    return polyline(move.start, perpendicular, ahead, back, end)


def exit_junction(
    last: Element, move: PathSegment, offset: Offset, kind: str, circular: bool, vector: Point | None
) -> Junction:
    """Return the way from the last compensated element up to the straight exit to `move.end`, which is not offset.

    Type "B" keeps one radius from the end of `last` outside (mill 21-25). In both types, I, J, K words of the exit
    block (`vector` along the axes of the plane) take precedence.
    """
    end = offset.beside_end(last)
    if offset.radius == 0.0:
        return Junction(end, ())
    if vector is not None:
        return Junction(_shifted(last, offset, unit(vector)), ())
    out = outward(last, move, offset)
    if kind == "A" or out < TANGENTIAL:
        return Junction(end, ())
    _, ahead, back, beside_exit = around(move.start, last.direction_at_end, move.direction_at_start, offset, out)
    sharp = out > 0.5 * math.pi + TANGENTIAL
    if sharp and circular:
        return Junction(end, (PathArc(end, beside_exit, move.start, -offset.side),))
    generated = (ahead, back, beside_exit) if sharp else (ahead,)
    if isinstance(last, PathSegment):
        return Junction(ahead, polyline(*generated))
    return Junction(end, polyline(end, *generated))


def _shifted(last: Element, offset: Offset, vector: Point) -> Point:
    """Return the end of the last compensated element after an exit block with I, J, K words (15-26, mill 21-18).

    The end is where the offset of a line along the vector meets the element, at most one radius away. An arc is
    followed along its circle by at most a quarter turn; without an intersection nothing changes.
    """
    end, direction, radius = offset.beside_end(last), last.direction_at_end, offset.radius
    parallel = abs(cross(direction, vector)) < TANGENTIAL
    against = -math.copysign(radius, dot(vector, direction))
    line = StraightLine(offset.beside(last.end, vector), vector)
    if isinstance(last, PathSegment):
        if parallel:
            return moved(end, direction, against)
        (meeting,) = crossings(StraightLine(end, direction), line)
        return moved(end, direction, max(-radius, min(radius, dot(between(end, meeting), direction))))
    centre, curve = last.centre, centre_radius(last, offset)
    if parallel:
        way = against
    else:
        meetings = crossings(Circle(centre, math.dist(centre, end)), line)
        nearest = min(meetings, key=lambda point: math.dist(point, end), default=end)
        way = curve * last.rotation * turn(between(centre, end), between(centre, nearest))
    most = min(radius, 0.5 * math.pi * curve)
    return rotated(end, centre, last.rotation * max(-most, min(most, way)) / curve)
