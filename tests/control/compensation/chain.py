"""Chains of compensated elements, and distances worked out with complex numbers, apart from the code under test."""

import cmath
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from grind_env.control.compensation.corners import compensated, corner
from grind_env.control.compensation.entry_exit import entry, exit_junction
from grind_env.control.compensation.plane import Bow, Element, Offset, PathSegment, Point


@dataclass(frozen=True)
class Run:
    """A piece of the path of the centre; `of` counts the programmed elements, a generated piece is `of` none."""

    path: Element
    of: int | None


def joined(
    elements: Sequence[Element], offset: Offset, circular: bool, start: Point, end: Point, minimum: float = 0.0
) -> Iterator[Run]:
    for index, element in enumerate(elements):
        last = index == len(elements) - 1
        junction = None if last else corner(element, elements[index + 1], offset, circular, minimum)
        finish = end if junction is None else junction.end
        for path in compensated(element, start, finish, offset):
            yield Run(path, index)
        for path in junction.generated if junction else ():
            yield Run(path, None)
        start = (junction.generated[-1].end if junction.generated else junction.end) if junction else finish


def contour(elements: Sequence[Element], offset: Offset, circular: bool = False) -> list[Run]:
    """From the perpendicular point of the first start to that of the last end."""
    return list(joined(elements, offset, circular, offset.beside_start(elements[0]), offset.beside_end(elements[-1])))


def program(
    move: PathSegment,
    elements: Sequence[Element],
    out: Point,
    offset: Offset,
    circular: bool = False,
    kind: str = "A",
    vector: Point | None = None,
) -> list[Element]:
    """Entry, contour and exit to `out`, as in a part program."""
    way_in = entry(move, elements[0], offset, kind, circular)
    way_out = exit_junction(elements[-1], PathSegment(elements[-1].end, out), offset, kind, circular, vector)
    inner = [run.path for run in joined(elements, offset, circular, way_in[-1].end, way_out.end)]
    last = way_out.generated[-1].end if way_out.generated else way_out.end
    return [*way_in, *inner, *way_out.generated, PathSegment(last, out)]


def lines(*points: Point) -> list[Element]:
    return [PathSegment(start, end) for start, end in pairwise(points)]


def swept(arc: Bow) -> float:
    """Angle of an arc, rad; a full circle if it ends where it starts."""
    start, end, centre = complex(*arc.start), complex(*arc.end), complex(*arc.centre)
    if abs(start - end) < 1e-9:
        return math.tau
    return arc.rotation * cmath.phase((end - centre) / (start - centre)) % math.tau


def samples(path: Element, count: int = 60) -> list[complex]:
    """Points along a path, both ends among them."""
    start, end = complex(*path.start), complex(*path.end)
    if isinstance(path, PathSegment):
        return [start + (end - start) * i / count for i in range(count + 1)]
    centre, angle = complex(*path.centre), swept(path)
    return [centre + (start - centre) * cmath.exp(1j * path.rotation * angle * i / count) for i in range(count + 1)]


def distance(point: complex, element: Element) -> float:
    """From a point to the nearest one of an element."""
    start, end = complex(*element.start), complex(*element.end)
    ends = min(abs(point - start), abs(point - end))
    if isinstance(element, PathSegment):
        share = ((point - start) / (end - start)).real
        return abs(((point - start) / (end - start)).imag) * abs(end - start) if 0.0 <= share <= 1.0 else ends
    centre = complex(*element.centre)
    turned = element.rotation * cmath.phase((point - centre) / (start - centre)) % math.tau
    return abs(abs(point - centre) - abs(start - centre)) if turned <= swept(element) else ends


def clear_of_curve(point: complex, element: Element) -> float:
    """From a point to the whole line or circle that an element is part of."""
    start, end = complex(*element.start), complex(*element.end)
    if isinstance(element, PathSegment):
        return abs(((point - start) / (end - start)).imag) * abs(end - start)
    centre = complex(*element.centre)
    return abs(abs(point - centre) - abs(start - centre))


def element_from(start: complex, heading: float, bend: float, size: float) -> Element:
    """A line (bend 0) of length `size`, or an arc of radius `size` that turns by `bend` degrees from the heading."""
    direction = cmath.rect(1.0, heading)
    if bend == 0.0:
        return PathSegment(point(start), point(start + size * direction))
    rotation = 1 if bend > 0.0 else -1
    centre = start + 1j * rotation * size * direction
    end = centre + (start - centre) * cmath.exp(1j * math.radians(bend))
    return Bow(point(start), point(end), point(centre), rotation)


def path_of(start: complex, heading: float, parts: Sequence[tuple[float, float, float]]) -> list[Element]:
    """Elements (turn before it in degrees, bend, size) in a row."""
    elements: list[Element] = []
    for corner_turn, bend, size in parts:
        heading += math.radians(corner_turn)
        elements.append(element_from(start, heading, bend, size))
        start, heading = complex(*elements[-1].end), heading + math.radians(bend)
    return elements


def point(number: complex) -> Point:
    return number.real, number.imag
