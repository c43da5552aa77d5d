"""F and E: the speed along the path, how long it holds and its limits (12-53, 12-54, 12-60)."""

import pytest

from grind_env.control import Control, Line, Motion, execute, read
from tests.control.harness import cycles, motions, plans, run, strokes


def test_f_is_the_speed_along_the_path() -> None:
    # 100 mm/min on a ZX line at 45 degrees is 70.7 mm/min on each axis: 7.07 mm in 6 s
    (line,) = motions("G01 X7.071 Z7.071 F100.", acceleration=1e9)
    assert line.seconds == pytest.approx(6.0, rel=1e-4)
    (along,) = motions("G01 X10. F100.", acceleration=1e9)
    assert along.seconds == pytest.approx(6.0, rel=1e-4)


def test_an_f_in_a_g00_block_is_remembered() -> None:
    rapid, line = motions("G00 X10. F60.\nG01 X20.", rapid_feed=6000.0, acceleration=1e9)
    assert rapid.seconds == pytest.approx(0.1, rel=1e-4)
    assert isinstance(line, Line) and line.feed == 60.0


def test_e_and_the_pick_feed_are_clamped_to_the_maximum() -> None:
    (stroke,) = strokes(cycles("G81 X230. E9000.\n", strokes=1, maximum_feed=600.0))
    assert stroke.feed == 600.0
    assert plans(run("G19 G82 X9. Y-1. J-1. E700. F700.\nM30", maximum_feed=600.0))[0].plan.pick_feed == 600.0


@pytest.mark.parametrize("mode", ["G94 F600.", "S300 G95 F2."])
def test_the_override_acts_in_both_feed_modes(mode: str) -> None:
    seconds = []
    for percent in (100.0, 25.0):
        control = Control(acceleration=1e9)
        control.override(percent)
        moves = [event for event in execute(read(f"{mode} G01 X10."), control) if isinstance(event, Motion)]
        seconds.append(moves[0].seconds)
    assert seconds == pytest.approx([1.0, 4.0])


def test_no_override_passes_the_maximum_feed() -> None:
    control = Control(acceleration=1e9, maximum_feed=600.0)
    control.override(200.0)
    moves = [event for event in execute(read("G01 X10. F400."), control) if isinstance(event, Motion)]
    assert moves[0].seconds == pytest.approx(1.0)


def test_feed_per_revolution_is_clamped_to_the_maximum() -> None:
    line = motions("S1000 G95 G01 X10. F2.", maximum_feed=600.0)[0]
    assert isinstance(line, Line) and line.feed == 600.0
