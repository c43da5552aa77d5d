from itertools import islice, pairwise

import pytest

from grind_env.control import CycleStart, Line, Motion, execute, read
from tests.control.harness import cycle_ends, cycles, picks, plans, run, story, strokes


def test_g80_finishes_the_stroke_and_the_next_block_waits() -> None:
    events = cycles("G81 X230. I-30. E12000.\nG04 P2.\nG80\nG00 Z5.\nM30")
    assert story(events) == "X230 X-30"
    rapid = [event for event in events if isinstance(event, Motion)][-1]
    assert rapid.begin == pytest.approx(2.8)
    assert rapid.end == (-30.0, 0.0, 5.0)
    assert cycle_ends(events)[0].strokes == 2


@pytest.mark.parametrize("end", ["M30", "M02", "G80\nM30"])
def test_reciprocation_at_a_reversal_point_stops_at_once(end: str) -> None:
    assert story(cycles(f"G81 X230. I-30. E12000.\n{end}")) == ""
    assert story(cycles(f"G82 X230. I-30. Y-.01 J-.01 F6. E12000.\n{end}")) == "X230 y-0.01 X-30"


def test_m30_finishes_the_stroke_in_progress() -> None:
    assert story(cycles("G81 X230. I-40. E12000.\nM30")) == "X230"
    assert story(cycles("G81 X230. I-30. E12000.\nG04 P1.5\nM30")) == "X230 X-30"


def test_the_stroke_limit_at_the_text_end_counts_earlier_strokes() -> None:
    assert len(strokes(cycles("G81 X230. I-30. E12000.\nG04 P4.\n"))) == 10
    assert len(strokes(cycles("G81 X230. I-30. E12000.\nG04 P4.\n", strokes=2))) == 3
    assert story(cycles("G82 X230. I-30. Y-.01 J-.01 F6. E12000.\n")) == "X230 y-0.01 X-30"


def test_words_of_the_table_axis_only_move_its_reversal_points() -> None:
    events = cycles("G81 X230. I-30. E12000.\nG00 X100. Z1.\nM01\nG91 I-10. X50. E6000.\n", strokes=4)
    assert story(events) == "X100 X-40 X20 X-40"
    assert [stroke.feed for stroke in strokes(events)] == [12000.0, 6000.0, 6000.0, 6000.0]


def test_a_new_f_does_not_change_the_e_of_running_strokes() -> None:
    events = cycles("G01 Z1. F300.\nG81 X230. I-30.\nG01 Z2. F600.\n", strokes=2)
    assert [stroke.feed for stroke in strokes(events)] == [300.0, 300.0]


def test_the_middle_of_a_stroke_includes_a_motion_in_progress() -> None:
    events = cycles("G81 X230. I-30. E12000.\nG01 Z100. F6000.\n", strokes=1)
    (stroke,) = strokes(events)
    line = next(event for event in events if isinstance(event, Line))
    assert stroke.middle[0] == 100.0
    cruise = 0.05 / 2  # s lost by the ramp from rest to 100 mm/s at 2000 mm/s2
    assert stroke.middle[2] == pytest.approx(100.0 * (0.5 * stroke.seconds - cruise))
    assert line.finish < stroke.finish and stroke.end == (230.0, 0.0, 100.0)


def test_the_end_of_a_motion_includes_the_table_position() -> None:
    events = cycles("G81 X230. I-30. E12000.\nG04 P.7\n", strokes=1)
    dwell = next(event for event in events if isinstance(event, Motion))
    assert dwell.end[0] == pytest.approx(100.0)


def test_a_stroke_spans_several_blocks() -> None:
    events = cycles("G81 X230. I-30. E2600.\n" + "G91 G01 Z1. F600.\n" * 20, strokes=1)
    first = strokes(events)[0]
    lines = [event for event in events if isinstance(event, Line)]
    done = sum(line.finish <= first.begin + first.seconds / 2 for line in lines)
    assert done <= first.middle[2] <= done + 1
    assert all(a.finish == b.begin for a, b in pairwise(lines))


