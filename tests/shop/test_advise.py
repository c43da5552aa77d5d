"""The adviser at the machine gives the advice of its policy in the environment."""

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grind_env.envs.job.real_machine_episode import Measured, MeasuredEpisode
from grind_env.errors import GrindError
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.scripted.belief_rule import BeliefRule
from grind_env.policies.scripted.handbook import Handbook
from grind_env.policies.scripted.look_ahead import LookAhead
from grind_env.policies.scripted.rules import AdaptiveRule, Fixed, PowerThreshold
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.operator_readings import check_readings, readings_of
from grind_env.shop.advise.rehearsal import read
from grind_env.shop.advise.variables_file import write_values
from tests.shop.advising import DRESS, EXECUTED, INCHES, PLATE, RAIL, SEED, batch, plate_in, rollout, saved_agent

RULE = {"E": (12_000.0, 9_000.0), "A_dress": (0.0098, 0.0102), "gA": -0.9, "gF": 0.1, "gH": 0.0, "wV": 0.3, "wH": 0.0}


def look_ahead(kinds: int) -> Policy:
    """Return the policy with usual prices: these programs have no tuned ones."""
    return LookAhead(price=(1.1,) * kinds, growth=(1.5,) * kinds, caution=2.7)


POLICIES: dict[str, Callable[[Problem, Path], Policy]] = {
    "power_threshold": lambda problem, folder: PowerThreshold(E=26_000.0, upper=32.0, lower=0.9, share=0.3),
    "adaptive_rule": lambda problem, folder: AdaptiveRule(**RULE, gS=-0.1, wS=0.2),
    "belief_rule": lambda problem, folder: BeliefRule(**RULE, gK=-0.2, wK=0.3),
    "look_ahead": lambda problem, folder: look_ahead(len(problem.simulation().task.kinds)),
    "agent": lambda problem, folder: load_policy(
        saved_agent(folder / "agent.safetensors", problem), simulation=problem.simulation()
    ),
}


@pytest.mark.parametrize(("program", "parts", "names"), [(RAIL, 4, ("look_ahead", "agent")), (PLATE, 7, POLICIES)])
def test_the_adviser_repeats_the_decisions_of_its_policy_in_the_environment(
    program: Path, parts: int, names: Iterable[str], tmp_path: Path
) -> None:
    problem = batch(program, parts)
    simulation: Any = problem.simulation()
    chosen = dict[str, set[tuple[float, int]]]()
    for name in names:
        steps = list(rollout(problem, POLICIES[name](problem, tmp_path), SEED))
        adviser = Adviser(simulation, POLICIES[name](problem, tmp_path))
        chosen[name] = {(speed, executions) for _, speed, executions in steps}
        for number, (observation, speed, executions) in enumerate(steps):
            if number:
                row = json.loads(json.dumps(read(simulation, observation[None], number - 1).given()))
                adviser.take(readings_of(row, "here"))
            np.testing.assert_array_equal(adviser.episode.observation()[0], observation)
            assert adviser.advice is not None
            assert (adviser.advice.block, adviser.advice.speed, adviser.advice.executions) == (
                number,
                speed,
                executions,
            ), name
        adviser.take(readings_of({}, "here"))
        assert adviser.advice is None
    # constant decisions would prove nothing
    for name in {"power_threshold", "adaptive_rule", "belief_rule", "agent"} & chosen.keys():
        assert len({speed for speed, _ in chosen[name]}) > 2 and len({each for _, each in chosen[name]}) > 1, name


