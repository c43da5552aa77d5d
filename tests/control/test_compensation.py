"""Radius compensation of whole programs: the worked examples E1 to E11, and the rules of entry, lapse and exit."""

from pathlib import Path

import pytest

from grind_env.control import Arc, Control, ControlError, Line, Motion, Source, execute, read, read_file
from tests.control.harness import motions, path, refusal

Point = tuple[float, float]


def close(found: list[Point], expected: list[Point]) -> bool:
    assert found == [pytest.approx(point, abs=1e-4) for point in expected]
    return True


def generated(moves: list[Motion]) -> list[Motion]:
    return [move for move in moves if move.source is Source.COMPENSATION]


E1 = "N10 G00 Z0 X0; N20 G41 G01 Z10 X10 T0101 F100; N30 Z30; N40 X20; N50 Z50; N60 G40 Z60 X30;"


def test_e1_a_contour_is_offset_at_inside_and_outside_corners() -> None:
    assert close(path(E1), [(10, 12), (28, 12), (28, 22), (50, 22), (60, 30)])


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("G42 G01 Z5 X5 F100; Z20", (7 - 2, 3)),
        ("G42 G01 Z5 X5 F100; X20", (7, 5)),
        ("G00 Z3.; G42 G01 Z5 X5 F100; X20", (7, 5)),
        ("G41 G01 Z10 X10 F100; G91 Z8.66 X5", (9, 11.7321)),
    ],
)
def test_e2_the_entry_depends_on_the_next_move_only(text: str, entry: Point) -> None:
    assert entry in [pytest.approx(point, abs=1e-4) for point in path(text)]


def test_e3_an_entry_may_lead_onto_an_arc() -> None:
    text = "G42 G01 Z20 X10 F100; G03 Z30 X20 K0 I10; G40 G01 Z40 X40"
    moves = motions(text, radius=2.0)
    assert (moves[0].end[2], moves[0].end[0]) == pytest.approx((20, 8))
    assert isinstance(moves[1], Arc) and moves[1].centre == pytest.approx((20, 0, 20))
    assert moves[1].end == pytest.approx((20, 0, 32))


@pytest.mark.parametrize(("code", "leaves_at"), [("G41", 28.0), ("G42", 32.0)])
def test_e4_an_exit_after_an_arc_must_be_straight(code: str, leaves_at: float) -> None:
    text = f"{code} G01 Z20 X10 F100; G03 Z30 X20 K0 I10; G40 G01 Z40 X40"
    assert close(path(text)[1:], [(leaves_at, 20), (40, 40)])
    error = refusal(text.replace("G40 G01 Z40 X40", "G40 G02 Z40 X40 R30"), radius=2.0)
    assert (error.name, error.column) == ("block-format", text.index("G40") + 5)


E5 = "N1 G00 Z-5 X5; {}N2 G42 G01 Z0 F100; N3 Z20; N4 X12; N5 Z8 X-3; N6 G40 Z0 X-10;"


def test_e5_a_sharp_outside_corner_gets_a_line_or_with_g39_1_an_arc() -> None:
    straight = motions(E5.format(""), radius=1.0)
    found = [(move.end[2], move.end[0]) for move in straight[1:]]
    assert close(found, [(0, 4), (21, 4), (21, 13), (19.8438, 13.4056), (7.2191, -2.3753), (0, -10)])
    (block,) = generated(straight)
    assert isinstance(block, Line) and block.block == 4
    round_ = motions(E5.format("G39.1;"), radius=1.0)
    (arc,) = generated(round_)
    assert isinstance(arc, Arc) and arc.rotation == 1 and arc.centre == pytest.approx((12, 0, 20))
    assert (arc.start[2], arc.start[0]) == pytest.approx((21, 12))
    assert (arc.end[2], arc.end[0]) == pytest.approx((19.2191, 12.6247), abs=1e-4)


