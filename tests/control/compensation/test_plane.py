import math

import pytest

from grind_env.control.compensation.crossings import Circle, StraightLine, crossings
from grind_env.control.compensation.plane import Bow, Offset, PathSegment, polyline, rotated


def test_segment() -> None:
    segment = PathSegment((1.0, 2.0), (4.0, 6.0))
    assert segment.length == 5.0
    assert segment.direction_at_start == segment.direction_at_end == pytest.approx((0.6, 0.8))


@pytest.mark.parametrize(
    ("rotation", "degrees", "at_start", "at_end"),
    [(1, 90, (0.0, 1.0), (-1.0, 0.0)), (-1, 270, (0.0, -1.0), (1.0, 0.0))],
)
def test_arc(rotation: int, degrees: float, at_start: tuple[float, float], at_end: tuple[float, float]) -> None:
    arc = Bow((3.0, 1.0), (1.0, 3.0), (1.0, 1.0), rotation)
    assert math.degrees(arc.angle) == pytest.approx(degrees)
    assert arc.length == pytest.approx(math.radians(degrees) * 2.0)
    assert arc.direction_at_start == pytest.approx(at_start)
    assert arc.direction_at_end == pytest.approx(at_end)


@pytest.mark.parametrize("rotation", [1, -1])
@pytest.mark.parametrize("error", [0.0, 1e-12, -1e-12])
def test_an_arc_to_its_start_is_a_full_circle(rotation: int, error: float) -> None:
    arc = Bow((5.0, 0.0), (5.0, error), (0.0, 0.0), rotation)
    assert arc.angle == pytest.approx(math.tau)


@pytest.mark.parametrize(
    ("table_radius", "code", "radius", "side"),
    [(2.0, "G41", 2.0, 1), (2.0, "G42", 2.0, -1), (-2.0, "G41", 2.0, -1), (-2.0, "G42", 2.0, 1), (0.0, "G42", 0.0, -1)],
)
def test_a_negative_radius_swaps_the_sides(table_radius: float, code: str, radius: float, side: int) -> None:
    offset = Offset.of(table_radius, code)
    assert (offset.radius, offset.side, offset.table_radius) == (radius, side, table_radius)


def test_beside() -> None:
    up = PathSegment((0.0, 0.0), (0.0, 10.0))
    assert Offset(2.0, 1).beside_end(up) == pytest.approx((-2.0, 10.0))
    assert Offset(2.0, -1).beside_start(up) == pytest.approx((2.0, 0.0))


def test_polyline_leaves_out_what_has_no_length() -> None:
    points = (0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (1.0, 1e-12), (1.0, 1.0)
    assert polyline(*points) == (PathSegment((0.0, 0.0), (1.0, 0.0)), PathSegment((1.0, 0.0), (1.0, 1.0)))


def test_rotated() -> None:
    assert rotated((3.0, 1.0), (1.0, 1.0), 0.5 * math.pi) == pytest.approx((1.0, 3.0))


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        (StraightLine((0.0, 1.0), (1.0, 0.0)), StraightLine((5.0, 7.0), (0.6, 0.8)), [(0.5, 1.0)]),
        (StraightLine((0.0, 1.0), (1.0, 0.0)), StraightLine((5.0, 7.0), (-1.0, 0.0)), []),
        (StraightLine((9.0, 3.0), (1.0, 0.0)), Circle((0.0, 0.0), 5.0), [(-4.0, 3.0), (4.0, 3.0)]),
        (Circle((1.0, 1.0), 5.0), StraightLine((9.0, 6.0), (1.0, 0.0)), [(1.0, 6.0), (1.0, 6.0)]),
        (Circle((0.0, 0.0), 5.0), StraightLine((0.0, 5.0 + 1e-12), (1.0, 0.0)), [(0.0, 5.0), (0.0, 5.0)]),
        (Circle((0.0, 0.0), 5.0), StraightLine((0.0, 5.0 + 1e-6), (1.0, 0.0)), []),
        (Circle((0.0, 0.0), 15.0), Circle((14.0, 0.0), 13.0), [(9.0, -12.0), (9.0, 12.0)]),
        (Circle((0.0, 0.0), 20.0), Circle((7.0, 0.0), 15.0), [(16.0, -12.0), (16.0, 12.0)]),
        (Circle((0.0, 0.0), 2.0), Circle((5.0, 0.0), 3.0), [(2.0, 0.0), (2.0, 0.0)]),
        (Circle((0.0, 0.0), 2.0), Circle((5.0, 0.0), 2.9), []),
        (Circle((0.0, 0.0), 9.0), Circle((1.0, 0.0), 2.0), []),
        (Circle((1.0, 1.0), 5.0), Circle((1.0, 1.0), 5.0), []),
    ],
)
def test_crossings(
    first: StraightLine | Circle, second: StraightLine | Circle, expected: list[tuple[float, float]]
) -> None:
    """Pythagorean triples; 13, 14, 15 is the triangle of height 12."""
    for found in (crossings(first, second), crossings(second, first)):
        assert sorted(found) == [pytest.approx(point, abs=1e-7) for point in expected]
