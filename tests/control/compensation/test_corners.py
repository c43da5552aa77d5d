import math

import pytest

from grind_env.control.compensation.corners import CompensationFault, compensated, corner, feed_share, side_change
from grind_env.control.compensation.geometry import Element, Offset, PathArc, PathSegment, Point
from tests.control.compensation.chain import element_from, lines, swept

LEFT, RIGHT = Offset(2.0, 1), Offset(2.0, -1)


def turned(first: Element, degrees: float, length: float = 50.0) -> PathSegment:
    """Return a line from the end of a first one at an angle to +u."""
    u, v = first.end
    angle = math.radians(degrees)
    return PathSegment((u, v), (u + length * math.cos(angle), v + length * math.sin(angle)))


EAST = PathSegment((0.0, 0.0), (10.0, 0.0))


@pytest.mark.parametrize(("offset", "rotation"), [(LEFT, -1), (RIGHT, 1)])
def test_a_reversal_is_joined_round_the_corner(offset: Offset, rotation: int) -> None:
    side, back = offset.side, PathSegment((10.0, 0.0), (0.0, 0.0))
    straight = corner(EAST, back, offset, False, 0.0)
    assert straight.end == pytest.approx((12.0, 2.0 * side))
    assert [piece.end for piece in straight.generated] == [pytest.approx((12.0, -2.0 * side))]
    (arc,) = corner(EAST, back, offset, True, 0.0).generated
    assert isinstance(arc, PathArc)
    assert arc.start == pytest.approx((10.0, 2.0 * side))
    assert arc.end == pytest.approx((10.0, -2.0 * side))
    assert arc.rotation == rotation
    assert swept(arc) == pytest.approx(math.pi)


def test_generated_blocks_at_arcs_run_along_the_tangents() -> None:
    first = PathArc((0.0, -10.0), (10.0, 0.0), (0.0, 0.0), 1)  # ends along +v
    second = PathArc((10.0, 0.0), (10.0, -20.0), (10.0, -10.0), -1)  # starts along +u: 90 degrees inside to the right
    sharp = PathArc((10.0, 0.0), (0.0, -10.0), (10.0, -10.0), 1)  # starts along -u: 90 degrees outside
    reverse = PathArc((10.0, 0.0), (20.0, -10.0), (20.0, 0.0), 1)  # starts along -v: a cusp that opens away
    assert corner(first, second, RIGHT, False, 0.0).generated == ()
    assert corner(first, sharp, RIGHT, False, 0.0).generated == ()
    junction = corner(first, reverse, LEFT, False, 0.0)
    assert junction.end == pytest.approx((8.0, 0.0))
    assert [piece.end for piece in junction.generated] == [
        pytest.approx((8.0, 2.0)),
        pytest.approx((12.0, 2.0)),
        pytest.approx((12.0, 0.0)),
    ]


@pytest.mark.parametrize("arc_radius", [3.0, 7.7, 10.0, 12.3])
@pytest.mark.parametrize("radius", [0.3, 1.0, 1.7])
def test_a_cusp_is_inside_where_the_arc_bends_over_the_line(arc_radius: float, radius: float) -> None:
    over = PathArc((10.0, 0.0), (10.0 - arc_radius, arc_radius), (10.0, arc_radius), -1)  # leaves along -u, bends to +v
    # The circle of radius R + r about (10, R) and the line v = r: u = 10 -+ sqrt((R + r)^2 - (R - r)^2).
    met = pytest.approx((10.0 - math.sqrt(4.0 * arc_radius * radius), radius))
    inside = corner(EAST, over, Offset(radius, 1), False, 0.0)
    assert inside.end == met
    assert inside.generated == ()
    back = PathArc(over.end, over.start, over.centre, 1), PathSegment(EAST.end, EAST.start)
    assert corner(*back, Offset(radius, -1), False, 0.0).end == met
    outside = corner(EAST, over, Offset(radius, -1), False, 0.0)
    assert outside.end == pytest.approx((10.0 + radius, -radius))
    assert [piece.end for piece in outside.generated] == [
        pytest.approx((10.0 + radius, radius)),
        pytest.approx((10.0, radius)),
    ]


