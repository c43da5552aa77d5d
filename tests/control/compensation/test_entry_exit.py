"""Entry and exit beyond the worked examples E1 to E9, which test_compensation.py runs as programs."""

import math

import pytest

from grind_env.control.compensation.entry_exit import entry, exit_junction
from grind_env.control.compensation.geometry import Element, Offset, PathArc, PathSegment, Point

LEFT, RIGHT = Offset(2.0, 1), Offset(2.0, -1)


def ends(path: list[Element]) -> list[object]:
    return [pytest.approx(piece.end, abs=1e-4) for piece in path]


def exit_path(
    last: Element, end: Point, offset: Offset, kind: str = "A", circular: bool = False, vector: Point | None = None
) -> list[Element]:
    """Return the path after the last compensated element, from a line of no length at its end."""
    junction = exit_junction(last, PathSegment(last.end, end), offset, kind, circular, vector)
    start = junction.generated[-1].end if junction.generated else junction.end
    return [PathSegment(junction.end, junction.end), *junction.generated, PathSegment(start, end)]


def test_an_entry_without_a_next_move_ends_at_right_angles_to_itself() -> None:
    move = PathSegment((0.0, 0.0), (6.0, 8.0))
    for kind in ("A", "B"):
        assert ends(list(entry(move, None, LEFT, kind, False))) == [(6.0 - 1.6, 8.0 + 1.2)]


def test_the_vector_shifts_the_end_of_an_arc_along_its_circle() -> None:
    # Ends at (10, 0) about the origin along +v; with r = 2 on the right the circle has radius 12.
    arc = PathArc((0.0, -10.0), (10.0, 0.0), (0.0, 0.0), 1)
    # A line along (-0.8, 0.6) two to its right, through (11.2, 1.6): the distance from the origin is 8, and it meets
    # the circle where its foot (4.8, 6.4) is left by sqrt(144 - 64) against its direction.
    half = math.sqrt(80.0)
    met = (4.8 + 0.8 * half, 6.4 - 0.6 * half)
    assert math.dist(met, (12.0, 0.0)) < 2.0
    assert ends(exit_path(arc, (30.0, 0.0), RIGHT, vector=(-8.0, 6.0)))[0] == met
    for vector, way in (((0.0, 3.0), -2.0), ((0.0, -3.0), 2.0)):  # parallel: one radius against the vector
        end = (12.0 * math.cos(way / 12.0), 12.0 * math.sin(way / 12.0))
        assert ends(exit_path(arc, (30.0, 0.0), RIGHT, vector=vector))[0] == end


def test_a_vector_that_misses_the_circle_has_no_effect() -> None:
    # Ends at (10, 0), circle of radius 8; the line two to the left of (0.6, -0.8) is 10 from the origin.
    arc = PathArc((0.0, -10.0), (10.0, 0.0), (0.0, 0.0), 1)
    assert ends(exit_path(arc, (0.0, 0.0), LEFT, vector=(3.0, -4.0)))[0] == (8.0, 0.0)


def test_the_shift_on_a_small_circle_is_at_most_a_quarter_turn() -> None:
    arc = PathArc((0.0, -2.1), (2.1, 0.0), (0.0, 0.0), 1)
    assert ends(exit_path(arc, (0.0, 0.0), LEFT, vector=(0.0, -1.0)))[0] == (0.0, 0.1)


def test_type_b_runs_round_sharp_corners_in_arcs() -> None:
    move = PathSegment((0.0, 0.0), (10.0, 0.0))
    straight, arc = entry(move, PathSegment((10.0, 0.0), (0.0, -10.0)), LEFT, "B", True)
    assert straight == PathSegment((0.0, 0.0), (10.0, 2.0))
    assert isinstance(arc, PathArc)
    assert (arc.start, arc.centre, arc.rotation) == ((10.0, 2.0), (10.0, 0.0), -1)
    assert arc.end == pytest.approx((11.4142, -1.4142), abs=1e-4)
    junction = exit_junction(move, PathSegment((10.0, 0.0), (4.0, -6.0)), LEFT, "B", True, None)
    (same,) = junction.generated
    assert isinstance(same, PathArc)
    assert (junction.end, same.start, same.centre, same.rotation) == ((10.0, 2.0), arc.start, arc.centre, -1)
    assert same.end == pytest.approx(arc.end)


def test_type_b_exit_from_an_arc_leaves_along_its_tangent() -> None:
    arc = PathArc((0.0, 10.0), (10.0, 0.0), (10.0, 10.0), 1)  # ends along +u; the centre on the left
    assert ends(exit_path(arc, (10.0, -8.0), LEFT, "B")) == [(10.0, 2.0), (12.0, 2.0), (10.0, -8.0)]
    assert ends(exit_path(arc, (4.0, -6.0), LEFT, "B")) == [
        (10.0, 2.0),
        (12.0, 2.0),
        (12.8284, 0.0),
        (11.4142, -1.4142),
        (4.0, -6.0),
    ]


def test_an_entry_without_motion_is_a_line_of_no_length() -> None:
    following = PathSegment((10.0, 0.0), (20.0, 0.0))
    (run,) = entry(PathSegment((10.0, 2.0), (10.0, 0.0)), following, LEFT, "A", False)
    assert run == PathSegment((10.0, 2.0), (10.0, 2.0))
