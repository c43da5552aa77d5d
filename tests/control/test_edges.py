"""Corner cases of compensation and interrupts, found by attacks on the control."""

from math import hypot

import pytest

from grind_env.control import Arc, Control, ControlError, Infeed, Interrupt, Line, Motion, Rapid, Source, execute, read
from grind_env.control.numbers import NumberFormat


def ends(text: str, **settings: object) -> list[tuple[int, tuple[float, ...]]]:
    """Return block and end of the motions of the part program."""
    return [
        (move.block, tuple(round(coordinate, 4) for coordinate in move.end))
        for move in execute(read(text), Control(**settings))
        if isinstance(move, Motion) and move.source in (Source.PROGRAM, Source.COMPENSATION)
    ]


R = {"radius": 2.0, "start": (0.0, 0.0, -10.0)}


def test_compensation_continues_into_an_m98_call_after_an_arc() -> None:
    text = (
        "N10 G17 G90 F100.\nN20 G41 G01 X0 Y0\nN30 X20.\nN40 G03 X30. Y10. R10.\nN50 M98 P7\nN60 G40 G01 X0. Y30.\n"
        "M30\nO7\nN1 G02 X40. Y20. R10.\nN2 G01 X60.\nM99"
    )
    assert ends(text, radius=2.0, start=(-10.0, 0.0, 0.0))[3] == (1, (40.0, 22.0, 0.0))


def test_g28_of_one_axis_removes_the_offset() -> None:
    text = "N10 G18 G91 F600. G41 G01 Z10.\nN30 Z20.\nN40 G28 Z5.\nN50 G40 X10.\nN60 X10.\nM30"
    assert ends(text, **R)[-1] == (60, (20.0, 0.0, 0.0))


def test_a_move_before_g28_of_the_third_axis_ends_at_right_angles() -> None:
    text = "N10 G18 G91 F600. G41 G01 Z10.\nN30 Z20.\nN40 G28 Y5.\nN50 X10.\nN60 Z10.\nN70 G40 X10.\nM30"
    got = ends(text, **R)
    assert got[1] == (30, (2.0, 0.0, 20.0)) and got[-1] == (70, (20.0, 0.0, 30.0))


def test_g28_after_a_type_1_interrupt_reaches_its_reference_point() -> None:
    text = "N10 G18 G91 F600. G01 Z10.\nN30 Z20.\nN40 G28 X20.\nN50 G01 Z5.\nM30\nO9\nG90 G01 X15. Z0\nM99"
    got = ends(
        text, start=(0.0, 0.0, -10.0), interrupts=(Interrupt(9, 1, True, 2.5),), reference_points=((50.0, 0, 0),) * 4
    )
    assert got[-1][1][0] == 50.0


def test_a_dress_compensated_in_another_plane_leaves_the_contour_unchanged() -> None:
    text = (
        "N10 G18 G90 F100. G41 G01 Z0 X0\nN20 G81 Y10. J0. E6000. P9\nN30 G91 G01 Z20.\nN35 X10.\nN40 X10.\n"
        "N45 Z10.\nN60 G40 X10.\nN70 G80\nM30\nO9\nG90\n{}\nM99"
    )
    a = ends(text.format("G17 G41 G01 X5. Y5. F100.\nX15.\nY20.\nG40 Y30."), operator_dress_at=(20.0,), **R)
    b = ends(text.format("G17 G01 X5. Y5. F100.\nX15.\nY20.\nG40 Y30."), operator_dress_at=(20.0,), **R)
    assert [(n, (x, z)) for n, (x, _, z) in a] == [(n, (x, z)) for n, (x, _, z) in b]


def test_an_arc_stays_circular_when_t_changes_the_sign_of_the_radius() -> None:
    text = (
        "N10 G18 G90 F100.\nN20 G41 G01 Z0 X0 T0101\nN30 Z20.\nN40 G03 Z30. X10. I10. T0202\nN50 G01 X30.\n"
        "N60 G40 X40.\nM30"
    )
    control = Control(radii={1: 2.0, 2: -2.0}, start=(0.0, 0.0, -10.0))
    (arc,) = (move for move in execute(read(text), control) if isinstance(move, Arc))
    a, b = (hypot(p[2] - arc.centre[2], p[0] - arc.centre[0]) for p in (arc.start, arc.end))
    assert abs(a - b) < 0.01


def test_an_arc_that_ends_at_its_centre_is_refused() -> None:
    with pytest.raises(ControlError):
        list(execute(read("G17 G90 G41 G01 X0 F100.\nX5.\nG02 X5.001 I.001\nG01 X10.\nM30"), Control(radius=1.0)))


