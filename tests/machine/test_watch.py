import re

from grind_env.control import Control
from grind_env.machine.job import WheelStart
from tests.machine.harness import CYCLE, HEAD, job, run


def test_a_slow_pick_warns_and_names_the_feed_that_would_do() -> None:
    slow = HEAD + CYCLE.replace("F60.", "F.5") + "M30\n"
    record = run(slow, job())
    assert len(record.warnings) == 1
    assert "test.nc:3" in record.warnings[0]
    found = re.search(r"; F(\d+) would do", record.warnings[0])
    assert found is not None
    assert run(slow.replace("F.5", f"F{found[1]}."), job()).warnings == ()


def test_the_feed_that_is_named_is_the_least_one() -> None:
    text = HEAD + CYCLE.replace("J-.01", "J-.5").replace("Y-.05", "Y-2.") + "M30\n"
    out_of_reach = job(surface=-10.0)
    found = re.search(r"; F(\d+) would do", run(text.replace("F60.", "F1."), out_of_reach).warnings[0])
    assert found is not None
    enough = int(found[1])
    assert run(text.replace("F60.", f"F{enough}."), out_of_reach).warnings == ()
    assert run(text.replace("F60.", f"F{enough - 1}."), out_of_reach).warnings != ()


def test_a_pick_that_no_feed_finishes_in_time() -> None:
    control = Control(acceleration=10.0, reversal_dwell=0.0)
    text = HEAD + "G82 X30. I-30. Y-500. J-250. F6000. E60000. P9100\nM30\n"
    warnings = run(text, job(length=20.0, surface=-600.0), control=control).warnings
    assert any("no F would do" in warning for warning in warnings)


def test_a_pick_before_a_dress_is_waited_for() -> None:
    text = HEAD + "G82 X230. I-30. Y-.01 J-.01 F.3 E12000. P9100 D1\nM30\n"
    assert run(text, job()).warnings == ()


def test_a_stroke_that_turns_over_the_part_warns_once() -> None:
    record = run(HEAD + CYCLE.replace("X230.", "X150.") + "M30\n", job())
    assert len(record.warnings) == 1
    assert "X150" in record.warnings[0] and "X200" in record.warnings[0]


def test_a_wheel_below_its_least_diameter_warns_once() -> None:
    text = HEAD + CYCLE.replace("P9100", "P9100 D2") + "M30\n"
    record = run(text, job(wheel_start=WheelStart(diameter=220.01)))
    assert sum("least diameter, 220 mm" in warning for warning in record.warnings) == 1


def test_a_cut_outside_the_limits_of_the_model_warns_once() -> None:
    record = run(HEAD + re.sub(r"E[0-9]+", "E2000", CYCLE) + "M30\n", job())
    assert record.warnings == (
        "test.nc:3: a stroke cuts at E2000 mm/min; the process model holds from 3000 to 40000 mm/min",
    )
    (warning,) = run(HEAD + CYCLE.replace("Y-.05 J-.01", "Y-.25 J-.25") + "M30\n", job()).warnings
    assert re.fullmatch(r"test\.nc:3: a stroke cuts 0\.\d\d mm deep; the process model holds up to 0\.1 mm", warning)
