import pytest

from grind_env.control import DressEnd, DressStart, Line
from tests.control.harness import DRESS, cycle_ends, cycles, picks, plans, run, story, strokes

G82 = "G82 X230. I-30. Y-.1 J-.01 L4 F6. E12000. P9100 D2\n"


@pytest.mark.parametrize(("feed", "seconds"), [("12000", 1.40), ("24000", 0.85), ("6000", 2.65)])
def test_8_1_g81_strokes_take_the_calculated_time(feed: str, seconds: float) -> None:
    events = cycles(f"G81 X230. I-30. E{feed}.\n", strokes=3)
    assert story(events) == "X230 X-30 X230"
    assert [stroke.seconds for stroke in strokes(events)] == pytest.approx([seconds] * 3)
    assert [stroke.number for stroke in strokes(events)] == [None] * 3


@pytest.mark.parametrize(("feed", "ramp"), [("6000", 0.05), ("12000", 0.1), ("24000", 0.2)])
def test_8_2_a_pick_begins_with_the_deceleration(feed: str, ramp: float) -> None:
    events = cycles(f"G82 X230. I-30. Y-.02 J-.01 F6. E{feed}.\n")
    for stroke, pick in zip(strokes(events), picks(events), strict=False):
        assert pick.begin == pytest.approx(stroke.finish - ramp)
        assert pick.seconds == pytest.approx(0.1, abs=1e-3)


def test_8_3_an_omitted_i_is_the_start_point_of_an_incremental_g81() -> None:
    events = run("G71 G94 G19 G00 X10.\nG91 G81 X200. E8000.\nG04 P1.\nG91 G81 X150. I-5.\n", strokes=3)
    first, second = (start.plan for start in plans(events))
    assert (first.primary, first.secondary) == (210.0, 10.0)
    assert (second.primary, second.secondary) == (160.0, 5.0)
    assert story(events) == "X210 X10 X160 X5 X160"


def test_8_4_the_far_end_changes_on_the_fly() -> None:
    events = cycles("G81 X230. I-30. E12000.\nG01 Y-0.02 I-60. F50.\n", strokes=4)
    assert story(events) == "X230 X-60 X230 X-60"
    line = next(event for event in events if isinstance(event, Line))
    assert line.end[1:] == (-0.02, 0.0)
    assert line.seconds == pytest.approx(0.02 / (50 / 60) + (50 / 60) / 2000)
    assert [abs(stroke.end[0] - stroke.start[0]) for stroke in strokes(events)] == [260.0, 290.0, 290.0, 290.0]
    assert strokes(events)[1].seconds == pytest.approx(290 / 200 + 0.1)


def test_8_5_g82_spreads_two_dresses_over_its_plunges() -> None:
    events = cycles(G82 + "M30")
    assert story(events) == (
        "X230 y-0.01 X-30 y-0.02 X230 y-0.03 X-30 y-0.04 auto X230 y-0.05 X-30 y-0.06 X230 y-0.07 auto "
        "X-30 y-0.08 X230 y-0.09 X-30 y-0.1 X230 X-30 X230 X-30 X230"
    )
    assert [stroke.number for stroke in strokes(events)] == list(range(1, 16))
    assert (cycle_ends(events)[0].strokes, cycle_ends(events)[0].dresses) == (15, 2)


def test_8_5_all_axes_stand_while_dressing_and_the_next_stroke_waits() -> None:
    events = cycles(G82 + "M30")
    for position, event in enumerate(events):
        if isinstance(event, DressStart):
            before = [*strokes(events[:position]), *picks(events[:position])]
            assert event.time >= max(motion.finish for motion in before)
        if isinstance(event, DressEnd):
            following = strokes(events[position:])[0]
            assert following.begin == event.time
            assert following.start == picks(events[:position])[-1].end


def test_8_6_d_is_not_remembered() -> None:
    events = cycles(G82 + "G82 Y-.12 J-.01\nG82 Y-.14 J-.01 D1\nM30")
    after = story(events[events.index(cycle_ends(events)[0]) :])
    assert after == "X-30 X230 y-0.11 X-30 y-0.12 X230 X-30 X230 y-0.13 auto X-30 y-0.14 X230"
    second = plans(events)[1].plan
    assert (second.primary, second.secondary, second.feed, second.pick_feed) == (230.0, -30.0, 12000.0, 6.0)
    assert (second.program, second.spark_out, second.dresses) == (9100, 0, 0)


def test_8_7_unequal_picks_alternate_and_the_last_one_is_clipped() -> None:
    events = cycles("G82 X230. I-30. E12000. F6. Y-.045 J-.02 Q-.01 D0\nM30")
    assert story(events) == "X230 y-0.02 X-30 y-0.03 X230 y-0.045 X-30"
    assert picks(events)[-1].end[1] == -0.045


def test_8_8_pre_dress_and_auto_dress_add_up() -> None:
    block = "X230. I-30. Y-.03 J-.01 L2 F6. E12000. P9100"
    assert story(cycles(f"G82.1 {block} D5\nM30")) == (
        "pre X230 y-0.01 auto auto X-30 y-0.02 auto auto X230 y-0.03 auto X-30 X230 X-30"
    )
    assert story(cycles(f"G82.1 {block}\nM30")).count("pre") == 1
    assert "auto" not in story(cycles(f"G82.1 {block}\nM30"))
    without = story(cycles(f"G82 {block}\nM30"))
    assert "auto" not in without and "pre" not in without


def test_8_9_e_falls_back_to_the_last_cycle_and_then_to_f() -> None:
    events = cycles("G01 Y1. F300.\nG01 Y0.\nG81 X230. I-30.\nG82 Y-.02 J-.01 E15000. F6.\nG82 Y-.04 J-.01 F12.\nM30")
    assert [(start.plan.feed, start.plan.pick_feed) for start in plans(events)] == [
        (300.0, 0.0),
        (15000.0, 6.0),
        (15000.0, 12.0),
    ]
    assert {pick.feed for pick in picks(events)} == {6.0, 12.0}


def test_8_10_g83_plunges_and_crosses_over_in_turn() -> None:
    events = cycles("G83 X230. I-30. Y-.04 J-.02 Z40. K10. L1 F60. E12000. P9100 D1\nM30")
    assert story(events) == (
        "X230 y-0.02 auto X-30 z10 X230 z20 X-30 z30 X230 z40 X-30 y-0.04 "
        "X230 z30 X-30 z20 X230 z10 X-30 z0 X230 "
        "X-30 z10 X230 z20 X-30 z30 X230 z40 X-30"
    )
    end = cycle_ends(events)[0]
    assert (end.strokes, end.dresses) == (16, 1)
    assert strokes(events)[-1].end == (-30.0, -0.04, 40.0)


def test_8_11_integrands_take_the_last_mode() -> None:
    events = run("G71 G94 G19\nG00 X5. Y3.\nG82 G90 X230. I-10. G91 Y-.1 J-.01 E6000. F6.\nM30" + DRESS)
    plan = plans(events)[0].plan
    assert (plan.primary, plan.secondary) == (230.0, -5.0)
    assert plan.depth_target == pytest.approx(2.9)