@pytest.mark.parametrize("minimum", [0.0, 0.4])
def test_a_single_short_block_is_dropped_for_the_intersection(minimum: float) -> None:
    """Turn of 100 degrees with r = 1: B to C is 2 sin(50) (1 - cot(50)) long, along 50 degrees to the axes."""
    second = turned(EAST, -100.0)
    junction = corner(EAST, second, Offset(1.0, 1), False, minimum)
    length = 2.0 * math.sin(math.radians(50.0)) - 2.0 * math.cos(math.radians(50.0))
    if minimum:
        assert junction.generated == ()
        assert junction.end == pytest.approx((10.0 + math.tan(math.radians(50.0)), 1.0))
    else:
        (block,) = junction.generated
        assert block.length == pytest.approx(length)
        assert junction.end == pytest.approx((11.0, 1.0))


def test_a_block_is_dropped_only_if_both_components_are_below_the_minimum() -> None:
    second, length = turned(EAST, -100.0), 0.2465
    components = length * math.cos(math.radians(50.0)), length * math.sin(math.radians(50.0))
    kept = corner(EAST, second, Offset(1.0, 1), False, 0.5 * sum(components))
    assert len(kept.generated) == 1
    assert corner(EAST, second, Offset(1.0, 1), False, max(components) + 1e-3).generated == ()


def test_the_first_of_two_or_second_of_three_short_blocks_is_dropped() -> None:
    arc = element_from(10.0 + 0j, math.radians(-100.0), -60.0, 20.0)
    two = corner(EAST, arc, Offset(1.0, 1), False, 0.0)
    assert len(two.generated) == 2
    one = corner(EAST, arc, Offset(1.0, 1), False, 0.4)
    assert one.end == two.end
    assert [(piece.start, piece.end) for piece in one.generated] == [(two.end, two.generated[-1].end)]
    before = PathArc((0.0, 10.0), (10.0, 0.0), (10.0, 10.0), 1)  # ends along +u
    three = corner(before, arc, Offset(1.0, 1), False, 0.0).generated
    assert len(three) == 3
    kept = corner(before, arc, Offset(1.0, 1), False, 0.4).generated
    assert [(piece.start, piece.end) for piece in kept] == [
        (three[0].start, three[0].end),
        (three[0].end, three[2].end),
    ]


def test_a_reversal_keeps_its_block_however_large_the_minimum() -> None:
    junction = corner(EAST, PathSegment((10.0, 0.0), (0.0, 0.0)), LEFT, False, 100.0)
    assert len(junction.generated) == 1


def test_paths_that_do_not_meet_outside_are_joined_round_the_corner() -> None:
    # Line along +u, then a clockwise arc of radius 2.2 that starts 90 degrees to the left: with r = 2 to the right the
    # circle of the centre has radius 0.2 and stays clear of the line v = -2.
    arc = element_from(10.0 + 0j, math.radians(90.0), -80.0, 2.2)
    junction = corner(EAST, arc, RIGHT, False, 0.0)
    assert junction.end == pytest.approx((12.0, -2.0))
    assert [piece.end for piece in junction.generated] == [pytest.approx((12.0, 0.0))]
    round_it = corner(EAST, arc, RIGHT, True, 0.0)
    assert round_it.end == pytest.approx((10.0, -2.0))
    (piece,) = round_it.generated
    assert isinstance(piece, PathArc)
    assert swept(piece) == pytest.approx(0.5 * math.pi)


def test_paths_that_do_not_meet_inside_interfere() -> None:
    # Half-way round a circle of radius 2.2 to the left, entered across: the centre circle has radius 0.2.
    arc = element_from(10.0 + 0j, math.radians(120.0), 80.0, 2.2)
    with pytest.raises(CompensationFault, match="do not meet") as caught:
        corner(EAST, arc, LEFT, False, 0.0)
    assert (caught.value.name, caught.value.element) == ("interference", arc)