@pytest.mark.parametrize("kind", ["A", "B"])
@pytest.mark.parametrize(
    ("words", "end"),
    [
        ("", (10, 2)),
        ("I-5", (12, 2)),
        ("I5", (8, 2)),
        ("K1 I-1", (10.8284, 2)),
        ("K-1 I-1", (12, 2)),
        ("K5", (8, 2)),
        ("K-5", (12, 2)),
    ],
)
def test_e6_a_vector_in_the_exit_block_shifts_the_last_point(words: str, end: Point, kind: str) -> None:
    text = f"G41 G01 Z.001 F100; Z10; G40 Z15 X10 {words}"
    assert close(path(text, compensation_type=kind)[1:], [end, (15, 10)])


def test_e7_too_many_blocks_without_motion_end_the_lookahead() -> None:
    text = "G41 G01 Z.001 F100; Z10; {}X10; Z20"
    assert close(path(text.format(""))[1:3], [(8, 2), (8, 12)])
    assert close(path(text.format("M08; M09; "))[1:3], [(8, 2), (8, 12)])
    assert close(path(text.format("M08; M09; M08; "))[1:3], [(10, 2), (10, 12)])
    assert close(path(text.format("M08; "), non_motion_blocks=0)[1:3], [(10, 2), (10, 12)])


def test_e8_a_change_of_side_generates_a_block() -> None:
    moves = motions("G41 G01 Z.001 F100; Z10; G42 Z20; Z30", radius=2.0)
    assert close([(move.end[2], move.end[0]) for move in moves[1:]], [(10, 2), (10, -2), (20, -2), (30, -2)])
    assert [move.block for move in generated(moves)] == [1]


@pytest.mark.parametrize(
    ("after", "points"),
    [
        ("X-10; X-20", [(12, 2), (12, 0)]),
        ("Z0 X-10; X-20", [(10, 2), (12, 2), (12.8284, 0), (11.4142, -1.4142)]),
        ("Z20 X10; X20", [(8.5858, 1.4142)]),
    ],
)
def test_e9_a_type_b_entry_runs_round_an_outside_corner(after: str, points: list[Point]) -> None:
    moves = path(f"G41 G01 Z10 F100; {after}", compensation_type="B")
    assert close(moves[: len(points)], points)


@pytest.mark.parametrize(
    ("to", "points"),
    [
        ("Z10 X-8", [(12, 2), (10, -8)]),
        ("Z4 X-6", [(12, 2), (12.8284, 0), (11.4142, -1.4142), (4, -6)]),
        ("Z20 X8", [(10, 2), (20, 8)]),
    ],
)
def test_e9_a_type_b_exit_runs_round_an_outside_corner(to: str, points: list[Point]) -> None:
    text = f"G41 G01 Z.001 F100; Z10; G40 {to}"
    assert close(path(text, compensation_type="B")[1:], points)
    assert close(path(text)[1:], [(10, 2), points[-1]])


@pytest.mark.parametrize(
    ("code", "corner", "radius", "feed"), [("G41", (9.4641, 1), 4.0, 80.0), ("G42", (10.4721, -1), 6.0, 100.0)]
)
def test_e10_only_an_inside_arc_is_slowed(code: str, corner: Point, radius: float, feed: float) -> None:
    text = f"{code} G01 Z.001 F100; Z10; G03 Z6 X8 K-4 I3; G40 G01 Z-10 X8"
    moves = motions(text, radius=1.0)
    assert (moves[1].end[2], moves[1].end[0]) == pytest.approx(corner, abs=1e-4)
    arc = next(move for move in moves if isinstance(move, Arc) and move.source is Source.PROGRAM)
    assert arc.centre == pytest.approx((3, 0, 6), abs=1e-6)
    assert ((arc.start[2] - 6) ** 2 + (arc.start[0] - 3) ** 2) ** 0.5 == pytest.approx(radius)
    assert arc.feed == pytest.approx(feed)


def test_e11_the_feed_on_inside_arcs_has_a_floor() -> None:
    text = "G41 G01 Z10 F100; G03 Z20 X10 K0 I10; G40 G01 X30"
    assert next(move for move in motions(text, radius=9.8) if isinstance(move, Arc)).feed == pytest.approx(10.0)
    steep = motions(text, radius=9.8, minimum_feed_reduction=0.01)
    assert next(move for move in steep if isinstance(move, Arc)).feed == pytest.approx(2.0)


CONTOUR = "G41 G01 Z10 F100; Z30; {}X20; Z50; G40 X30"


