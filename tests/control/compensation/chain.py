"""Elements computed with complex numbers, independently of the code under test."""

import cmath
import math
from itertools import pairwise

from grind_env.control.compensation.geometry import Element, PathArc, PathSegment, Point


def lines(*points: Point) -> list[Element]:
    return [PathSegment(start, end) for start, end in pairwise(points)]


def swept(arc: PathArc) -> float:
    """Return the angle of an arc, rad; a full circle if it ends at its start."""
    start, end, centre = complex(*arc.start), complex(*arc.end), complex(*arc.centre)
    if abs(start - end) < 1e-9:
        return math.tau
    return arc.rotation * cmath.phase((end - centre) / (start - centre)) % math.tau


def element_from(start: complex, heading: float, bend: float, size: float) -> Element:
    """Return a line of length `size` (bend 0), or an arc of radius `size` that turns by `bend` degrees."""
    direction = cmath.rect(1.0, heading)
    if bend == 0.0:
        return PathSegment(point(start), point(start + size * direction))
    rotation = 1 if bend > 0.0 else -1
    centre = start + 1j * rotation * size * direction
    end = centre + (start - centre) * cmath.exp(1j * math.radians(bend))
    return PathArc(point(start), point(end), point(centre), rotation)


def point(number: complex) -> Point:
    return number.real, number.imag