@pytest.mark.parametrize("radius", [1.0, 2.0])
def test_an_arc_not_larger_than_the_radius_is_too_small(radius: float) -> None:
    arc = PathArc((0.0, 0.0), (0.0, 2.0 * radius), (0.0, radius), 1)
    middle = (0.0, radius)
    for act in (
        lambda: compensated(arc, middle, middle, LEFT, detect=False),
        lambda: corner(EAST, element_from(10.0 + 0j, 1.0, 90.0, radius), LEFT, False, 0.0),
        lambda: feed_share(arc, LEFT, 0.1),
    ):
        with pytest.raises(CompensationFault, match="too small") as caught:
            act()
        assert caught.value.name == "circular-departure-too-small"
    assert compensated(arc, RIGHT.beside_start(arc), RIGHT.beside_end(arc), RIGHT)[0].length > arc.length


def test_an_arc_too_small_at_one_end_is_too_small() -> None:
    """Words are rounded: here the start is 2.004 from the centre, the end 1.997."""
    arc = PathArc((2.004, 0.0), (0.0, 1.997), (0.0, 0.0), 1)
    with pytest.raises(CompensationFault, match=r"radius 1\.9970 mm is too small"):
        compensated(arc, (0.004, 0.0), (0.0, -0.003), LEFT)


def test_a_step_lower_than_the_radius_runs_a_line_backwards() -> None:
    # Up a step of 1 between two inside corners of 90 degrees on the left, r = 2: v from 2 to -1 on a line to +v.
    step = lines((0.0, 0.0), (10.0, 0.0), (10.0, 3.0), (0.0, 3.0))
    start, end = corner(step[0], step[1], LEFT, False, 0.0).end, corner(step[1], step[2], LEFT, False, 0.0).end
    with pytest.raises(CompensationFault, match="too short") as caught:
        compensated(step[1], start, end, LEFT)
    assert "line of 3.0000" in str(caught.value)
    assert (caught.value.name, caught.value.element) == ("backwards-motion", step[1])
    assert compensated(step[1], start, end, LEFT, detect=False) == (PathSegment(start, end),)


def arc_between(first: float, last: float, rotation: int, radius: float = 10.0) -> PathArc:
    """Return an arc about the origin from one direction to another, degrees."""
    return PathArc(on(first, radius), on(last, radius), (0.0, 0.0), rotation)


def on(degrees: float, radius: float) -> Point:
    return radius * math.cos(math.radians(degrees)), radius * math.sin(math.radians(degrees))


@pytest.mark.parametrize("rotation", [1, -1])
@pytest.mark.parametrize(
    ("programmed", "trimmed_start", "trimmed_end"),
    [(30, 10, 15), (30, -10, -15), (200, 100, 90), (330, 160, 160), (330, -10, -10), (360, 0, 0), (360, 50, 60)],
)
def test_compensated_arcs_are_trimmed_or_lengthened(
    programmed: float, trimmed_start: float, trimmed_end: float, rotation: int
) -> None:
    arc = arc_between(20.0, 20.0 + rotation * programmed, rotation)
    radius = 10.0 - 2.0 * rotation
    start = on(20.0 + rotation * trimmed_start, radius)
    end = on(20.0 + rotation * (programmed - trimmed_end), radius)
    (run,) = compensated(arc, start, end, LEFT)
    assert isinstance(run, PathArc)
    assert (run.start, run.end, run.centre, run.rotation) == (start, end, arc.centre, rotation)
    assert math.degrees(run.angle) == pytest.approx(programmed - trimmed_start - trimmed_end)


