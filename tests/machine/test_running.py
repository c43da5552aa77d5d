"""Wheel and coolant turn, flow and stop as the words of a program say."""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import grind_env
from grind_env.control import Spindle, Switch, read
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.machine.grind import grind
from grind_env.machine.job import Diamond, Job
from grind_env.machine.job.job_file import load_job
from grind_env.machine.part.spindle_coolant import Running, RunningWarnings
from grind_env.machine.record import GrindingRecord
from tests.machine.harness import CATALOGUE, CYCLE, DRESS, HEAD, LONG_AFTER, TIMELESS, job, run, told_stepped

EXAMPLES = Path(grind_env.__file__).parent / "examples"

BY_PROGRAM = {"spindle": "by program", "coolant": "by program"}
AGAIN = "G82 Y-.08 J-.01\n"


def programmed(**changes: Any) -> Job:
    """A job in which the words of the program count."""
    return job(stock=0.08, setup={**BY_PROGRAM, **changes})


def by_hand(**changes: Any) -> Job:
    """A job in which they do not."""
    return job(stock=0.08, setup=changes)


def program(words: str, between: str = "", dress: str = DRESS) -> str:
    return f"{words}\n{HEAD}{CYCLE.replace('P9100', 'P9100 D1')}{between}\n{AGAIN}M30\n{dress}"


def ground(text: str, job: Job, **settings: Any) -> GrindingRecord:
    return grind(read(text, "test.nc"), job, control=replace(job.control, **settings))


@pytest.mark.parametrize(
    ("words", "setup"),
    [
        ("S1910 M03 M08", {}),
        ("S1910 M03 M07", {}),
        ("S1500 M03 M08", {"wheel_speed": math.pi * 300.0 * 1500.0 / 60_000.0}),
        ("G96 S1500 M03 M08", {"wheel_speed": 25.0, "constant_surface_speed": True}),
        ("S1910 M03", {"fluid": CATALOGUE.fluid("dry")}),
        ("S1910 M03 M08 M09", {"fluid": CATALOGUE.fluid("dry")}),
    ],
)
def test_the_process_runs_with_what_was_programmed(words: str, setup: dict[str, Any]) -> None:
    found, asked = ground(program(words), programmed()), ground(program("(BY HAND)"), by_hand(**setup))
    assert found.strokes.tobytes() == asked.strokes.tobytes()
    assert found.dresses.tobytes() == asked.dresses.tobytes()
    assert bool(found.warnings) == bool(setup)


@pytest.mark.parametrize(
    ("between", "setup"), [("S1500", {"wheel_speed": math.pi * 7.5}), ("M09", {"fluid": CATALOGUE.fluid("dry")})]
)
def test_words_act_from_where_they_stand_on(between: str, setup: dict[str, Any]) -> None:
    found = ground(program("S1910 M03 M08", between), programmed())
    before = ground(program("S1910 M03 M08"), programmed())
    first = found.strokes["line"] == found.strokes["line"][0]
    assert 0 < first.sum() < first.size
    assert found.strokes[first].tobytes() == before.strokes[first].tobytes()
    assert not np.array_equal(found.strokes["T"][~first], before.strokes["T"][~first])
    (warning,) = found.warnings
    assert warning.startswith(f"test.nc:{found.strokes['line'][-1]}: ")


def test_a_wheel_turned_the_other_way_is_told_once() -> None:
    found, usual = ground(program("S1910 M04 M08"), programmed()), ground(program("S1910 M03 M08"), programmed())
    assert found.strokes.tobytes() == usual.strokes.tobytes()
    (warning,) = found.warnings
    assert warning.startswith("test.nc:4: M04 turns the wheel the other way than M03")
    (warning,) = ground(program("S1910 M03 M08", "M04"), programmed()).warnings
    assert warning.startswith(f"test.nc:{found.strokes['line'][-1]}: M04")
    assert ground(program("S1910 M04 M08 M03"), programmed()).warnings == ()
    assert ground(program("S1910 M04"), by_hand()).warnings == ()


@pytest.mark.parametrize("words", ["S1910 M03 M08", "S1500 M03", "G96 S1800 M03 M08"])
@pytest.mark.parametrize("between", ["", "M09", "S1800 M08"])
def test_whole_cycles_run_with_the_same_as_their_strokes(words: str, between: str) -> None:
    text = program(words, between)
    found, stepped = ground(text, programmed()), ground(text, programmed(), operator_dress_at=LONG_AFTER)
    assert found.warnings == told_stepped(stepped)
    for name in found.strokes.dtype.names or ():
        np.testing.assert_allclose(found.strokes[name], stepped.strokes[name], 1e-9, 1e-12, err_msg=name)


@given(speed=st.floats(5.0, 35.0))
def test_the_speed_of_the_job_rounded_to_a_whole_s_stands_for_it(speed: float) -> None:
    own = programmed(wheel_speed=speed)
    running = Running(own)
    running.set_speed(Spindle(0.0, round(60_000.0 * speed / (math.pi * 300.0))))
    running.switch(Switch(0.0, turning=True, coolant=True))
    assert running.setup is own.setup and running.fault is None
    assert list(RunningWarnings().of(running, 300.0)) == []


@pytest.mark.parametrize("words", ["S1450 M03 M08", "S1507 M03 M08", "G96 S1680 M03 M08"])
def test_what_is_told_of_the_speed_mends_it(words: str) -> None:
    own = programmed()
    (warning,) = ground(program(words), own).warnings
    found = re.search(
        r"write S1910( under G97)?, or say wheel_speed = ([.\d]+)( and constant_surface_speed = true)? in", warning
    )
    assert found is not None
    under, speed, constant = found.groups()
    assert bool(under) == bool(constant) == ("G96" in words)
    assert f"say wheel_speed = {speed}{constant or ''} in [setup]" in str(
        JobSimulation(read(program(words)), own, 0.0).why
    )
    said = programmed(wheel_speed=float(speed), constant_surface_speed=constant is not None)
    assert ground(program(words), said).warnings == ()
    assert JobSimulation(read(program(words)), said, 0.0).why is None


