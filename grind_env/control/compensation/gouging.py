"""Gouging: the wheel does not fit between two elements of a path that are not neighbours (compensation-D18).

The path of the wheel centre then crosses itself: along one element the wheel cuts into the other. `corners` checks
neighbours.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.control.compensation.geometry import (
    NEGLIGIBLE_ANGLE,
    Element,
    PathArc,
    PathSegment,
    Point,
    between,
    cross,
    dot,
    turn,
)
from grind_env.control.compensation.intersections import Circle, Curve, StraightLine, crossings
from grind_env.control.errors import Place

COMPARED = 200  #: number of last elements with which each new one is compared
#: mm; a crossing so close to the end of a new element does not count: the element may end beside the old path
END_TOLERANCE = 1e-6
PARALLEL = 1e-6  #: sine of the angle below which two paths touch and do not cross


class Passed(NamedTuple):
    """An element along which the wheel has run."""

    place: Place  #: place of its block
    programmed: Element
    centre: tuple[Element, ...]  #: path of the wheel centre along the element, with the elements generated behind it
    level: float  #: third coordinate, mm


@dataclass(slots=True)
class GougeCheck:
    """Comparison of each element with the last ones since the compensation was switched on."""

    count: int = 0  #: number of elements so far
    passed: list[Passed] = field(default_factory=list)  #: last elements; element n has index n modulo `COMPARED`
    # boxes around their paths, mm, shape (4, `COMPARED`): least coordinates, then negated greatest ones; NaN if empty
    boxes: NDArray[np.float64] = field(default_factory=lambda: np.full((4, COMPARED), math.nan))

    def follow(self, place: Place, programmed: Element, centre: tuple[Element, ...], level: float) -> Place | None:
        """Add an element; return the block of an earlier one if the wheel does not fit between both, else None."""
        new, (left, low, right, high) = Passed(place, programmed, centre, level), _box(centre)
        overlap = np.logical_and.reduce(self.boxes <= [[right], [high], [-left], [-low]])
        oldest_first = sorted(overlap.nonzero()[0].tolist(), key=lambda number: (number - self.count) % COMPARED)
        neighbour, at = (self.count - 1) % COMPARED, self.count % COMPARED
        others = (self.passed[number] for number in oldest_first if number != neighbour)
        gouged = next((old.place for old in others if _gouges(new, old)), None)
        self.passed[at : at + 1] = [new]
        self.boxes[:, at] = left, low, -right, -high
        self.count += 1
        return gouged


def _gouges(new: Passed, old: Passed) -> bool:
    if abs(new.level - old.level) > END_TOLERANCE or not any(_cross(a, b) for a in new.centre for b in old.centre):
        return False
    return not _meet(new.programmed, old.programmed)  # a contour that closes or crosses itself is meant to


def _box(elements: tuple[Element, ...]) -> tuple[float, float, float, float]:
    corners: list[Point] = []
    for element in elements:
        corners += [element.start, element.end]
        if isinstance(element, PathArc):  # the box of its whole circle is large enough and cheap
            (u, v), radius = element.centre, element.radius
            corners += [(u - radius, v - radius), (u + radius, v + radius)]
    us, vs = zip(*corners, strict=True)
    return min(us), min(vs), max(us), max(vs)


def _cross(a: Element, b: Element) -> bool:
    return any(
        _within(a, point, -END_TOLERANCE)
        and _within(b, point, END_TOLERANCE)
        and abs(cross(_direction(a, point), _direction(b, point))) > PARALLEL
        for point in _common(a, b)
    )


def _meet(a: Element, b: Element) -> bool:
    if math.dist(a.start, b.end) < END_TOLERANCE or math.dist(a.end, b.start) < END_TOLERANCE:
        return True
    return any(_within(a, point, END_TOLERANCE) and _within(b, point, END_TOLERANCE) for point in _common(a, b))


def _common(a: Element, b: Element) -> tuple[Point, ...]:
    if any(math.dist(each.start, each.end) < END_TOLERANCE and isinstance(each, PathSegment) for each in (a, b)):
        return ()
    return tuple(crossings(_curve(a), _curve(b)))


def _curve(element: Element) -> Curve:
    if isinstance(element, PathArc):
        return Circle(element.centre, element.radius)
    return StraightLine(element.start, element.direction_at_start)


def _direction(element: Element, point: Point) -> Point:
    return element.direction_at(point) if isinstance(element, PathArc) else element.direction_at_start


def _within(element: Element, point: Point, beyond: float) -> bool:
    """Return whether a point of its curve lies on an element extended at both ends by `beyond` mm."""
    if isinstance(element, PathSegment):
        along = dot(between(element.start, point), element.direction_at_start)
        return -beyond <= along <= element.length + beyond
    angle = beyond / element.radius
    turned = element.rotation * turn(between(element.centre, element.start), between(element.centre, point)) % math.tau
    if element.angle > math.tau - NEGLIGIBLE_ANGLE and beyond >= 0.0:
        return True
    return -angle <= turned <= element.angle + angle or turned >= math.tau - angle
