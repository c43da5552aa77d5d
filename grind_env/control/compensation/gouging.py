"""Elements that are no neighbours, but closer to each other than the wheel is wide (compensation-D18).

Where the wheel runs along both and does not fit between them, the path of its centre crosses itself: along one of them
it cuts into the other. Neighbours are a matter of their corner (`corners`).
"""

import math
from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

from grind_env.control.compensation.crossings import Circle, Curve, Line, crossings
from grind_env.control.compensation.plane import (
    NEGLIGIBLE_ANGLE,
    Bow,
    Element,
    Point,
    Segment,
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
    """Of its block."""
    programmed: Element
    centre: tuple[Element, ...]
    """The path of the wheel's centre along it, with what is generated behind it."""
    box: tuple[float, float, float, float]
    """Least and greatest coordinates of that path."""
    level: float
    """Third coordinate, mm."""


@dataclass(slots=True)
class GougeCheck:
    """Compares each element with those along which the wheel has run since the compensation was switched on."""

    passed: deque[Passed] = field(default_factory=lambda: deque(maxlen=HELD))

    def follow(self, place: Place, programmed: Element, centre: tuple[Element, ...], level: float) -> Place | None:
        """Take up an element; returns the block of an earlier one that the wheel cannot pass beside it.

        Args:
            place: of its block.
            programmed: the element.
            centre: path of the wheel's centre along it and round the corner behind it.
            level: third coordinate, mm; elements at other levels do not matter.
        """
        new = Passed(place, programmed, centre, _box(centre), level)
        gouged = next((old.place for old in list(self.passed)[:-1] if _gouges(new, old)), None)
        self.passed.append(new)
        return gouged


def _gouges(new: Passed, old: Passed) -> bool:
    if abs(new.level - old.level) > NEAR or not _overlap(new.box, old.box):
        return False
    if not any(_cross(a, b) for a in new.centre for b in old.centre):
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


def _overlap(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> bool:
    return a[0] <= b[2] and b[0] <= a[2] and a[1] <= b[3] and b[1] <= a[3]


def _cross(a: Element, b: Element) -> bool:
    """Whether the first element crosses the second one or passes through its end."""
    return any(
        _within(a, point, -NEAR)
        and _within(b, point, NEAR)
        and abs(cross(_direction(a, point), _direction(b, point))) > PARALLEL
        for point in _common(a, b)
    )


def _meet(a: Element, b: Element) -> bool:
    """Whether two elements have a point in common, an end included."""
    if math.dist(a.start, b.end) < NEAR or math.dist(a.end, b.start) < NEAR:
        return True
    return any(_within(a, point, NEAR) and _within(b, point, NEAR) for point in _common(a, b))


def _common(a: Element, b: Element) -> tuple[Point, ...]:
    if any(math.dist(each.start, each.end) < NEAR and isinstance(each, Segment) for each in (a, b)):
        return ()
    return tuple(crossings(_curve(a), _curve(b)))


def _curve(element: Element) -> Curve:
    if isinstance(element, Bow):
        return Circle(element.centre, element.radius)
    return Line(element.start, element.direction_at_start)


def _direction(element: Element, point: Point) -> Point:
    return element.direction_at(point) if isinstance(element, Bow) else element.direction_at_start


def _within(element: Element, point: Point, beyond: float) -> bool:
    """Whether a point of its curve lies on an element that is made longer at both ends by `beyond` mm."""
    if isinstance(element, Segment):
        along = dot(between(element.start, point), element.direction_at_start)
        return -beyond <= along <= element.length + beyond
    angle = beyond / element.radius
    turned = element.rotation * turn(between(element.centre, element.start), between(element.centre, point)) % math.tau
    if element.angle > math.tau - NEGLIGIBLE_ANGLE and beyond >= 0.0:
        return True
    return -angle <= turned <= element.angle + angle or turned >= math.tau - angle
