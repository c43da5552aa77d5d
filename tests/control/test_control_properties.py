import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import Arc, Control, ControlError, Hold, Motion, Pick, Stroke, execute, read
from grind_env.control.check import check
from grind_env.control.profile import ramp_time, travelled
from grind_env.control.rules import dresses_due, motion_time
from tests.control.harness import COMMON, DRESS, cycle_ends, cycles, picks, run, strokes
from tests.examples import examples

microns = st.integers(1, 60)
alphabet = st.sampled_from(list("GXYZIJKFEPDLMNOQRST0123456789.-+ ();/%\n[#é\x00")) | st.characters()


@given(st.lists(microns, min_size=1, max_size=60), st.integers(0, 999))
def test_exactly_d_dresses_for_any_picks(sizes: list[int], executions: int) -> None:
    total = sum(sizes) / 1000.0
    depth, run_so_far = 0.0, 0.0
    for position, size in enumerate(sizes):
        depth = total if position == len(sizes) - 1 else depth + size / 1000.0
        due = dresses_due(depth, total, float(executions))
        assert due >= run_so_far
        run_so_far = due
    assert run_so_far == executions


@examples(60)
@given(
    depth=st.integers(0, 300),
    primary=microns,
    secondary=st.integers(0, 60),
    spark_out=st.integers(0, 5),
    dresses=st.integers(0, 7),
    up=st.booleans(),
)
def test_random_g82(depth: int, primary: int, secondary: int, spark_out: int, dresses: int, up: bool) -> None:
    way = "" if up else "-"
    target = f"{way}{depth / 1000:.3f}"
    events = cycles(
        f"G82 X230. I-30. Y{target} J{way}{primary / 1000:.3f} Q{way}{secondary / 1000:.3f} "
        f"L{spark_out} D{dresses} F60. E12000. P9100\nM30"
    )
    left, visits = depth, 0
    while left > 0:
        left -= secondary if visits % 2 else primary
        visits += 1
    assert len(strokes(events)) == visits + 1 + spark_out
    assert cycle_ends(events)[0].dresses == (dresses if depth else 0)
    if depth:
        assert picks(events)[-1].end[1] == float(target)


@examples(40)
@given(
    width=st.integers(0, 50),
    primary=st.integers(1, 20),
    depth=st.integers(1, 50),
    pick=st.integers(5, 60),
    spark_out=st.integers(0, 3),
)
def test_random_g83(width: int, primary: int, depth: int, pick: int, spark_out: int) -> None:
    events = cycles(
        f"G83 X230. I-30. Y-{depth / 1000:.3f} J-{pick / 1000:.3f} Z{width}. K{primary}. L{spark_out} "
        "F6000. E12000.\nM30"
    )
    plunges = math.ceil(depth / pick)
    traverses = plunges - 1 + 1 + spark_out
    assert len(strokes(events)) == 1 + traverses * (math.ceil(width / primary) + 1)
    assert strokes(events)[-1].end[2] == (width if traverses % 2 else 0.0)
    crossed = sum(event.kind == "cross" for event in picks(events))
    assert crossed == traverses * math.ceil(width / primary)


@examples(300)
@given(st.text(alphabet, max_size=60))
def test_no_text_raises_anything_but_a_control_error(text: str) -> None:
    try:
        report = check(read(text), BRIEF)
    except ControlError as error:
        assert error.line is not None
    else:
        assert all(isinstance(error, ControlError) for error in report.errors)


VOCABULARY = """
    G00 G01 G02 G03 G04 G17 G18 G19 G70 G71 G80 G81 G82 G83 G81.1 G90 G91 G94 G95 X1. X-30. Y-.02 Y5. Z2. Z10.
    I3. J-.01 K5. K-1. R4. Q-.01 L2 F60. E6000. S100. P9100 D2 M98 M99 M30 M902
"""
WORDS = st.sampled_from(VOCABULARY.split())
BRIEF = Control(block_budget=500)


