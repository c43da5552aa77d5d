"""Gouging: elements of a path closer than the wheel is wide, without being neighbours (compensation-D18).

Where the wheel runs along both and does not fit between them, the path of its centre crosses itself: along one of them
it cuts into the other. Neighbours are a matter of their corner (`corners`).
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.control.compensation.crossings import Circle, Curve, StraightLine, crossings
from grind_env.control.compensation.plane import (
    NEGLIGIBLE_ANGLE,
    Bow,
    Element,
    PathSegment,
    Point,
    between,
    cross,
    dot,
    turn,
)
from grind_env.control.errors import Place

HELD = 200
"""Elements behind the wheel that are compared with each new one."""
NEAR = 1e-6
"""mm; a crossing so close to the end of a new element is none, for it may end beside the wheel's old path."""
PARALLEL = 1e-6
"""Sine of the angle below which two paths touch and do not cross."""


class Passed(NamedTuple):
    """An element along which the wheel has run."""

    place: Place
    """Place of its block."""
    programmed: Element
    centre: tuple[Element, ...]
    """The path of the wheel's centre along it, with what is generated behind it."""
    level: float
    """Third coordinate, mm."""


@dataclass(slots=True)
class GougeCheck:
    """Compares each element with those along which the wheel has run since the compensation was switched on."""

    count: int = 0  # elements so far
    passed: list[Passed] = field(default_factory=list)  # the last ones, each at the remainder of its number by `HELD`
    # of their paths, mm, shape (4, `HELD`): least coordinates, and greatest with the other sign; NaN where none is
    boxes: NDArray[np.float64] = field(default_factory=lambda: np.full((4, HELD), math.nan))

    def follow(self, place: Place, programmed: Element, centre: tuple[Element, ...], level: float) -> Place | None:
        """Take up an element; returns the block of an earlier one that the wheel cannot pass beside it."""
        new, (left, low, right, high) = Passed(place, programmed, centre, level), _box(centre)
        overlap = np.logical_and.reduce(self.boxes <= [[right], [high], [-left], [-low]])
        oldest_first = sorted(overlap.nonzero()[0].tolist(), key=lambda number: (number - self.count) % HELD)
        neighbour, at = (self.count - 1) % HELD, self.count % HELD
        others = (self.passed[number] for number in oldest_first if number != neighbour)
        gouged = next((old.place for old in others if _gouges(new, old)), None)
        self.passed[at : at + 1] = [new]
        self.boxes[:, at] = left, low, -right, -high
        self.count += 1
        return gouged


def _gouges(new: Passed, old: Passed) -> bool:
    if abs(new.level - old.level) > NEAR or not any(_cross(a, b) for a in new.centre for b in old.centre):
        return False
    return not _meet(new.programmed, old.programmed)  # a contour that closes or crosses itself is meant to


def _box(elements: tuple[Element, ...]) -> tuple[float, float, float, float]:
    corners: list[Point] = []
    for element in elements:
        corners += [element.start, element.end]
        if isinstance(element, Bow):  # its circle is large enough and quick to find
            (u, v), radius = element.centre, element.radius
            corners += [(u - radius, v - radius), (u + radius, v + radius)]
    us, vs = zip(*corners, strict=True)
    return min(us), min(vs), max(us), max(vs)


def _cross(a: Element, b: Element) -> bool:
    return any(
        _within(a, point, -NEAR)
        and _within(b, point, NEAR)
        and abs(cross(_direction(a, point), _direction(b, point))) > PARALLEL
        for point in _common(a, b)
    )


def _meet(a: Element, b: Element) -> bool:
    if math.dist(a.start, b.end) < NEAR or math.dist(a.end, b.start) < NEAR:
        return True
    return any(_within(a, point, NEAR) and _within(b, point, NEAR) for point in _common(a, b))


def _common(a: Element, b: Element) -> tuple[Point, ...]:
    if any(math.dist(each.start, each.end) < NEAR and isinstance(each, PathSegment) for each in (a, b)):
        return ()
    return tuple(crossings(_curve(a), _curve(b)))


def _curve(element: Element) -> Curve:
    if isinstance(element, Bow):
        return Circle(element.centre, element.radius)
    return StraightLine(element.start, element.direction_at_start)


def _direction(element: Element, point: Point) -> Point:
    return element.direction_at(point) if isinstance(element, Bow) else element.direction_at_start


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