def test_the_middle_of_a_stroke_includes_a_slow_pick() -> None:
    events = cycles("G82 X230. I-30. Y-.04 J-.02 F1. E12000.\nM30")
    assert strokes(events)[0].middle == (100.0, 0.0, 0.0)
    second, pick = strokes(events)[1], picks(events)[0]
    assert second.start[1] == second.end[1] == -0.02
    elapsed = second.begin + second.seconds / 2 - pick.begin
    assert second.middle[1] == pytest.approx(-elapsed / 60, abs=1e-4)
    assert picks(events)[1].begin == max(pick.finish, second.finish - 0.1)
    assert cycle_ends(events)[0].time == max(picks(events)[1].finish, strokes(events)[-1].finish)


def test_the_reversal_dwell_is_part_of_the_stroke() -> None:
    made = strokes(cycles("G81 X230. I-30. E12000.\n", strokes=3, reversal_dwell=0.15))
    assert [stroke.seconds for stroke in made] == pytest.approx([1.55] * 3)
    events = cycles("G82 X230. I-30. Y-.02 J-.01 F6. E12000.\nM30", reversal_dwell=0.15)
    assert picks(events)[0].begin == pytest.approx(strokes(events)[0].finish - 0.25)


def test_a_cycle_at_the_primary_point_starts_with_a_stroke_without_length() -> None:
    events = cycles("G82 X-30. I230. Y-.01 J-.01 F6. E12000.\nM30")
    assert story(events) == "X-30 y-0.01 X230"
    assert strokes(events)[0].seconds == 0.0


def test_g82_takes_its_roles_from_the_plane() -> None:
    for plane, block, roles in [
        ("G17", "Z9. X-1. I-1.", (2, 0)),
        ("G18", "Y9. Z-1. K-1.", (1, 2)),
        ("G19", "X9. Y-1. J-1.", (0, 1)),
    ]:
        (start,) = plans(run(f"{plane} G82 {block} F6. E600.\nM30"))
        assert (start.plan.axis, start.plan.plunge_axis) == roles
    (start,) = plans(run("G17 G83 Z9. X-1. I-1. Y5. J1. F6. E600.\nM30"))
    assert start.plan.cross_axis == 1


def test_axis_words_in_arcs_and_dwells_do_not_change_the_strokes() -> None:
    events = cycles("G81 X230. I-30. E12000.\nG02 Y1. Z1. R1. F600.\nG04 X.1\nE6000. G04 P.1\n", strokes=2)
    assert story(events) == "X230 X-30"
    assert [stroke.feed for stroke in strokes(events)] == [12000.0, 12000.0]


def test_m99_restarts_and_forgets_the_cycle_parameters() -> None:
    stream = execute(read("G81 X9. E600.\nG80\nG81 I-5.\nG80\nG00 X0\nM99"))
    starts = islice((event for event in stream if isinstance(event, CycleStart)), 4)
    assert [start.plan.secondary for start in starts] == [0.0, -5.0, 0.0, -5.0]


def test_dwells_that_add_up_to_two_strokes_end_at_the_reversal_point() -> None:
    assert story(cycles("G81 X230. I-30. E12000.\n" + "G04 P.1\n" * 28 + "G80\nM30")) == "X230 X-30"
    assert story(cycles("G81 X230. I-30. E12000.\n" + "G04 P.7\n" * 4 + "M30")) == "X230 X-30"


def test_slow_picks_wait_for_each_other() -> None:
    # picks of 2 s begin at 1.3, 3.3 and 5.3 s; the fourth stroke, from 4.2 s on, is half-way at 4.9 s
    events = cycles("G82 X230. I-30. Y-.06 J-.02 F.6 E12000.\nM30")
    assert [pick.begin for pick in picks(events)] == pytest.approx([1.3, 3.3, 5.3], abs=1e-3)
    assert strokes(events)[3].middle[1] == pytest.approx(-0.02 - 0.01 * (4.9 - 3.3), abs=1e-4)