def test_a_negative_radius_swaps_the_sides() -> None:
    assert path(E1, radius=-2.0) == path(E1.replace("G41", "G42"))


def test_t_selects_radius_and_length() -> None:
    text = "G41 G01 Z10 X10 {} F100; Z30; X20; Z50; G40 Z60 X30"
    radii = {1: 2.0, 33: 5.0}
    assert path(text.format("T0101"), radius=0.0, radii=radii) == path(text.format(""))
    assert path(text.format("T1"), radius=0.0, radii=radii) == path(text.format(""))
    assert path(text.format("T3300"), radius=0.0, radii=radii) == path(text.format(""), radius=5.0)
    lifted = path(text.format("T0107"), radii=radii, lengths={7: (100.0, 0.0, 1.0)})
    assert lifted == [pytest.approx((z + 1.0, x + 100.0)) for z, x in path(text.format(""))]
    whole = path(text.format("T0107"), radii=radii, lengths={7: (100.0, 0.0, 1.0)}, entire_wheel=True)
    assert whole == [pytest.approx((z + 1.0, x)) for z, x in path(text.format(""))]


def test_t0000_continues_with_radius_zero() -> None:
    assert path("T0000; " + E1.replace("T0101", "")) == path("G00 Z0 X0; G01 Z10 X10 F1; Z30; X20; Z50; Z60 X30")
    assert close(path(CONTOUR.format("T0000 "))[1:], [(28, 2), (30, 20), (50, 20), (50, 30)])


def test_a_new_radius_is_reached_at_the_end_of_its_move() -> None:
    found = path(CONTOUR.format("T05 "), radii={5: 3.0})
    assert close(found, [(10, 2), (28, 2), (27, 23), (50, 23), (50, 30)])
    arc = "G41 G01 Z10 F100; T05 G03 Z20 X10 K0 I10; G01 X30; G40 Z0"
    moves = motions(arc, radius=2.0, radii={5: 3.0})
    assert [type(move) for move in moves[:4]] == [Line, Arc, Line, Line]
    assert close([(m.end[2], m.end[0]) for m in moves[1:3]], [(18, 10), (17, 10)])


def test_blocks_without_motion_before_the_entry_do_not_count() -> None:
    text = E1.replace("G41 G01 Z10 X10 T0101 F100;", "G41 T0101; M08; M09; M08; M09; G01 Z10 X10 F100;")
    assert path(text) == path(E1)


def test_a_skipped_block_counts_as_one_without_motion() -> None:
    text = "G41 G01 Z.001 F100; Z10;/ X99;/ Z99;/ Y5; X10; Z20"
    assert close(path(text, block_delete=True)[1:3], [(10, 2), (10, 12)])


@pytest.mark.parametrize(
    "exit_", ["G40 Z60 X30", "G40; Z60 X30", "G40; M08; Z60 X30"], ids=["same block", "alone", "with M08 between"]
)
def test_g40_may_stand_before_the_exit_move(exit_: str) -> None:
    assert path(E1.replace("G40 Z60 X30", exit_)) == path(E1)


def test_the_control_ends_compensation_by_itself_without_an_exit_move() -> None:
    moves = motions(E1.replace("G40 Z60 X30", "G40; M08; M09; M08; Z60 X30"), radius=2.0)
    assert close([(m.end[2], m.end[0]) for m in moves[-3:]], [(50, 22), (50, 20), (60, 30)])
    assert [move.end for move in generated(moves)] == [pytest.approx((20, 0, 50))]


def test_compensation_at_the_program_end_adds_no_move() -> None:
    assert close(path("G41 G01 Z10 F100; Z30; M30"), [(10, 2), (30, 2)])


@pytest.mark.parametrize("change", ["G55", "G92 Z40 X10", "G10 L2 P1 Z5"])
def test_a_new_coordinate_system_ends_the_compensation_before_it(change: str) -> None:
    found = path(f"G41 G01 Z10 F100; Z30; X10; {change}; G91 Z10; X5; Z20")
    assert close(found, [(10, 2), (30, 2), (30, 10), (38, 10), (38, 17), (60, 17)])


