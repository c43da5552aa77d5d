import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import Arc, Control, Hold, Motion, Pick, Stroke, execute, read
from grind_env.control.cycle_formulas import motion_time
from grind_env.control.motion_profile import ramp_time, travelled
from tests.control.harness import COMMON, cycles, run
from tests.examples import examples

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
def test_the_motion_profile_is_symmetric_and_lasts_the_motion_time(
    length: float, speed: float, acceleration: float, part: float
) -> None:
    total = motion_time(length, speed, acceleration)
    assert travelled(total, length, speed, acceleration) == length
    first = travelled(part * total, length, speed, acceleration)
    last = travelled((1 - part) * total, length, speed, acceleration)
    assert math.isclose(first + last, length, rel_tol=1e-6, abs_tol=1e-9)
    assert ramp_time(length, speed, acceleration) <= total / 2 * (1 + 1e-12)


@pytest.mark.parametrize(("feed", "last"), [(600.0, "stroke"), (0.1, "pick")])
def test_a_pick_follows_its_stroke_whichever_ends_last(feed: float, last: str) -> None:
    events = cycles(f"G82 X230. I-30. Y-.02 J-.01 F{feed} E12000.\nM30", reversal_dwell=0.15)
    first, pick, second, *_ = (event for event in events if isinstance(event, Motion))
    assert (type(first), type(pick), type(second)) == (Stroke, Pick, Stroke)
    ends = {"stroke": (pick.finish, first.finish, second.finish), "pick": (first.finish, second.finish, pick.finish)}
    assert list(ends[last]) == sorted(ends[last])


def test_a_hold_before_a_stroke_has_the_begin_time_of_the_stroke() -> None:
    control, events = Control(), []
    for event in execute(read(COMMON + "G81 X230. I-30. E12000.\nG01 Z9. F60.\nM30"), control):
        events.append(event)
        if isinstance(event, Hold):
            control.resume()
        elif isinstance(event, Stroke) and len(events) == 2:
            control.feedhold()
    hold = next(k for k, event in enumerate(events) if isinstance(event, Hold))
    assert events[hold].time == events[hold - 1].finish == events[hold + 1].begin > 0.0
