"""Program interrupts of types 1 and 2 (lathe manual 29-6, 29-7) and the operator's panel (PD-16)."""

import itertools
import math

import pytest

from grind_env.control import (
    Arc,
    Control,
    ControlError,
    CycleStart,
    Dwell,
    Hold,
    Interrupt,
    InterruptEnd,
    InterruptStart,
    Line,
    Motion,
    Stroke,
    execute,
    read,
)
from tests.control.harness import COMMON, DRESS, PARKED, motions, run, story

MAIN = "G00 X0\nG01 X10. F600.\nZ10.\nX20.\nM30\n"
AWAY = "O7\nG00 Y5.\nG01 Y6. F60.\nM99\n"
STILL = "O7\nM08\nM99\n"


def steps(main: str, program: str, *interrupts: Interrupt) -> list[tuple[float, float, float, str]]:
    moves = motions(main + program, interrupts=interrupts, acceleration=1e6)
    return [(*(round(c, 3) for c in move.end), move.source.value) for move in moves]


def test_a_type_1_interrupt_without_motion_changes_nothing() -> None:
    plain = steps(MAIN, STILL)
    for immediate in (True, False):
        found = steps(MAIN, STILL, Interrupt(7, 1, immediate, at=0.5))
        assert [step for step in found if step[0] != 5.0] == plain


def test_a_type_1_interrupt_with_motion_goes_straight_to_the_next_end() -> None:
    found = steps(MAIN, AWAY, Interrupt(7, 1, True, at=0.5))
    assert found == [
        (5.0, 0.0, 0.0, "program"),
        (5.0, 5.0, 0.0, "interrupt"),
        (5.0, 6.0, 0.0, "interrupt"),
        (10.0, 0.0, 10.0, "program"),
        (20.0, 0.0, 10.0, "program"),
    ]


def test_a_delayed_type_1_interrupt_waits_for_the_end_of_the_block() -> None:
    found = steps(MAIN, AWAY, Interrupt(7, 1, False, at=0.5))
    assert found[:3] == [(10.0, 0.0, 0.0, "program"), (10.0, 5.0, 0.0, "interrupt"), (10.0, 6.0, 0.0, "interrupt")]
    assert found[3:] == [(10.0, 0.0, 10.0, "program"), (20.0, 0.0, 10.0, "program")]


def test_a_panel_request_does_not_replace_an_immediate_interrupt() -> None:
    control, programs = Control(interrupts=(Interrupt(7, at=0.5),)), []
    for event in execute(read(MAIN + STILL + STILL.replace("O7", "O8")), control):
        if isinstance(event, Line) and event.end[0] < 10.0:
            control.interrupt(8)
        if isinstance(event, InterruptStart):
            programs.append(event.program)
    assert programs == [7, 8]


@pytest.mark.parametrize("immediate", [True, False])
def test_increments_after_a_type_1_interrupt_count_from_the_programmed_point(immediate: bool) -> None:
    main = "G00 X0\nG01 G91 X10. F600.\nZ10.\nX10.\nM30\n"
    found = steps(main, AWAY, Interrupt(7, 1, immediate, at=0.5))
    assert [step[:3] for step in found[-2:]] == [(10.0, 0.0, 10.0), (20.0, 0.0, 10.0)]


def test_motions_after_an_interrupt_that_leads_away_are_continuous() -> None:
    text = "F100.\nG42 G01 Z35. T0101\nG01 Z-49.\nO9001\nG00 Z33.\nM99"
    settings = {"radii": {1: 5.0}, "compensation_type": "B", "interrupts": (Interrupt(9001, 1, True, at=19.0),)}
    moves = motions(text, **settings)
    for before, after in itertools.pairwise(moves):
        assert after.start == pytest.approx(before.end)


def test_a_type_2_interrupt_comes_back_and_finishes_the_block() -> None:
    found = steps(MAIN, AWAY, Interrupt(7, 2, True, at=0.5))
    assert found == [
        *steps(MAIN, AWAY, Interrupt(7, 1, True, at=0.5))[:3],
        (5.0, 5.0, 0.0, "retrace"),
        (5.0, 0.0, 0.0, "retrace"),
        (10.0, 0.0, 0.0, "program"),
        (10.0, 0.0, 10.0, "program"),
        (20.0, 0.0, 10.0, "program"),
    ]


def test_an_interrupted_arc_goes_on_about_its_centre() -> None:
    text = "G17 G03 X20. Y0 I10. F600.\nM30\n"
    arcs = [
        m
        for m in motions(text + AWAY.replace("Y", "Z"), interrupts=(Interrupt(7, 2, True, at=1.0),))
        if isinstance(m, Arc)
    ]
    assert len(arcs) == 2
    assert arcs[0].centre == arcs[1].centre == (10.0, 0.0, 0.0)
    assert arcs[0].end == pytest.approx(arcs[1].start)
    assert arcs[0].end == pytest.approx((10 - 10 * math.cos(1), -10 * math.sin(1), 0), abs=0.1)
    assert arcs[1].end == (20.0, 0.0, 0.0)


