"""Paths in the compensation plane and the side they are offset to.

A point is (first axis, second axis) of the plane, so (Z, X) in G18; counter-clockwise, the sense of G03 and of
rotation +1, turns the first axis towards the second. Lengths are in mm, angles in rad.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

Point: TypeAlias = tuple[float, float]  #: a point, or a vector, of the plane

#: mm; points closer than this are equal. Words carry 1e-3 mm, rounding errors are some 1e-13 mm
NEGLIGIBLE_LENGTH = 1e-9

NEGLIGIBLE_ANGLE = 1e-9  #: rad; an arc that ends where it starts within this angle is a full circle


def moved(point: Point, direction: Point, distance: float) -> Point:
    """Return the point at `distance` from another one along a unit vector."""
    return point[0] + distance * direction[0], point[1] + distance * direction[1]


def between(start: Point, end: Point) -> Point:
    """Return the vector from one point to another."""
    return end[0] - start[0], end[1] - start[1]


def dot(a: Point, b: Point) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Point, b: Point) -> float:
    """Return the third component of the vector product: positive if b points to the left of a."""
    return a[0] * b[1] - a[1] * b[0]


def left(vector: Point) -> Point:
    """Return the vector turned by +90 degrees."""
    return -vector[1], vector[0]


def unit(vector: Point) -> Point:
    """Return the direction of a vector that is not zero."""
    length = math.hypot(*vector)
    return vector[0] / length, vector[1] / length


@dataclass(frozen=True, slots=True)
class PathSegment:
    """A straight line; it has directions only if its ends differ."""

    start: Point
    end: Point

    @property
    def length(self) -> float:
        return math.dist(self.start, self.end)

    @property
    def direction_at_start(self) -> Point:
        return unit(between(self.start, self.end))

    @property
    def direction_at_end(self) -> Point:
        return self.direction_at_start


@dataclass(frozen=True, slots=True)
class PathArc:
    """An arc, counter-clockwise if its rotation is 1; a full circle if start and end coincide.

    As words are rounded, start and end may be at slightly different distances from the centre.
    """

    start: Point
    end: Point
    centre: Point
    rotation: int

    @property
    def radius(self) -> float:
        return math.dist(self.start, self.centre)

    @property
    def angle(self) -> float:
        turned = self.rotation * turn(between(self.centre, self.start), between(self.centre, self.end)) % math.tau
        return turned if NEGLIGIBLE_ANGLE < turned < math.tau else math.tau

    @property
    def length(self) -> float:
        return self.radius * self.angle

    @property
    def direction_at_start(self) -> Point:
        return self.direction_at(self.start)

    @property
    def direction_at_end(self) -> Point:
        return self.direction_at(self.end)

    def direction_at(self, point: Point) -> Point:
        tangent = left(unit(between(self.centre, point)))
        return self.rotation * tangent[0], self.rotation * tangent[1]


Element: TypeAlias = PathSegment | PathArc


def turn(before: Point, after: Point) -> float:
    """Return the angle from one vector to another, rad, counter-clockwise positive, from -pi to pi."""
    return math.atan2(cross(before, after), dot(before, after))


def rotated(point: Point, centre: Point, angle: float) -> Point:
    """Return the point turned about a centre by an angle, rad, counter-clockwise positive."""
    u, v = between(centre, point)
    cosine, sine = math.cos(angle), math.sin(angle)
    return centre[0] + u * cosine - v * sine, centre[1] + u * sine + v * cosine


def polyline(*points: Point) -> tuple[PathSegment, ...]:
    """Return the straight lines through some points; lines without length are left out."""
    kept = [points[0]]
    for point in points[1:]:
        if math.dist(kept[-1], point) > NEGLIGIBLE_LENGTH:
            kept.append(point)
    return tuple(PathSegment(start, end) for start, end in pairwise(kept))


@dataclass(frozen=True, slots=True)
class Offset:
    """Distance and side of the centre path from the programmed path."""

    radius: float  #: distance, not negative
    side: int  #: 1 left, -1 right, seen along the motion
    swapped: bool = False  #: whether the radius table holds the negative of `radius`, which swaps the sides (15-5)

    @classmethod
    def of(cls, table_radius: float, code: str) -> "Offset":
        side = {"G41": 1, "G42": -1}[code]
        swapped = table_radius < 0.0
        return cls(abs(table_radius), -side if swapped else side, swapped)

    @property
    def table_radius(self) -> float:
        return -self.radius if self.swapped else self.radius

    def beside(self, point: Point, direction: Point) -> Point:
        """Return the point one radius from another, at right angles to a unit vector and on the compensated side."""
        return moved(point, left(direction), self.side * self.radius)

    def beside_start(self, element: Element) -> Point:
        return self.beside(element.start, element.direction_at_start)

    def beside_end(self, element: Element) -> Point:
        return self.beside(element.end, element.direction_at_end)
