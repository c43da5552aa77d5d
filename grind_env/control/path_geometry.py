"""Straight and circular paths: their length, and the point after a fraction of it; all in mm."""

import math
from dataclasses import dataclass, replace
from typing import TypeAlias

from grind_env.control.events import Position, placed
from grind_env.control.modes import PLANES

RADIUS_TOLERANCE = 0.01  #: mm by which the distances of start and end from the centre may differ; words carry 0.001 mm


class ImpossibleArc(ValueError):
    """An arc that cannot exist; the text says why."""


@dataclass(frozen=True, slots=True)
class Straight:
    """A straight line."""

    start: Position
    end: Position

    @property
    def length(self) -> float:
        return math.dist(self.start, self.end)

    def point(self, fraction: float) -> Position:
        x, y, z = (a + fraction * (b - a) for a, b in zip(self.start, self.end, strict=True))
        return x, y, z


@dataclass(frozen=True, slots=True)
class Circular:
    """An arc in a plane, counter-clockwise if its rotation is 1 (G03), or a helix if the third axis moves too.

    A full circle ends where it starts; the third coordinate of the centre is that of the start.
    """

    start: Position
    end: Position
    centre: Position
    rotation: int
    plane: str

    @property
    def angle(self) -> float:
        difference = self.rotation * (self._direction(self.end) - self._direction(self.start))
        turned = difference % math.tau
        return turned if turned > 1e-9 else math.tau

    @property
    def radius(self) -> float:
        return math.hypot(*self._offset(self.start))

    @property
    def length(self) -> float:
        first, second = PLANES[self.plane]
        normal = 3 - first - second
        return math.hypot(self.radius * self.angle, self.end[normal] - self.start[normal])

    def point(self, fraction: float) -> Position:
        first, second = PLANES[self.plane]
        normal = 3 - first - second
        direction = self._direction(self.start) + self.rotation * fraction * self.angle
        coordinates = {
            first: self.centre[first] + self.radius * math.cos(direction),
            second: self.centre[second] + self.radius * math.sin(direction),
            normal: self.start[normal] + fraction * (self.end[normal] - self.start[normal]),
        }
        return placed(self.start, coordinates)

    def moves(self, axis: int) -> bool:
        return axis in PLANES[self.plane] or self.start[axis] != self.end[axis]

    def _offset(self, point: Position) -> tuple[float, float]:
        first, second = PLANES[self.plane]
        return point[first] - self.centre[first], point[second] - self.centre[second]

    def _direction(self, point: Position) -> float:
        u, v = self._offset(point)
        return math.atan2(v, u)


Path: TypeAlias = Straight | Circular


def split(path: Path, fraction: float) -> tuple[Path, Path]:
    """Return the parts of a path before and after a fraction of its length."""
    middle = path.point(fraction)
    return replace(path, end=middle), replace(path, start=middle)


def arc_about(start: Position, end: Position, offset: tuple[float, float], rotation: int, plane: str) -> Circular:
    """Return the arc about the centre at `offset` from the start along the plane's first and second axis (14-5)."""
    first, second = PLANES[plane]
    centre = placed(start, {first: start[first] + offset[0], second: start[second] + offset[1]})
    radius = math.hypot(*offset)
    if radius == 0.0:
        raise ImpossibleArc("the centre is at the start point; I, J or K must lead away from it")
    to_end = math.hypot(end[first] - centre[first], end[second] - centre[second])
    if abs(to_end - radius) > min(RADIUS_TOLERANCE, 0.5 * radius):
        raise ImpossibleArc(
            f"the end is {to_end:.4f} mm from the centre but the start {radius:.4f} mm; "
            f"they may differ by {RADIUS_TOLERANCE} mm"
        )
    return Circular(start, end, centre, rotation, plane)


def arc_with_radius(start: Position, end: Position, radius: float, rotation: int, plane: str) -> Circular:
    """Return the arc with a radius; a negative one asks for the arc above 180 degrees (14-5)."""
    first, second = PLANES[plane]
    u, v = end[first] - start[first], end[second] - start[second]
    chord = math.hypot(u, v)
    if chord == 0.0:
        raise ImpossibleArc("the end is at the start point; a full circle needs I, J or K")
    if 0.5 * chord > abs(radius) + 0.5 * RADIUS_TOLERANCE:
        raise ImpossibleArc(
            f"the end is {chord:.4f} mm away; it can be at most twice the radius of {abs(radius):.4f} mm"
        )
    height = math.sqrt(max(radius * radius - 0.25 * chord * chord, 0.0))
    side = math.copysign(height, radius) * rotation / chord
    return arc_about(start, end, (0.5 * u - side * v, 0.5 * v + side * u), rotation, plane)
