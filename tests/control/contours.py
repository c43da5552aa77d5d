"""Contours as curves: the path of a list of trace records, and its parts on a given line or arc."""

import math
from dataclasses import dataclass
from typing import Any

Vector = tuple[float, float, float]
FIRST_AND_SECOND = {"G17": (0, 1), "G18": (2, 0), "G19": (1, 2)}


@dataclass(frozen=True)
class Run:
    """One motion from start to end."""

    kind: str
    start: Vector
    end: Vector
    centre: tuple[float, float] | None = None
    rotation: int = 0
    plane: str = "G17"
    feed: float | None = None
    scope: str = "shared"

    def flat(self, point: Vector) -> tuple[float, float]:
        first, second = FIRST_AND_SECOND[self.plane]
        return point[first], point[second]

    @property
    def radius(self) -> float:
        assert self.centre is not None
        return math.dist(self.flat(self.start), self.centre)

    def sweep(self, point: Vector) -> float:
        """Return the angle from the start to a point in the sense of rotation, rad."""
        assert self.centre is not None
        u, v = self.flat(self.start), self.flat(point)
        begin = math.atan2(u[1] - self.centre[1], u[0] - self.centre[0])
        angle = math.atan2(v[1] - self.centre[1], v[0] - self.centre[0])
        return self.rotation * (angle - begin) % math.tau

    def points(self, count: int = 33) -> list[Vector]:
        """Return points evenly spread along the motion."""
        shares = [index / (count - 1) for index in range(count)]
        if self.kind != "arc":
            return [tuple(a + s * (b - a) for a, b in zip(self.start, self.end, strict=True)) for s in shares]
        assert self.centre is not None
        u = self.flat(self.start)
        begin = math.atan2(u[1] - self.centre[1], u[0] - self.centre[0])
        total = self.sweep(self.end) or math.tau
        first, second = FIRST_AND_SECOND[self.plane]
        normal = 3 - first - second
        result = []
        for share in shares:
            point = [0.0, 0.0, 0.0]
            angle = begin + self.rotation * share * total
            point[first] = self.centre[0] + self.radius * math.cos(angle)
            point[second] = self.centre[1] + self.radius * math.sin(angle)
            point[normal] = self.start[normal] + share * (self.end[normal] - self.start[normal])
            result.append((point[0], point[1], point[2]))
        return result

    def covers(self, other: "Run", tolerance: float) -> bool:
        """Return whether the motion contains the whole of another one in the same sense."""
        if self.kind != other.kind:
            return False
        if self.kind != "arc":
            return self._line_covers(other, tolerance)
        assert self.centre is not None and other.centre is not None
        if self.plane != other.plane or self.rotation != other.rotation:
            return False
        if math.dist(self.centre, other.centre) > tolerance or abs(self.radius - other.radius) > tolerance:
            return False
        slack = tolerance / self.radius
        begin = self.sweep(other.start)
        begin = 0.0 if math.tau - begin < slack else begin
        length = other.sweep(other.end)
        length = math.tau if length < slack else length
        total = self.sweep(self.end)
        return begin + length <= (math.tau if total < slack else total) + slack

    def _line_covers(self, other: "Run", tolerance: float) -> bool:
        way = [b - a for a, b in zip(self.start, self.end, strict=True)]
        length = math.hypot(*way)
        unit = [component / length for component in way]
        marks = []
        for point in (other.start, other.end):
            offset = [p - a for a, p in zip(self.start, point, strict=True)]
            mark = sum(a * b for a, b in zip(offset, unit, strict=True))
            if math.dist(offset, [mark * u for u in unit]) > tolerance:
                return False
            marks.append(mark)
        return -tolerance <= marks[0] <= marks[1] <= length + tolerance


def runs(records: list[dict[str, Any]]) -> list[Run]:
    """Return trace records as runs from the origin, without motions of no length."""
    position: Vector = (0.0, 0.0, 0.0)
    result: list[Run] = []
    for record in records:
        end: Vector = tuple(record["end"])
        centre = None
        if record["kind"] == "arc":
            first, second = FIRST_AND_SECOND[record["plane"]]
            centre = record["center"][first], record["center"][second]
        elif math.dist(position, end) <= 1e-9:
            continue
        result.append(
            Run(
                record["kind"],
                position,
                end,
                centre,
                record.get("rotation", 0),
                record.get("plane", "G17"),
                record.get("feed"),
                record.get("scope", "shared"),
            )
        )
        position = end
    return result
