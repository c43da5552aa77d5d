import pytest

from tests.control.harness import COMMON, cycles, ends, motions, plans, run, story, strokes

OFFSETS = {"G55": (100.0, 10.0, 1.0), "G59.3": (-5.0, 0.0, 0.0)}
REFERENCE = ((1.0, 2.0, 3.0), (10.0, 20.0, 30.0), (0.0, 0.0, 99.0), (7.0, 7.0, 7.0))


def test_work_systems_shift_absolute_words_only() -> None:
    text = "G55 G00 X1. Y2. Z3.\nG91 X1.\nG90 G59.3 X1.\nG54 X1."
    assert ends(text, work_offsets=OFFSETS) == [
        (101.0, 12.0, 4.0),
        (102.0, 12.0, 4.0),
        (-4.0, 12.0, 4.0),
        (1.0, 12.0, 4.0),
    ]


def test_the_external_offset_shifts_every_system() -> None:
    assert ends("G00 X1.\nG55 X1.", work_offsets=OFFSETS, external_offset=(0.5, 0.0, 0.0)) == [
        (1.5, 0.0, 0.0),
        (101.5, 0.0, 0.0),
    ]


def test_g10_l2_loads_a_system_without_motion() -> None:
    assert ends("G10 L2 P1 X5. Z-1.\nG00 X1. Z1.") == [(6.0, 0.0, 0.0)]
    assert ends("G10 L2 P9 X5.\nG00 X1.\nG59.3 X1.") == [(1.0, 0.0, 0.0), (6.0, 0.0, 0.0)]
    assert ends("G10 L2 P1 X5.\nG91 G10 L2 P1 X1.\nG90 G00 X1.") == [(7.0, 0.0, 0.0)]
    assert ends("G70 G10 L2 P1 X1.\nG00 X1.")[0][0] == pytest.approx(50.8)


@pytest.mark.parametrize(
    ("mode", "word", "x"), [("G07", "", 5.0), ("G08", "", 2.5), ("G07", "O2", 2.5), ("G08", "O1", 5.0)]
)
def test_g10_reads_x_as_radius_or_diameter(mode: str, word: str, x: float) -> None:
    assert ends(f"{mode} G10 L2 P1 {word} X5.\nG07 G00 X0.")[0][0] == x


def test_g92_gives_the_present_position_new_coordinates() -> None:
    assert ends("G00 X10. Z5.\nG92 X0 Z1.\nX1. Z1.\nG91 X1.\nG92.1\nG90 X1.") == [
        (10.0, 0.0, 5.0),
        (11.0, 0.0, 5.0),
        (12.0, 0.0, 5.0),
        (1.0, 0.0, 5.0),
    ]
    assert ends("G55\nG00 X0\nG92 X1.\nX2.\nG54 X2.", work_offsets=OFFSETS) == [
        (100.0, 0.0, 0.0),
        (101.0, 0.0, 0.0),
        (1.0, 0.0, 0.0),
    ]


def test_g28_and_g30_pass_the_intermediate_point_and_g29_returns_by_it() -> None:
    start = "G00 X50. Y50. Z50.\n"
    assert ends(start + "G28 X40. Z40.", reference_points=REFERENCE)[1:] == [(40.0, 50.0, 40.0), (1.0, 50.0, 3.0)]
    assert ends(start + "G91 G30 Y-1.", reference_points=REFERENCE)[1:] == [(50.0, 49.0, 50.0), (50.0, 20.0, 50.0)]
    assert ends(start + "G30 P3 Z40.", reference_points=REFERENCE)[-1] == (50.0, 50.0, 99.0)
    assert ends(start + "G28 X40.\nG29 X60.", reference_points=REFERENCE)[1:] == [
        (40.0, 50.0, 50.0),
        (1.0, 50.0, 50.0),
        (40.0, 50.0, 50.0),
        (60.0, 50.0, 50.0),
    ]


def test_cycles_run_in_the_work_system_and_remember_its_coordinates() -> None:
    block = "G82 X230. I-30. Y-.02 J-.01 F60. E12000.\nG80\n"
    events = cycles(f"G55 G00 X-30. Y0\n{block}G54 G00 Y0\nG82 J-.01\nM30", work_offsets=OFFSETS)
    first, second = (start.plan for start in plans(events))
    assert (first.primary, first.secondary, first.plunge_start, first.depth_target) == (330.0, 70.0, 10.0, 9.98)
    assert (second.primary, second.secondary, second.plunge_start, second.depth_target) == (230.0, -30.0, 0.0, -0.02)
    moved = story(events).split()
    assert moved[:3] == ["X330", "y9.99", "X70"]


def test_reversal_points_move_in_the_work_system() -> None:
    text = COMMON + "G55\nG81 X230. I-30. E12000.\nG91 G01 Y1. I-5. F60.\nG90 Y2. X200. F60.\n"
    events = run(text, work_offsets={"G55": (100.0, 0.0, 0.0)}, start=(70.0, 0.0, 0.0), strokes=9)
    assert {330.0, 65.0, 300.0} == {stroke.end[0] for stroke in strokes(events)} - {70.0}


def test_diameter_mode_halves_x_but_not_i() -> None:
    assert ends("G08 G00 X50. Z-10.") == [(25.0, 0.0, -10.0)]
    assert ends("G08 G91 G00 X5.\nG07 X5.") == [(2.5, 0.0, 0.0), (7.5, 0.0, 0.0)]
    arc = motions("G08 G03 X20. Z10. I10. K0 F100.")[0]
    assert arc.end == (10.0, 0.0, 10.0) and arc.centre == (10.0, 0.0, 0.0)