def test_a_groove_after_a_type_1_interrupt_starts_at_the_tool() -> None:
    text = "N10 G18 G90 F600. G01 Z10.\nN30 Z20.\nN40 G77 X-10. I2. D0\nM30\nO9\nG01 X15. Z0\nM99"
    control = Control(start=(0.0, 0.0, -10.0), interrupts=(Interrupt(9, 1, True, 2.5),))
    moves = [event for event in execute(read(text), control) if isinstance(event, Motion)]
    groove = [move for move in moves if move.source is Source.CYCLE]
    # from the tool position after the interrupt down to X in steps of I, and out again
    assert groove[0].start == groove[-1].end == (15.0, 0.0, 0.0)
    depths = [move.end for move in groove if isinstance(move, Infeed)]
    assert depths == [(float(x), 0.0, 0.0) for x in (*range(13, -10, -2), -10)]


def test_a_corner_accounts_for_the_length_offset_of_the_next_block() -> None:
    text = "N10 G18 G90 F100.\nN20 G41 G01 Z0 X0 T0101\nN30 Z20.\nN40 X20. Z20. T0102\nN50 G01 Z40. X20.\nG40 Z50.\nM30"
    z = ends(text, radius=2.0, lengths={2: (0.0, 0.0, 5.0)}, start=(0.0, 0.0, -10.0))[1][1][2]
    assert z == pytest.approx(20 - 2 * 0.7808, abs=1e-3)  # tan of half the 75.96 degrees of the real path


def test_a_plane_change_under_compensation_is_refused_in_its_own_block() -> None:
    text = "N10 G17 G90 F100.\nN30 G41 G01 X-20.\nN40 X0.\nN50 G18\nN60 G01 X10. Z10.\nN70 G40 X20.\nM30"
    with pytest.raises(ControlError) as caught:
        list(execute(read(text), Control(radius=2.0, start=(-40.0, 0, 0))))
    assert caught.value.block == 50


def test_a_zero_move_after_a_type_1_interrupt_returns_to_its_point() -> None:
    text = "N10 G18 G90 F600. G01 Z10.\nN30 Z20.\nN35 Z20.\nN50 Z25.\nM30\nO9\nG01 X15. Z0\nM99"
    assert (35, (0.0, 0.0, 20.0)) in ends(text, start=(0.0, 0.0, -10.0), interrupts=(Interrupt(9, 1, False, 2.5),))


def test_an_interrupt_within_g28_leaves_the_next_end_unchanged() -> None:
    text = "N10 G18 G91 F600. G01 Z10.\nN40 G28 X20.\nN50 G01 Z5.\nM30\nO9\nG90 G01 X15. Z0\nM99"
    got = ends(text, start=(0.0, 0.0, -10.0), interrupts=(Interrupt(9, 1, True, 2.02),), rapid_feed=1000.0)
    assert got[-1] == (50, (0.0, 0.0, 5.0))


def test_i_and_k_in_the_exit_after_a_lapse_have_no_effect() -> None:
    got = ends("N10 G18 G90 F600. G41 G01 Z0 X0\nN30 Z20.\nN40 M3\nN41 M3\nN42 M3\nN50 G40 Z30. X10. I5. K5.\nM30", **R)
    # the last compensated move has already ended without a next move, so I and K choose no corner
    assert got[1:] == [(30, (2.0, 0.0, 20.0)), (50, (10.0, 0.0, 30.0))]


def test_g10_of_another_work_system_keeps_the_compensated_corner() -> None:
    got = ends("N10 G18 G90 F600. G41 G01 Z0. X0\nN30 Z20.\nN40 G10 L2 P5 X10.\nN60 X10.\nN70 G40 X20. Z20.\nM30", **R)
    assert got[1] == (30, (2.0, 0.0, 18.0))


@pytest.mark.parametrize(
    ("rest", "way"),
    [
        # beside its own direction +X, without a next motion
        ("M30", [(50, (2.0, 0.0, 18.0))]),
        # beside the next motion, +Z
        ("N60 Z40.\nN70 G40 X9.\nM30", [(50, (4.0, 0.0, 20.0)), (60, (4.0, 0.0, 40.0)), (70, (9.0, 0.0, 40.0))]),
    ],
)
def test_an_entry_to_the_wheel_position_is_offset(rest: str, way: list[tuple[int, tuple[float, ...]]]) -> None:
    text = ("N10 G18 G90 F600. G41 G01 Z0 X0\nN30 Z20.\nN40 M3\nN41 M3\nN42 M3\nN50 X2.\n") + rest
    for kind in "AB":
        assert ends(text, compensation_type=kind, **R)[2:] == way


def test_a_motion_after_a_very_long_one_begins_at_its_end() -> None:
    written = NumberFormat(zero_suppression="leading", metric=(9, 9))
    events = execute(read("S500 G95 F60;\n G01 Y46.6\nG28 Z-2.437\nM30"), Control(number_format=written))
    motions = [event for event in events if isinstance(event, Line | Rapid)]
    slow, following = motions[0], motions[1]
    assert slow.seconds > 1e15 and slow.begin + slow.seconds + 0.1 == slow.begin + slow.seconds
    assert following.start == slow.end and following.end != following.start