@examples(300)
@given(st.lists(st.lists(WORDS, min_size=1, max_size=6), max_size=6))
def test_no_program_raises_anything_but_a_control_error(blocks: list[list[str]]) -> None:
    text = COMMON + "\n".join(" ".join(block) for block in blocks)
    check(read(text + DRESS), BRIEF)
    check(read(COMMON + "G81 X230. I-30. E12000. P9100\n" + text + DRESS), BRIEF)


shift = st.integers(-999, 999)
PATTERN = """G17 G71 G90
G01 X{3} Y{1} F300.
G03 X{3} Y{4} R5.
G02 X{3} Y{4} I2. J1.
G91 G01 X1.5
G90 G19 G82 X{3} I{0} Y{5} J-.01 E6000. F60.
G80
G00 X{0}
"""


@examples(50)
@given(shift, shift, shift)
def test_translated_coordinates_translate_the_motions(dx: int, dy: int, dz: int) -> None:
    def moves(x: int, y: int, z: int) -> list[Motion]:
        numbers = (x, y, z, x + 20, y + 8, y + 7.95)
        text = PATTERN.format(*(f"{number:.3f}" for number in numbers))
        start = (float(x), float(y), float(z))
        return [event for event in run(text, start=start) if isinstance(event, Motion)]

    here, there = moves(0, 0, 0), moves(dx, dy, dz)
    for a, b in zip(here, there, strict=True):
        assert type(a) is type(b)
        assert b.end == pytest.approx((a.end[0] + dx, a.end[1] + dy, a.end[2] + dz), abs=1e-9)
        assert b.seconds == pytest.approx(a.seconds, abs=1e-9)
        if isinstance(a, Arc) and isinstance(b, Arc):
            assert b.centre[0] == pytest.approx(a.centre[0] + dx, abs=1e-9)


@given(st.floats(0.01, 500), st.floats(0.1, 1000), st.floats(10, 5000), st.floats(0, 1))
def test_the_profile_is_symmetric_and_ends_with_the_motion_time(
    length: float, speed: float, acceleration: float, part: float
) -> None:
    total = motion_time(length, speed, acceleration)
    assert travelled(total, length, speed, acceleration) == length
    first = travelled(part * total, length, speed, acceleration)
    last = travelled((1 - part) * total, length, speed, acceleration)
    assert math.isclose(first + last, length, rel_tol=1e-6, abs_tol=1e-9)
    assert ramp_time(length, speed, acceleration) <= total / 2 * (1 + 1e-12)


def test_events_come_in_the_order_in_which_they_end() -> None:
    events = list(execute(read(COMMON + "G81 X230. I-30. E12000.\n" + "G91 G01 Z3. F500.\nG04 P.3\n" * 9)))
    finishes = [event.finish for event in events if isinstance(event, Motion) and not isinstance(event, Pick)]
    assert finishes == sorted(finishes) and len(finishes) == 18 + 10


@pytest.mark.parametrize(("feed", "last"), [(600.0, "stroke"), (0.1, "pick")])
def test_a_pick_follows_its_stroke_whichever_ends_last(feed: float, last: str) -> None:
    events = cycles(f"G82 X230. I-30. Y-.02 J-.01 F{feed} E12000.\nM30", reversal_dwell=0.15)
    first, pick, second, *_ = (event for event in events if isinstance(event, Motion))
    assert (type(first), type(pick), type(second)) == (Stroke, Pick, Stroke)
    ends = {"stroke": (pick.finish, first.finish, second.finish), "pick": (first.finish, second.finish, pick.finish)}
    assert list(ends[last]) == sorted(ends[last])


def test_a_hold_before_a_stroke_beside_a_motion_has_the_time_of_that_stroke() -> None:
    control, events = Control(), []
    for event in execute(read(COMMON + "G81 X230. I-30. E12000.\nG01 Z9. F60.\nM30"), control):
        events.append(event)
        if isinstance(event, Hold):
            control.resume()
        elif isinstance(event, Stroke) and len(events) == 2:
            control.feedhold()
    hold = next(k for k, event in enumerate(events) if isinstance(event, Hold))
    assert events[hold].time == events[hold - 1].finish == events[hold + 1].begin > 0.0
