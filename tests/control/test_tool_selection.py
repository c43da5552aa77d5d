import math

import pytest

from grind_env.control import Line, Message, Source, Spindle
from tests.control.harness import COMMON, DRESS, PARKED, motions, picks, refusal, run


def speeds(events: list) -> list[float]:
    return [event.speed for event in events if isinstance(event, Spindle)]


def test_g97_programs_revolutions_and_g96_the_surface_speed() -> None:
    assert speeds(run("S1500\nS1500\nG96 S1800", radii={33: 150.0})) == [
        1500.0,
        pytest.approx(1800.0 * 318.31 / 300.0, rel=1e-5),
    ]
    assert speeds(run("G70 G96 S6000", radii={33: 152.4})) == [pytest.approx(6000.0 * 3.8197 / 12.0, rel=1e-4)]
    assert refusal("G96 S1800").name == "no-wheel-radius"


def test_feed_per_revolution_follows_the_surface_speed() -> None:
    line = motions("G96 S1000 G95 G01 X1. F.01", radii={33: 100.0})[0]
    assert isinstance(line, Line)
    assert line.feed == pytest.approx(0.01 * 1000.0 * 1000.0 / (2.0 * math.pi * 100.0))


def test_a_dress_makes_the_wheel_smaller_and_faster() -> None:
    text = COMMON + "G96 S1800\nG82 X230. I-30. Y-.02 J-.01 E12000. F60. P9100 D2\nM30" + DRESS
    settings = {"start": PARKED, "radii": {33: 150.0}, "dress_amount": 0.02, "minimum_radius": 149.97}
    events = run(text, **settings)
    rpm = [1800.0 * 1000.0 / (2.0 * math.pi * radius) for radius in (150.0, 149.98, 149.96)]
    assert speeds(events) == [pytest.approx(speed) for speed in rpm]
    assert [e.text for e in events if isinstance(e, Message)] == ["the wheel radius is below its minimum"]


def test_later_infeeds_follow_the_smaller_wheel() -> None:
    cycle = "G82 X230. I-30. Y-.03 J-.01 E12000. F60. P9100 D1\nG80\nG01 Y-.03 F60.\nM30"
    events = run(COMMON + cycle + DRESS, start=PARKED, dress_amount=0.02, radii={33: 150.0})
    depths = [pick.end[1] for pick in picks(events)]
    assert depths == pytest.approx([-0.01, -0.02, -0.05])
    assert not [move for move in events if isinstance(move, Line) and move.source is Source.PROGRAM]