def test_the_axes_brake_before_an_immediate_interrupt() -> None:
    line = motions(MAIN + STILL, interrupts=(Interrupt(7, 2, True, at=0.5),), acceleration=100.0)[0]
    assert isinstance(line, Line)
    speed, acceleration = 10.0, 100.0
    travelled = speed * (0.5 - 0.5 * speed / acceleration)
    assert line.end[0] == pytest.approx(travelled + 0.5 * speed**2 / acceleration)
    assert line.finish == pytest.approx(0.5 + speed / acceleration)


def test_modes_come_back_after_an_interrupt() -> None:
    program = "O7\nG91 G70 F1.\nM99\n"
    assert steps(MAIN, program, Interrupt(7, 1, False, at=0.1)) == steps(MAIN, program)


def test_interrupts_wait_for_the_reversal_point() -> None:
    text = COMMON + "G82 X230. I-30. Y-.02 J-.01 E12000. F60.\nM30\n" + AWAY
    settings = {"start": PARKED, "interrupts": (Interrupt(7, 2, True, at=0.3),)}
    events = run(text, **settings)
    kinds = [type(e).__name__ for e in events if isinstance(e, Stroke | InterruptStart | InterruptEnd)]
    assert kinds == ["Stroke", "InterruptStart", "InterruptEnd", "Stroke", "Stroke"]
    assert story(events) == "X230 y-0.01 X-30 y-0.02 X230"


def test_an_interrupt_is_latched_while_another_runs() -> None:
    found = steps(MAIN, AWAY, Interrupt(7, 2, True, at=0.5), Interrupt(7, 2, True, at=0.6))
    assert [step[3] for step in found].count("interrupt") == 4


# ------------------------------------------------------------------------------------------------ the panel


def test_a_dress_request_without_a_dress_program_gives_a_message() -> None:
    control = Control(strokes=2)
    control.request_dress()
    events = list(execute(read("G81 Z40. E2400.\n"), control))
    assert [e.text for e in events if type(e).__name__ == "Message"] == ["no dress program"]


def test_a_simultaneous_dress_and_interrupt_are_both_served_at_the_reversal() -> None:
    control = Control(start=(-20.0, 0.0, 0.0), strokes=3)
    events = []
    for event in execute(read(COMMON + "G81 X230. I-30. E12000. P9100\n" + DRESS + "\n" + AWAY), control):
        events.append(event)
        if isinstance(event, CycleStart):
            control.request_dress()
            control.interrupt(7)
    assert story(events) == "X230 operator X-30 X230"
    assert [type(e).__name__ for e in events].count("InterruptEnd") == 1
    finishes = [event.finish for event in events if isinstance(event, Motion)]
    assert finishes == sorted(finishes)


def test_the_override_acts_on_f_and_e_but_not_on_rapids() -> None:
    text = "G01 X10. F600.\nG00 X0\nG81 X60. E6000.\n"
    normal, half = (seconds(text, percent) for percent in (100.0, 50.0))
    assert half[0] == pytest.approx(2 * normal[0]) and half[1] == normal[1] and half[2] == pytest.approx(2 * normal[2])


def seconds(text: str, percent: float) -> list[float]:
    control = Control(acceleration=1e9, strokes=1)
    control.override(percent)
    return [event.seconds for event in execute(read(text), control) if isinstance(event, Motion)]


def test_override_0_and_feedhold_stop_before_the_next_motion() -> None:
    for stop, go, cause in (
        (lambda c: c.feedhold(), lambda c: c.resume(), "feedhold"),
        (lambda c: c.override(0.0), lambda c: c.override(100.0), "override"),
    ):
        control = Control()
        stream = execute(read("G01 F100. X1.\nX2.\nX3."), control)
        assert next(stream).end[0] == 1.0
        stop(control)
        assert isinstance(held := next(stream), Hold) and held.cause == cause
        go(control)
        assert next(stream).end[0] == 2.0
        stop(control)
        assert isinstance(next(stream), Hold)
        with pytest.raises(ControlError, match="on hold"):
            next(stream)


def test_single_block_stops_after_every_block_and_leg() -> None:
    control = Control(start=PARKED)
    control.single_block()
    text = COMMON + "G00 X-20.\nG82.1 X230. I-30. Y-.01 J-.01 E12000. F60. P9100\nG80\nM30" + DRESS
    kinds = [type(e).__name__ for e in execute(read(text), control) if isinstance(e, Motion | Hold)]
    modes, move, dress_out = ["Hold"], ["Rapid", "Hold"], ["Rapid", "Hold", "Line", "Hold", "Hold"]
    dress_in = ["Line", "Hold", "Rapid", "Hold"]
    cycle, stop = ["Stroke", "Pick", "Stroke", "Hold"], ["Hold", "Hold"]
    assert kinds == modes + move + dress_out + dress_in + cycle + stop


def test_single_block_stops_after_every_groove() -> None:
    control = Control()
    control.single_block()
    text = "G00 X25. Z-10.\nG77 X20. Z-22. I2. K5. D0 F1.\nM30"
    holds = [e for e in execute(read(text), control) if isinstance(e, Hold)]
    assert len(holds) == 3 + 3


def test_an_interrupt_waits_for_the_end_of_a_dwell() -> None:
    moves = motions("G04 P2.\nG00 X1.\nM30\n" + AWAY, interrupts=(Interrupt(7, 2, True, at=1.0),))
    assert isinstance(moves[0], Dwell) and moves[0].seconds == 2.0
    assert moves[1].source.value == "interrupt"