def test_g28_is_an_exit_move() -> None:
    found = path("G41 G01 Z10 F100; Z30; G28 Z40 X10; G01 Z30 X5; Z20; Z10", reference_points=((50.0, 0.0, 60.0),) * 4)
    assert close(found, [(10, 2), (30, 2), (40, 10), (60, 50), (30, 3), (20, 3), (10, 3)])


@pytest.mark.parametrize("plane", ["G17", "G18", "G19"])
def test_the_third_axis_follows_along_the_line(plane: str) -> None:
    first, second, third = {"G17": "XYZ", "G18": "ZXY", "G19": "YZX"}[plane]
    text = f"{plane} G41 G01 {first}10 F100; {first}30 {third}5; {second}20; {third}9; {first}50; G40 {second}30"
    ends = [move.end for move in motions(text, radius=2.0)]
    order = ["XYZ".index(axis) for axis in (first, second, third)]
    assert [tuple(end[axis] for axis in order) for end in ends] == [
        pytest.approx(point) for point in [(10, 2, 0), (28, 2, 5), (28, 22, 5), (28, 22, 9), (50, 22, 9), (50, 30, 9)]
    ]


def test_a_fault_in_another_block_names_its_line_column_or_file(tmp_path: Path) -> None:
    short = "the line of 1.0000 mm in {} is too short for a radius of 2.0000 mm"
    blocks = refusal("G41 G01 Z10 F100; Z30; X1; Z0; G40 X9", radius=2.0)
    assert (blocks.column, blocks.message.partition(" in its corners")[0]) == (28, short.format("column 24"))
    (tmp_path / "main.nc").write_text("G41 G01 Z10 F100\nM98 P5\nZ0\nG40 X9\nM30")
    (tmp_path / "O5.nc").write_text("O5\nZ30\nX1\nM99")
    with pytest.raises(ControlError) as caught:
        list(execute(read_file(tmp_path / "main.nc"), Control(radius=2.0)))
    error = caught.value
    assert (error.file, error.line) == ("main.nc", 3)
    assert error.message.partition(" in its corners")[0] == short.format("line 3 of O5.nc")


def test_m800_switches_error_detection_off_and_m801_on() -> None:
    text = "G41 G01 Z10 F100\n{}Z30\nX1\nZ0\nG40 X9"
    assert refusal(text.format("M801 "), radius=2.0).name == "backwards-motion"
    assert len(path(text.format("M800 "))) == 5
    small = "G41 M800 G01 Z10 F100\nG03 Z11 X1 I1 K0\nG01 X9"
    assert refusal(small, radius=2.0).name == "circular-departure-too-small"


def test_a_strict_entry_must_move_both_axes() -> None:
    assert refusal("G41 G01 Z10 F100; Z20", radius=2.0, strict_entry_both_axes=True).name == "block-format"
    assert path("G41 G01 Z10 X5 F100; Z20", strict_entry_both_axes=True)


def test_a_dress_cancels_the_compensation_which_enters_again_after_it() -> None:
    text = "G81 Y30. J0 E60000. P9\nG41 G01 Z10. F100.\nZ30.\nZ50.\nX20.\nG40 Z60.\nM30\nO9\nG00 X50.\nM99"
    moves = [m for m in motions(text, radius=2.0, operator_dress_at=(8.0,)) if m.source is not Source.CYCLE]
    found = [(m.end[2], m.end[0], m.source.value) for m in moves]
    assert (50.0, 2.0, "program") not in found
    before = found.index((30.0, 2.0, "program"))
    assert found[before + 1 : before + 4] == [
        (30.0, 50.0, "dress"),
        (30.0, 2.0, "retrace"),
        (pytest.approx(48.0), pytest.approx(0.0), "program"),
    ]


def test_compensation_follows_changes_of_the_wheel_radius_in_entry_33() -> None:
    execution = execute(read("T3300 G41 G01 Z10 F100; Z30; Z50; G40 X30"), Control(radii={33: 100.0}))
    ends = []
    for event in execution:
        if isinstance(event, Motion):
            ends.append(event.end[0])
            execution.set_wheel_radius(99.0)
    assert ends == [100.0, 99.0, 99.0, 30.0]
