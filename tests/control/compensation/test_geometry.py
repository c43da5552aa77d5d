import pytest

from grind_env.control.compensation.intersections import Circle, StraightLine, crossings


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
def test_lines_and_circles_cross_at_the_known_points(
    first: StraightLine | Circle, second: StraightLine | Circle, expected: list[tuple[float, float]]
) -> None:
    """Pythagorean triples; 13, 14, 15 is the triangle of height 12."""
    for found in (crossings(first, second), crossings(second, first)):
        assert sorted(found) == [pytest.approx(point, abs=1e-7) for point in expected]