@pytest.mark.parametrize("rotation", [1, -1])
@pytest.mark.parametrize(("programmed", "trimmed"), [(20, 15), (200, 110), (330, 170)])
def test_crossing_vectors_of_an_arc_are_refused_as_interference(
    programmed: float, trimmed: float, rotation: int
) -> None:
    arc = arc_between(0.0, rotation * programmed, rotation)
    radius = 10.0 - 2.0 * rotation
    start, end = on(rotation * trimmed, radius), on(rotation * (programmed - trimmed), radius)
    with pytest.raises(CompensationFault, match="too short") as caught:
        compensated(arc, start, end, LEFT)
    assert caught.value.name == "interference"
    (run,) = compensated(arc, start, end, LEFT, detect=False)
    assert isinstance(run, PathArc)
    assert (run.start, run.end, run.rotation) == (start, end, -rotation)
    assert math.degrees(swept(run)) == pytest.approx(2 * trimmed - programmed)


@pytest.mark.parametrize("rotation", [1, -1])
def test_a_full_circle_lengthened_at_its_ends_is_two_arcs(rotation: int) -> None:
    arc = arc_between(0.0, 0.0, rotation)
    radius = 10.0 - 2.0 * rotation
    runs = compensated(arc, on(-20.0 * rotation, radius), on(30.0 * rotation, radius), LEFT)
    assert len(runs) == 2
    assert runs[0].end == runs[1].start
    assert sum(run.length for run in runs) == pytest.approx(radius * math.radians(410.0))


@pytest.mark.parametrize(("radius", "left_over"), [(10.0, 0.0), (10.0, 1e-11), (10.0, -1e-11), (5000.0, 1e-8)])
def test_an_arc_trimmed_to_nothing_is_no_full_circle(radius: float, left_over: float) -> None:
    arc = arc_between(0.0, 40.0, 1, radius)
    start, end = on(20.0, radius - 2.0), on(20.0 + left_over, radius - 2.0)
    assert [run.length for run in compensated(arc, start, end, LEFT)] == [pytest.approx(0.0, abs=1e-6)]


def test_side_change_to_an_arc_ends_where_the_paths_cross() -> None:
    # Along v = 2 (G41), then the left half of a circle of radius 5 about (10, 5) with the centre inside (G42): with
    # r = 2 its path has radius 3 and touches v = 2 at (10, 2), which is on both.
    arc = PathArc((10.0, 0.0), (10.0, 10.0), (10.0, 5.0), -1)
    junction = side_change(EAST, arc, LEFT, RIGHT)
    assert junction.end == pytest.approx((10.0, 2.0))
    assert junction.generated == ()
    # With r = 1 on the arc its path has radius 4 and crosses v = 2 at u = 10 - sqrt(16 - 9).
    crossing = side_change(EAST, arc, LEFT, Offset(1.0, -1))
    assert crossing.end == pytest.approx((10.0 - math.sqrt(7.0), 2.0))
    assert crossing.generated == ()


def test_side_change_takes_the_nearest_of_two_crossings() -> None:
    # Along v = 2, then a full circle of radius sqrt(29) about (5, 2): that of the centre crosses it twice.
    circle = PathArc((10.0, 0.0), (10.0, 0.0), (5.0, 2.0), -1)
    for path in (EAST, PathSegment((10.0, 0.0), (0.0, 0.0))):
        first, second = (path, circle) if path is EAST else (circle, path)
        before, after = (LEFT, Offset(1.0, -1)) if path is EAST else (Offset(1.0, -1), RIGHT)
        junction = side_change(first, second, before, after)
        assert junction.end == pytest.approx((5.0 + math.sqrt(29.0) - 1.0, 2.0))
        assert junction.generated == ()


def test_side_change_to_an_arc_without_a_crossing_is_joined_straight() -> None:
    arc = PathArc((10.0, 0.0), (10.0, 10.0), (10.0, 5.0), 1)  # right half, centre outside it: below the line
    junction = side_change(EAST, arc, LEFT, RIGHT)
    assert junction.end == pytest.approx((10.0, 2.0))
    assert [piece.end for piece in junction.generated] == [pytest.approx((10.0, -2.0))]
