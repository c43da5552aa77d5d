"""Corners between the offset paths of two successive motions (`radius-compensation.md` 2).

`out` is the angle, rad, by which the path turns away from the compensated side: above 0 the centre runs round the
outside of the corner, below 0 it is inside (1.2). Arcs count by their tangents.
"""

import math
from dataclasses import dataclass

from grind_env.control.compensation.geometry import (
    NEGLIGIBLE_ANGLE,
    NEGLIGIBLE_LENGTH,
    Element,
    Offset,
    PathArc,
    PathSegment,
    Point,
    between,
    dot,
    moved,
    polyline,
    rotated,
    turn,
)
from grind_env.control.compensation.intersections import Circle, Curve, StraightLine, crossings

#: rad; a smaller turn counts as none: the perpendicular point then errs by less than 1e-6 of the radius
TANGENTIAL = 1e-6


class CompensationFault(ValueError):
    """A path that cannot be compensated (1.11); the place of the element goes between subject and predicate."""

    def __init__(self, name: str, subject: str, predicate: str, element: Element) -> None:
        self.name, self.subject, self.predicate, self.element = name, subject, predicate, element
        super().__init__(f"{subject} {predicate}")


@dataclass(frozen=True, slots=True)
class Junction:
    """The end of a compensated element, and the elements generated up to the start of the next one."""

    end: Point
    generated: tuple[Element, ...]


def corner(first: Element, second: Element, offset: Offset, circular: bool, minimum: float) -> Junction:
    """Return the junction of two successive elements that are compensated on the same side (2.2, 2.3).

    `circular` is G39.1, an arc round a sharp outside corner, instead of the straight blocks of G39; a straight block
    with both components below `minimum` is dropped (mill 21-42).
    """
    if offset.radius == 0.0:
        return Junction(first.end, ())
    out = outward(first, second, offset)
    if abs(out) < TANGENTIAL:
        return Junction(offset.beside_end(first), ())
    if out < 0.5 * math.pi + TANGENTIAL:
        if isinstance(first, PathSegment) and isinstance(second, PathSegment):
            return Junction(_mitre(first, out, offset), ())
        meeting = _meeting(first, second, offset, out)
        if meeting is not None:
            return Junction(meeting, ())
        if out < 0.0:
            raise CompensationFault(
                "interference",
                f"the paths offset by {offset.radius:.4f} mm",
                "do not meet inside this corner; use a smaller radius or a larger arc",
                second,
            )
    if circular:
        start = offset.beside_end(first)
        return Junction(start, (PathArc(start, offset.beside_start(second), first.end, -offset.side),))
    return _linear(first, second, offset, out, minimum)


def side_change(first: Element, second: Element, before: Offset, after: Offset) -> Junction:
    """Return the junction where the side changes (1.9): the crossing of the actual offset paths if an arc takes part.

    Two lines, and paths that do not cross, are joined by a straight block between the perpendicular points.
    """
    end, start = before.beside_end(first), after.beside_start(second)
    if isinstance(first, PathArc) or isinstance(second, PathArc):
        common = [
            point
            for point in crossings(_curve_at_end(first, before), _curve_at_start(second, after))
            if _reached(first, point) and _reached(second, point)
        ]
        if common:
            return Junction(min(common, key=lambda point: math.dist(point, first.end)), ())
    return Junction(end, polyline(end, start))


def compensated(element: Element, start: Point, end: Point, offset: Offset, detect: bool = True) -> tuple[Element, ...]:
    """Return the path of the centre along a programmed element, from one junction to the next.

    The path is one element: a line (without length if the junctions coincide) or an arc about the same centre. A full
    circle extended by its corners beyond one turn becomes two arcs. With `detect` off (M800) a path between crossed
    junctions runs backwards.
    """
    if isinstance(element, PathSegment):
        if detect and dot(between(start, end), element.direction_at_start) < -NEGLIGIBLE_LENGTH:
            raise CompensationFault(
                "backwards-motion",
                f"the line of {element.length:.4f} mm",
                f"is too short for a radius of {offset.radius:.4f} mm in its corners; use a smaller radius or a "
                "longer line",
                element,
            )
        return (PathSegment(start, end),)
    radius = centre_radius(element, offset)
    centre, rotation = element.centre, element.rotation
    trimmed = turn(between(centre, element.start), between(centre, start))
    trimmed += turn(between(centre, end), between(centre, element.end))
    angle = element.angle - rotation * trimmed
    if abs(angle) < NEGLIGIBLE_ANGLE or abs(angle) * radius < NEGLIGIBLE_LENGTH:
        return (PathSegment(start, end),)
    if angle < 0.0:
        if detect:
            raise CompensationFault(
                "interference",
                f"the arc of radius {element.radius:.4f} mm",
                f"is too short for a radius of {offset.radius:.4f} mm in its corners; use a smaller radius or a "
                "longer arc",
                element,
            )
        return (PathArc(start, end, centre, -rotation),)
    if angle > math.tau + NEGLIGIBLE_ANGLE:
        middle = rotated(start, centre, 0.5 * rotation * angle)
        return PathArc(start, middle, centre, rotation), PathArc(middle, end, centre, rotation)
    return (PathArc(start, end, centre, rotation),)