def test_wheel_changes_and_new_lots_are_observed_as_in_the_environment(tmp_path: Path) -> None:
    program = plate_in(tmp_path)
    job = PLATE.with_suffix(".toml").read_text().replace("load = 20", "load = 20\nwheel_change = 300")
    lots = "[lots]\nprobability = 0.5\nstock = 0.2\n[wheel]\ndiameter = 220.1\n"
    program.with_suffix(".toml").write_text(f"{job}\n{lots}")
    problem = batch(program, 8)
    simulation: Any = problem.simulation()
    episode = MeasuredEpisode(simulation)
    before, changes, lots_seen, chosen = 0.0, 0, 0, (0.0, 0)
    for number, (observation, speed, executions) in enumerate(rollout(problem, Fixed(14_000.0, 1), SEED)):
        diameter = float(simulation.read(observation[None])["diameter"][0])
        if number:
            row = read(simulation, observation[None], number - 1).given() | {"new_wheel": int(diameter > before + 1.0)}
            changes, lots_seen = changes + row["new_wheel"], lots_seen + row.get("new_lot", 0)
            episode.take(*chosen, readings_of(row, "here").measured())
        np.testing.assert_array_equal(episode.observation()[0], observation)
        before, chosen = diameter, (speed, executions)
    assert changes > 0 and lots_seen > 1


def test_a_program_without_a_script_is_advised_without_a_belief(tmp_path: Path) -> None:
    program = plate_in(tmp_path)
    program.write_text(EXECUTED + DRESS)
    problem = batch(program, 3)
    simulation: Any = problem.simulation()
    default: Any = policy_for(None, simulation)
    assert default.model is None
    adviser = Adviser(simulation, Handbook())
    for number, (observation, speed, executions) in enumerate(rollout(problem, Handbook(), SEED)):
        if number:
            adviser.take(readings_of(read(simulation, observation[None], number - 1).given(), "here"))
        np.testing.assert_array_equal(adviser.episode.observation()[0], observation)
        assert adviser.advice is not None and adviser.power is None
        assert (adviser.advice.speed, adviser.advice.executions) == (speed, executions)


def test_roughness_is_observed_one_part_late_for_early_and_late_readings() -> None:
    simulation: Any = batch(PLATE, 7).simulation()
    early, late = MeasuredEpisode(simulation), MeasuredEpisode(simulation)
    for block in range(4):
        early.take(12_000.0, 0, Measured(Ra=0.35 if block == 1 else None))
        late.take(12_000.0, 0, Measured(Ra_before=0.35 if block == 3 else None))
        shown = float(simulation.read(early.observation())["roughness"][0])
        assert shown == (pytest.approx(0.7) if block == 3 else 0.0)
    np.testing.assert_array_equal(early.observation(), late.observation())


def test_advice_and_readings_of_an_inch_program_are_in_inches(tmp_path: Path) -> None:
    program = plate_in(tmp_path)
    program.write_text(INCHES + DRESS)
    simulation: Any = batch(program, 2).simulation()
    adviser = Adviser(simulation, policy_for("E12000D1", simulation))
    assert adviser.advice is not None and adviser.advice.words == {"E": "472.4409", "D": "1"}
    write_values(tmp_path / "values.nc", simulation, [adviser.advice])
    assert "#101=472.4409 (E, INCH/MIN, PART 1, BLOCK 1)" in (tmp_path / "values.nc").read_text()
    adviser.take(readings_of({"E": 500.0}, "here"))
    assert simulation.read(adviser.episode.observation())["last_speed"][0] == pytest.approx(12_700.0)
    with pytest.raises(GrindError, match=r"E is 9000, but must lie between 118\.11 and 1181\.1 inch/min"):
        check_readings(readings_of({"E": 9000}, "here"), simulation, 1, "here")


def test_idle_power_is_subtracted_from_the_power_limit(tmp_path: Path) -> None:
    program = plate_in(tmp_path)
    with program.with_suffix(".toml").open("a") as job:
        job.write("\n[setup.machine_overrides]\npower_limit = 2400\nidle_power = 600\n")
    simulation: Any = batch(program, 2).simulation()
    policy: Any = policy_for(None, simulation)
    Adviser(simulation, policy)
    assert policy.rules[0].rows[0].power == 1800.0