def test_a_turning_tool_needs_no_wheel() -> None:
    text = "G71 G94 G90 G18\nG00 X26. Z-10.\nG77 X24. Z-30. I.7 K20. D0 F60.\nM30\n"
    assert grind(read(text), job(surface=25.0, setup=BY_PROGRAM)).warnings == ()


def test_a_state_is_told_of_once_in_many_parts() -> None:
    part = f"S1500 M03\n{HEAD}{CYCLE}G80\nG00 Y20.\nM05\nM00\n"
    (speed, coolant) = ground(part * 3 + "M30\n" + DRESS, programmed()).warnings
    assert "23.56 m/s and not at the 30 m/s of the job" in speed and "the coolant is off" in coolant


def test_a_dress_may_switch_the_coolant_off_and_on_again() -> None:
    dress = DRESS.replace("N2 G00 Y20.", "N2 G00 Y20. M09").replace("N9 G90 G00 Y20.", "N9 G90 G00 Y20. M08")
    found, plain = ground(program("S1910 M03 M08", dress=dress), programmed()), ground(program(""), by_hand())
    assert found.warnings == ()
    assert found.strokes.tobytes() == plain.strokes.tobytes()


@pytest.mark.parametrize(
    ("words", "between", "reason"),
    [
        ("S1500 M03 M08", "", "the wheel turns with another speed than the job's"),
        ("S1910 M03 M08", "S1500", "the wheel turns with another speed than the job's"),
        ("S1910 M03", "", "the coolant is off"),
    ],
)
def test_what_runs_otherwise_than_the_job_has_no_script(words: str, between: str, reason: str) -> None:
    text = f"{words}\nG71 G94 G90 G19\nG00 Y20.\nG00 X-30. Z0\nG00 Y0\n{CYCLE}{between}\n{AGAIN}M30\n{DRESS}"
    why = JobSimulation(read(text, "test.nc"), programmed(), 0.0).why
    assert reason in str(why) and "test.nc:" in str(why)
    assert JobSimulation(read(text.replace(words, "S1910 M03 M08").replace("S1500", "")), programmed(), 0.0).why is None


# --- the diamond --------------------------------------------------------------------------------------------------


def test_a_part_cools_in_dresses_that_miss_the_diamond_as_long_stroke_by_stroke() -> None:
    missed = replace(job(dress_setup=8.0003), diamond=Diamond(x=-100.0, y=10.0, z=-10.0))
    seven = CYCLE.replace("P9100", "P9100 D7").replace("Y-.05 J-.01", "Y-.1 J-.03")
    text = HEAD + CYCLE.replace("P9100", "P9100 D1") + "G80\nG00 X-30.\n" + seven + "G80\nM30\n"  # D1 makes it known
    late = replace(missed.control, operator_dress_at=LONG_AFTER)
    whole, stepped = run(text, missed), run(text, missed, control=late)
    assert len(whole.dresses) == 8 and whole.strokes["grown"].max() > 0.0
    assert round(3000.0 * whole.dresses["seconds"][0]) != 3 * round(1000.0 * whole.dresses["seconds"][0])
    for name in ("grown", "ae", "A"):
        assert whole.strokes[name].tobytes() == stepped.strokes[name].tobytes(), name


def test_a_dress_that_misses_the_diamond_takes_its_time_and_dresses_nothing() -> None:
    text = CYCLE.replace("P9100", "P9100 D2") + "G80\nG00 X-30.\nG00 Y0\n" + CYCLE.replace("Y-.05", "Y-.08")
    shop = job(stock=0.08, setup=TIMELESS)
    met, missed = (replace(shop, diamond=Diamond(x=x, y=10.0, z=-10.0)) for x in (-120.0, -100.0))
    found, as_if, plain = (run(HEAD + text + "M30\n", each) for each in (missed, met, shop))
    assert as_if.warnings == () and as_if.strokes.tobytes() == plain.strokes.tobytes()
    (warning,) = found.warnings
    assert "dress program O9100 dresses nothing" in warning
    assert found.dresses["removed"].tolist() == [0.0, 0.0] and (as_if.dresses["removed"] > 0.0).all()
    assert found.seconds == as_if.seconds
    undressed = run(HEAD + text.replace("D2", "D0") + "M30\n", missed)
    np.testing.assert_array_equal(found.strokes["A"], undressed.strokes["A"])
    assert (np.diff(found.strokes["ds"]) <= 0.0).all()
    stepped = run(HEAD + text + "M30\n", missed, control=replace(missed.control, operator_dress_at=LONG_AFTER))
    assert told_stepped(stepped) == found.warnings
    np.testing.assert_allclose(stepped.dresses["ds"], found.dresses["ds"], 1e-12)


def test_strokes_that_are_looked_at_one_by_one_may_have_a_missed_dress_between_them() -> None:
    path = EXAMPLES / "plate_g82.nc"
    text = path.read_text(encoding="utf-8").replace("E9000.", "E1000. D1")
    set_up = load_job(path.with_suffix(".toml"))
    found = grind(read(text), replace(set_up, diamond=Diamond(x=-100.0, y=10.0, z=-10.0)))
    assert len(found.dresses) == 2
    assert "dresses nothing" in found.warnings[0]