def feed_share(element: Element, offset: Offset, minimum_reduction: float) -> float:
    """Return the centre feed on an element as a share of F: below 1 on inside arcs, at least the minimum (1.7)."""
    if isinstance(element, PathSegment):
        return 1.0
    share = centre_radius(element, offset) / element.radius
    return min(1.0, max(share, minimum_reduction))


def centre_radius(arc: PathArc, offset: Offset) -> float:
    """Return the radius of the centre path along an arc, mm: smaller if the arc's centre is on the compensated side."""
    return _concentric(arc, min(arc.radius, math.dist(arc.end, arc.centre)), offset)


def outward(first: Element, second: Element, offset: Offset) -> float:
    """Return the angle `out` between two elements, rad, above -pi and up to pi.

    A reversal counts as outside. Exception: the second element bends away from the compensated side more than the
    reversed first one; then the centre runs between the two.
    """
    turned = -offset.side * turn(first.direction_at_end, second.direction_at_start)
    if math.pi - abs(turned) > TANGENTIAL:
        return turned
    bend = offset.side * (_curvature(first) + _curvature(second))
    return -math.pi if bend < -NEGLIGIBLE_ANGLE else math.pi


def around(point: Point, before: Point, after: Point, offset: Offset, out: float) -> tuple[Point, Point, Point, Point]:
    """Return the points of the straight way round an outside corner between two directions (2.2, 2.5).

    The points are the perpendicular point of the first path, the ends of both paths extended by at most one radius
    (one point for turns up to 90 degrees), and the perpendicular point of the second path.
    """
    extension = offset.radius * min(1.0, math.tan(0.5 * out))
    start, end = offset.beside(point, before), offset.beside(point, after)
    return start, moved(start, before, extension), moved(end, after, -extension), end


def _linear(first: Element, second: Element, offset: Offset, out: float, minimum: float) -> Junction:
    start, ahead, back, end = around(first.end, first.direction_at_end, second.direction_at_start, offset, out)
    points = [ahead, back]
    if isinstance(first, PathArc):
        points.insert(0, start)
    if isinstance(second, PathArc):
        points.append(end)
    lines = polyline(*points)
    # Mill 21-42: of two blocks the first is dropped, of three the second; a single one for the intersection (AMP 23-5).
    dropped = 1 if len(lines) == 3 else 0
    if lines and all(abs(component) < minimum for component in between(lines[dropped].start, lines[dropped].end)):
        if len(lines) > 1:
            merged = PathSegment(lines[dropped].start, lines[dropped + 1].end)
            lines = (*lines[:dropped], merged, *lines[dropped + 2 :])
        elif len(points) == 2 and out < math.pi - TANGENTIAL:
            return Junction(_mitre(first, out, offset), ())
    return Junction(points[0], lines)


def _mitre(first: Element, out: float, offset: Offset) -> Point:
    """Return the intersection of the offset of `first` with the offset of a line that follows at the angle `out`."""
    return moved(offset.beside_end(first), first.direction_at_end, offset.radius * math.tan(0.5 * out))


def _meeting(first: Element, second: Element, offset: Offset, out: float) -> Point | None:
    point, direction = first.end, first.direction_at_end
    common = crossings(_curve_at_end(first, offset), _curve_at_start(second, offset))
    if out == -math.pi:  # both are equally near, but only one is on the path
        return min(common, key=lambda candidate: dot(between(point, candidate), direction), default=None)
    return min(common, key=lambda candidate: math.dist(candidate, point), default=None)


def _curve_at_start(element: Element, offset: Offset) -> Curve:
    if isinstance(element, PathArc):
        return Circle(element.centre, _concentric(element, element.radius, offset))
    return StraightLine(offset.beside_start(element), element.direction_at_start)


def _curve_at_end(element: Element, offset: Offset) -> Curve:
    if isinstance(element, PathArc):
        return Circle(element.centre, _concentric(element, math.dist(element.end, element.centre), offset))
    return StraightLine(offset.beside_end(element), element.direction_at_end)


def _concentric(arc: PathArc, radius: float, offset: Offset) -> float:
    result = radius - offset.side * arc.rotation * offset.radius
    if result < NEGLIGIBLE_LENGTH:
        raise CompensationFault(
            "circular-departure-too-small",
            f"the arc of radius {radius:.4f} mm",
            f"is too small for a radius of {offset.radius:.4f} mm inside; use a smaller radius or a larger arc",
            arc,
        )
    return result


def _reached(element: Element, point: Point) -> bool:
    if isinstance(element, PathSegment):
        along = dot(between(element.start, point), element.direction_at_start)
        return -NEGLIGIBLE_LENGTH <= along <= element.length + NEGLIGIBLE_LENGTH
    turned = element.rotation * turn(between(element.centre, element.start), between(element.centre, point))
    return (turned + NEGLIGIBLE_ANGLE) % math.tau <= element.angle + 2.0 * NEGLIGIBLE_ANGLE


def _curvature(element: Element) -> float:
    return element.rotation / element.radius if isinstance(element, PathArc) else 0.0
