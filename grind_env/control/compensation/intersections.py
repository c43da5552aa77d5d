"""Crossings of unlimited straight lines and whole circles of the plane."""

import math
from dataclasses import dataclass
from typing import TypeAlias

from grind_env.control.compensation.geometry import NEGLIGIBLE_LENGTH, Point, between, cross, dot, left, moved, unit

NEGLIGIBLE_SINE = 1e-9  #: lines whose directions have a smaller vector product are parallel


@dataclass(frozen=True, slots=True)
class StraightLine:
    """The unlimited straight line through a point along a unit vector."""

    point: Point
    direction: Point


@dataclass(frozen=True, slots=True)
class Circle:
    """A whole circle of a radius above 0."""

    centre: Point
    radius: float


Curve: TypeAlias = StraightLine | Circle


def crossings(first: Curve, second: Curve) -> list[Point]:
    """Return the common points of two curves: none, one or two; touching curves give one or two equal points.

    Curves that miss each other by no more than rounding touch.
    """
    if isinstance(first, Circle):
        return _on_circle(first, second) if isinstance(second, StraightLine) else _of_circles(first, second)
    return _on_circle(second, first) if isinstance(second, Circle) else _of_lines(first, second)


def _of_lines(first: StraightLine, second: StraightLine) -> list[Point]:
    sine = cross(first.direction, second.direction)
    if abs(sine) < NEGLIGIBLE_SINE:
        return []
    distance = cross(between(first.point, second.point), second.direction) / sine
    return [moved(first.point, first.direction, distance)]


def _on_circle(circle: Circle, line: StraightLine) -> list[Point]:
    to_centre = between(line.point, circle.centre)
    foot = moved(line.point, line.direction, dot(to_centre, line.direction))
    return _symmetric(foot, line.direction, circle.radius, abs(cross(line.direction, to_centre)))


def _of_circles(first: Circle, second: Circle) -> list[Point]:
    distance = math.dist(first.centre, second.centre)
    if distance < NEGLIGIBLE_LENGTH:
        return []
    direction = unit(between(first.centre, second.centre))
    squares = (first.radius - second.radius) * (first.radius + second.radius)
    along = 0.5 * (distance + squares / distance)
    foot = moved(first.centre, direction, along)
    return _symmetric(foot, left(direction), first.radius, abs(along))


def _symmetric(foot: Point, direction: Point, radius: float, distance: float) -> list[Point]:
    """Return the points of a circle on its chord whose middle is `foot`, at `distance` from the centre."""
    if distance > radius + NEGLIGIBLE_LENGTH:
        return []
    half = math.sqrt(max(radius - distance, 0.0) * (radius + distance))
    return [moved(foot, direction, -half), moved(foot, direction, half)]
