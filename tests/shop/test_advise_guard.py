"""Limits of the advice, and shadow mode, which compares forecasts without advising."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from grind_env.machine.job import JobError
from grind_env.policies.scripted.rules import Fixed
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.forecast_comparison import ComparedReading, Shadow
from grind_env.shop.advise.operator_readings import readings_of
from grind_env.shop.advise.rehearsal import read
from tests.shop.advising import PLATE, SEED, adviser_after, batch, plate_in, rollout, session_of


def test_advice_starts_at_the_programmed_E_and_rises_by_limited_steps() -> None:
    easy = [{"peak_power": 4500.0}, {"peak_power": 1500.0, "size_error": 6.0}] * 5
    for step in (1.25, 1.1):
        _, advice = adviser_after(easy, step=step)
        for kind, own in ((0, 15_000.0), (1, 9000.0)):
            speeds = [speed for speed, _ in advice[kind::2]]
            assert speeds[0] == own
            assert max(b / a for a, b in pairwise(speeds)) < step + 1e-3


def test_advice_stays_within_bounds() -> None:
    _, advice = adviser_after([{}] * 10, bounds=(10_000.0, 17_000.0))
    assert all(10_000.0 <= speed <= 17_000.0 for speed, _ in advice)


def test_advice_is_never_faster_than_the_table_of_the_machine(tmp_path: Path) -> None:
    program, slow = plate_in(tmp_path), "[setup]\nmachine_overrides = { maximum_table_speed = 16000 }"
    program.with_suffix(".toml").write_text(PLATE.with_suffix(".toml").read_text().replace("[setup]", slow))
    simulation: Any = batch(program, 2).simulation()
    adviser, speeds = Adviser(simulation, policy_for(None, simulation)), []
    for _ in range(4):
        assert adviser.advice is not None
        speeds.append(adviser.advice.speed)
        adviser.take(readings_of({"mean_power": 500.0, "peak_power": 600.0}, "here"))
    assert max(speeds) == simulation.task.action.speed_ends[1] == 16_000.0
    program.with_suffix(".toml").write_text(program.with_suffix(".toml").read_text().replace("= 16000", "= 900"))
    with pytest.raises(JobError, match=r"maximum_table_speed of .* is 900, .*: raise it"):
        batch(program, 2).simulation()


def test_a_shadow_compares_its_forecasts_with_the_readings_of_an_operator(tmp_path: Path) -> None:
    problem = batch(PLATE, 6)
    simulation: Any = problem.simulation()
    rows: list[dict[str, Any]] = []
    for number, (observation, speed, executions) in enumerate(rollout(problem, Fixed(14_000.0, 1, 2), SEED)):
        rows.append({"E": speed, "D": executions})
        if number:
            rows[number - 1] |= read(simulation, observation[None], number - 1).given()
    rows.pop()
    said: list[str] = []
    adviser = Adviser(simulation, policy_for(None, simulation), shadow=True)
    session = session_of(tmp_path, rows, said)
    session.adviser, session.shadow = adviser, Shadow()
    with pytest.raises(KeyboardInterrupt):
        session.run()
    assert said[0].startswith("part 1, N50: would be E")
    lines = session.shadow.lines()
    assert said[-len(lines) :] == lines
    assert lines[0] == "forecasts beside readings:" and "forecast" in lines[1] and "part 1: peak power" in lines[1]
    assert lines[-1].endswith("on") or lines[-1].endswith("yet")
    # a row without E and D stands for the programmed values
    alone = Adviser(simulation, policy_for(None, simulation), shadow=True)
    alone.take(readings_of({}, "here"))
    assert float(simulation.read(alone.episode.observation())["last_speed"][0]) == pytest.approx(15_000.0)


def test_a_shadow_names_the_part_from_which_its_forecasts_hold() -> None:
    off = [ComparedReading(part, "size error", "um", 9.0, 2.0, 1.0) for part in range(2)]
    right = [ComparedReading(part, "size error", "um", 3.0, 2.0, 1.0) for part in range(2, 8)]
    assert Shadow(off + right).right_from() == 2
    assert Shadow(off).right_from() is None
    assert Shadow(off + right).lines()[-1] == "75 % of the forecasts held; they are right from part 3 on"
    assert Shadow().lines() == ["nothing was read that could be compared with a forecast"]
