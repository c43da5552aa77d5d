"""The adviser at the machine: the advice of the policy in the environment, kept through every stop."""

import csv
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import save

import grind_env
from grind_env.envs.job.measured import Measured, MeasuredEpisode
from grind_env.errors import GrindError
from grind_env.policies.learned.network import FAMILIES, Network, outputs_of
from grind_env.policies.learned.saved import ENTRY, FORMAT, VERSION, load_policy, spaces_digest
from grind_env.policies.learned.view import LearnerView
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem, find_problem
from grind_env.policies.scripted.belief_rule import BeliefRule
from grind_env.policies.scripted.handbook import Handbook
from grind_env.policies.scripted.rules import AdaptiveRule, Fixed, PowerThreshold
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.forecast import Forecaster
from grind_env.shop.advise.own import LOG, STATE, VALUES
from grind_env.shop.advise.readings import check_readings, readings_of
from grind_env.shop.advise.session import Files, Session
from grind_env.shop.advise.shadow import Beside, Shadow
from grind_env.shop.advise.sources import LONGEST_LINE, CsvSource, JsonLines, Prompt, Row
from grind_env.shop.advise.state import Origin, held, origin_of, read_state
from grind_env.shop.advise.values import check_variables, variables_of, write_values
from grind_env.task_version import TASK_VERSION
from tests.command import Grind

EXAMPLES = Path(grind_env.__file__).parent / "examples"
PLATE, RAIL = EXAMPLES / "plate_g82.nc", EXAMPLES / "rail_g83.nc"
EXECUTED = """G71 G94 G90 G19 S1910 M03 M08
G00 X-30. Y0 Z0
G82 X230. I-30. Y-.03 J-.01 F1. E12000. P9100
G80
G00 Y20.
M30
"""
INCHES = """G70 G94 G90 G19 S1910 M03 M08
G00 Y.1 Z-.1
G00 X-1.2
G01 Y0 F20.
G82 X9. I-1.2 Y-.006 J-.0004 F2.4 E500. P9100 D1
G80
G00 Y1. M09 M05
M30
"""
DRESS = PLATE.read_text()[PLATE.read_text().index("O9100") :].rstrip("%\n")
SEED = 12


def batch(program: Path, parts: int) -> Problem:
    return find_problem(str(program), None, parts)


def saved_agent(path: Path, problem: Problem) -> Path:
    """A small agent as `python -m agents train` saves it, with random weights."""
    simulation = problem.simulation()
    view = LearnerView(simulation, "belief", "grid")
    family = next(iter(FAMILIES))
    network = Network(
        family=family,
        entries=view.observation_space.shape[0],
        lstm=0,
        hidden=(8,),
        outputs=outputs_of(view.action_space),
        activation="tanh",
    )
    rng = np.random.default_rng(17)
    tensors = {name: rng.normal(0.0, 0.7, shape).astype(np.float32) for name, shape in network.shapes().items()}
    document = {
        "format": FORMAT,
        VERSION: TASK_VERSION,
        "task": simulation.task.name,
        "kind": "ppo",
        "memory": "belief",
        "actions": "grid",
        "network": asdict(network),
        "spaces": spaces_digest(view),
    }
    path.write_bytes(save(tensors, {ENTRY: json.dumps(document)}))
    return path


def told(simulation: Any, observation: np.ndarray, number: int) -> dict[str, Any]:
    """What an observation says was measured of the block before it, as somebody would type it."""
    seen = {name: float(value[0]) for name, value in simulation.read(observation[None]).items()}
    row: dict[str, Any] = {name: seen[name] for name in ("mean_power", "first_power", "peak_power")}
    if simulation.blocks[number].finished:
        row |= {name: seen[name] for name in ("size_error", "diameter")}
        row["new_lot"] = int(seen["new_lot"] > 0.5)
        if round(seen["parts_since_gauged"]) == 1 and seen["roughness"] > 0.0:
            row["Ra_before"] = seen["roughness"] * simulation.job.limits.roughness
    return row


def played(problem: Problem, policy: Policy, seed: int) -> Iterator[tuple[np.ndarray, float, int]]:
    """An episode of the environment: each observation with the E and D that the policy then chose."""
    env: Any = problem.make().unwrapped
    policy.begin(env.simulation, 1)
    observation, _ = env.reset(seed=seed)
    over = False
    while not over:
        decision = policy.act(observation[None], None)
        after, _, over, _, info = env.step(env.codec.encode(*decision)[0])
        yield observation, info["E"], info["D"]
        observation = after


RULE = {"E": (25.0, 18.0), "A_dress": (0.0098, 0.0102), "gA": -0.9, "gF": 0.1, "gH": 0.0, "wV": 0.3, "wH": 0.0}
POLICIES: dict[str, Callable[[Problem, Path], Policy]] = {
    "power_threshold": lambda problem, folder: PowerThreshold(E=26.0, upper=32.0, lower=0.9, share=0.3),
    "adaptive_rule": lambda problem, folder: AdaptiveRule(**RULE, gS=-0.1, wS=0.2),
    "belief_rule": lambda problem, folder: BeliefRule(**RULE, gK=-0.2, wK=0.3),
    "look_ahead": lambda problem, folder: policy_for(None, problem.simulation()),
    "agent": lambda problem, folder: load_policy(
        saved_agent(folder / "agent.safetensors", problem), simulation=problem.simulation()
    ),
}


@pytest.mark.parametrize(("program", "parts", "names"), [(PLATE, 7, POLICIES), (RAIL, 4, ("look_ahead", "agent"))])
def test_the_same_measurements_give_the_advice_of_the_policy_in_the_environment(
    program: Path, parts: int, names: Iterable[str], tmp_path: Path
) -> None:
    problem = batch(program, parts)
    simulation: Any = problem.simulation()
    chosen = dict[str, set[tuple[float, int]]]()
    for name in names:
        steps = list(played(problem, POLICIES[name](problem, tmp_path), SEED))
        adviser = Adviser(simulation, POLICIES[name](problem, tmp_path))
        chosen[name] = {(speed, executions) for _, speed, executions in steps}
        for number, (observation, speed, executions) in enumerate(steps):
            if number:
                row = json.loads(json.dumps(told(simulation, observation, number - 1)))
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
    # policies that never changed their mind would show nothing
    for name in {"power_threshold", "adaptive_rule", "belief_rule", "agent"} & chosen.keys():
        assert len({speed for speed, _ in chosen[name]}) > 2 and len({each for _, each in chosen[name]}) > 1, name


def test_changed_wheels_and_new_lots_are_seen_as_in_the_environment(tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_bytes(PLATE.read_bytes())
    job = PLATE.with_suffix(".toml").read_text().replace("load = 20", "load = 20\nwheel_change = 300")
    lots = "[lots]\nprobability = 0.5\nstock = 0.2\n[wheel]\ndiameter = 220.1\n"
    program.with_suffix(".toml").write_text(f"{job}\n{lots}")
    problem = batch(program, 8)
    simulation: Any = problem.simulation()
    episode = MeasuredEpisode(simulation)
    before, changes, lots_seen, chosen = 0.0, 0, 0, (0.0, 0)
    for number, (observation, speed, executions) in enumerate(played(problem, Fixed(14.0, 1), SEED)):
        diameter = float(simulation.read(observation[None])["diameter"][0])
        if number:
            row = told(simulation, observation, number - 1) | {"new_wheel": int(diameter > before + 1.0)}
            changes, lots_seen = changes + row["new_wheel"], lots_seen + row.get("new_lot", 0)
            episode.take(*chosen, readings_of(row, "here").measured())
        np.testing.assert_array_equal(episode.observation()[0], observation)
        before, chosen = diameter, (speed, executions)
    assert changes > 0 and lots_seen > 1


def test_a_program_that_the_control_executes_is_advised_on_without_belief(tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text(EXECUTED + DRESS)
    program.with_suffix(".toml").write_bytes(PLATE.with_suffix(".toml").read_bytes())
    problem = batch(program, 3)
    simulation: Any = problem.simulation()
    assert policy_for(None, simulation).name == "empirical_rule"
    adviser = Adviser(simulation, Handbook())
    for number, (observation, speed, executions) in enumerate(played(problem, Handbook(), SEED)):
        if number:
            adviser.take(readings_of(told(simulation, observation, number - 1), "here"))
        np.testing.assert_array_equal(adviser.episode.observation()[0], observation)
        assert adviser.advice is not None and adviser.forecast() is None
        assert (adviser.advice.speed, adviser.advice.executions) == (speed, executions)


def test_roughness_is_shown_one_part_late_whenever_it_is_told() -> None:
    simulation: Any = batch(PLATE, 7).simulation()
    early, late = MeasuredEpisode(simulation), MeasuredEpisode(simulation)
    for block in range(4):
        early.take(12_000.0, 0, Measured(Ra=0.35 if block == 1 else None))
        late.take(12_000.0, 0, Measured(Ra_before=0.35 if block == 3 else None))
        shown = float(simulation.read(early.observation())["roughness"][0])
        assert shown == (pytest.approx(0.7) if block == 3 else 0.0)
    np.testing.assert_array_equal(early.observation(), late.observation())


def test_the_reason_is_what_members_of_the_belief_come_to() -> None:
    simulation: Any = batch(PLATE, 7).simulation()
    sharp, dull = Forecaster(simulation), Forecaster(simulation)
    for forecaster, power in ((sharp, 1900.0), (dull, 6000.0)):
        episode = MeasuredEpisode(simulation)
        for _ in range(5):
            forecaster.update(episode.observation())
            if not episode.over:
                episode.take(20_000.0, 0, Measured(power, power, power))
    fresh, worn = sharp.forecast(4, 20_000.0, 0), dull.forecast(4, 20_000.0, 0)
    assert fresh.dullness < worn.dullness and fresh.power < worn.power and fresh.dress_saving < worn.dress_saving
    slower = dull.forecast(4, 10_000.0, 0)
    assert slower.power < worn.power
    # what the dress saves does not depend on whether it is the advice
    assert dull.forecast(4, 20_000.0, 1).dress_saving == pytest.approx(worn.dress_saving)
    assert worn.dress_cost == pytest.approx(simulation.branches.dress_price)


# --- sessions -------------------------------------------------------------------------------------------------


class Told:
    """A source of given rows that is stopped after them."""

    retold, patient = False, False

    def __init__(self, rows: list[dict[str, Any]]) -> None:
        self.rows = rows

    def next(self, asked: str) -> Row:
        if not self.rows:
            raise KeyboardInterrupt
        return Row(self.rows.pop(0), "here")


def session_of(folder: Path, rows: list[dict[str, Any]], said: list[str], **arguments: Any) -> Session:
    simulation: Any = batch(PLATE, 4).simulation()
    policy = policy_for(None, simulation)
    files = Files(state=folder / "state.json", log=folder / "state.csv", values=folder / "values.nc")
    origin = origin_of(simulation, policy, None)
    return Session(
        adviser=Adviser(simulation, policy), origin=origin, files=files, source=Told(rows), say=said.append, **arguments
    )


ROWS: list[dict[str, Any]] = [
    {"mean_power": 3500.0, "peak_power": 3700.0},
    {"mean_power": 2100.0, "size_error": 2.0, "Ra": 0.4},
    {"mean_power": 5200.0, "E": 20_000.0},
    {"size_error": 4.0, "new_lot": 1},
    {"mean_power": 6100.0},
    {},
    {"mean_power": 4100.0, "D": 1},
    {"size_error": 1.0},
]


def advised(said: list[str]) -> list[dict[str, Any]]:
    return [json.loads(line) for line in said if line.startswith("{")]


def test_a_session_that_is_stopped_anywhere_goes_on_where_it_was(tmp_path: Path) -> None:
    whole: list[str] = []
    (tmp_path / "whole").mkdir()
    session_of(tmp_path / "whole", list(ROWS), whole, as_json=True).run()
    wanted = advised(whole)
    assert len(wanted) == 8
    for number in (0, 3, 6, 8):
        said: list[str] = []
        session = session_of(tmp_path, ROWS[len(session_steps(tmp_path)) : number], said, as_json=True)
        session.resume()
        begun = len(session.steps)
        if number < 8:
            with pytest.raises(KeyboardInterrupt):
                session.run()
        else:
            session.run()
        assert advised(said) == wanted[begun : number + 1]
    assert session_steps(tmp_path) == session_steps(tmp_path / "whole")
    with (tmp_path / "state.csv").open(newline="") as file:
        log = list(csv.DictReader(file))
    assert [row["advised_E"] for row in log] == [each["E"] for each in wanted]
    assert [row["E"] for row in log][2] == "20000.0" and [row["part"] for row in log] == list("11223344")


def session_steps(folder: Path) -> list[Any]:
    path = folder / "state.json"
    return [step["readings"] for step in json.loads(path.read_text())["steps"]] if path.exists() else []


def test_advice_by_part_comes_before_the_part_and_again_after_a_stop(tmp_path: Path) -> None:
    said: list[str] = []
    session = session_of(tmp_path, [{"part": 1, "size_error": 1.0}], said, by_part=True, as_json=True)
    with pytest.raises(KeyboardInterrupt):
        session.run()
    assert [each["block"] for each in advised(said)] == [1, 2, 3, 4]
    again: list[str] = []
    other = session_of(tmp_path, [], again, by_part=True, as_json=True)
    other.resume()
    with pytest.raises(KeyboardInterrupt):
        other.run()
    assert advised(again) == advised(said)[2:]
    assert (tmp_path / "values.nc").read_text().splitlines()[-1] == "M30"
    assert len((tmp_path / "values.nc").read_text().splitlines()) == 5


def test_a_state_of_another_batch_or_a_damaged_one_is_refused(tmp_path: Path) -> None:
    session = session_of(tmp_path, [ROWS[0]], [])
    with pytest.raises(KeyboardInterrupt):
        session.run()
    path, origin = tmp_path / "state.json", session.origin
    assert len(read_state(path, origin)) == 1
    for name, what in (("program", "program"), ("job", "job"), ("policy", "policy"), ("parts", "number of parts")):
        other = Origin(**(asdict(origin) | {name: 3 if name == "parts" else "other"}))
        with pytest.raises(GrindError, match=f"was written with another {what}: give --restart"):
            read_state(path, other)
    good = json.loads(path.read_text())
    for text in ("", "[]", "{}", path.read_text()[:-9], '{"format": 2}', json.dumps(good | {"steps": [{"time": 3}]})):
        path.write_text(text)
        with pytest.raises(GrindError, match="--restart"):
            read_state(path, origin)
    good["steps"][0]["words"]["E"] = "7."
    path.write_text(json.dumps(good))
    with pytest.raises(GrindError, match="which advised otherwise: give --restart"):
        session_of(tmp_path, [], []).resume()


def test_states_tell_programs_jobs_and_policies_apart(tmp_path: Path) -> None:
    def origin(text: str, job: str, policy: str) -> Origin:
        program = tmp_path / "part.nc"
        program.write_text(text)
        program.with_suffix(".toml").write_text(job)
        simulation: Any = batch(program, 2).simulation()
        return origin_of(simulation, policy_for(policy, simulation), None)

    text, job = PLATE.read_text(), PLATE.with_suffix(".toml").read_text()
    first = origin(text, job, "E12D0")
    assert first == origin(text.replace("(ROUGH:", "(SCHRUPPEN:"), job, "E12D0")
    assert first.program != origin(text.replace("J-.005", "J-.004"), job, "E12D0").program
    assert first.job != origin(text, job.replace("load = 20", "load = 20\nwheel_change = 300"), "E12D0").job
    assert first.policy != origin(text, job, "E12D1").policy


# --- what is read and written ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"mean_powr": 3}, "there is no reading 'mean_powr' .did you mean mean_power"),
        ({"mean_power": "much"}, "mean_power is 'much', but must be a number; leave it empty"),
        ({"mean_power": "nan"}, "must be a number"),
        ({"mean_power": 10**400}, "must be a number"),
        ({"mean_power": True}, "must be a number"),
        ({"mean_power": [1]}, "must be a number"),
        ({"mean_power": -1}, "mean_power is -1, but must lie between 0 and 37500 W"),
        ({"mean_power": 1e6}, "must lie between 0 and 37500 W"),
        ({"E": 50}, "E is 50, but must lie between 3000 and 30000 mm/min"),
        ({"D": 1.5}, "D is 1.5, but must be a whole number"),
        ({"D": 9}, "D is 9, but must lie between 0 and 3"),
        ({"block": 7}, "this is of block 7, but block 1 is awaited"),
        ({"part": 2}, "this is of part 2, but part 1 is awaited"),
        ({"Ra": 0.3}, "Ra is of a finished part, but block 1 finishes none: give it with the last block of part 1"),
        ({"diameter": 400}, "diameter is 400, but must lie between 20 and 301 mm"),
        ({"new_wheel": "perhaps"}, "new_wheel is 'perhaps', but must be 1 or 0"),
        ({"new_wheel": 1}, "new_wheel is 1, but not how large it is: give its diameter"),
    ],
)
def test_a_faulty_reading_is_refused_with_one_sentence(row: dict[str, Any], message: str, tmp_path: Path) -> None:
    session = session_of(tmp_path, [row], [])
    with pytest.raises(GrindError, match=message) as caught:
        session.run()
    assert "\n" not in str(caught.value)
    assert not session_steps(tmp_path)


def test_what_is_typed_is_asked_for_again_until_it_fits(tmp_path: Path) -> None:
    lines = iter(["peak_power", "peak_power=much", "size_error=3", "peak_power=2400 mean_power=2100", "stop"])
    said: list[str] = []
    session = session_of(tmp_path, [], said)
    session.source = Prompt(lambda text: next(lines))
    session.run()
    assert session_steps(tmp_path) == [{"mean_power": 2100.0, "peak_power": 2400.0}]
    refused = [
        line for line in said if "write name=value" in line or "must be a number" in line or "of a finished" in line
    ]
    assert len(refused) == 3


def test_a_program_in_inches_is_advised_and_answered_in_inches(tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text(INCHES + DRESS)
    program.with_suffix(".toml").write_bytes(PLATE.with_suffix(".toml").read_bytes())
    simulation: Any = batch(program, 2).simulation()
    adviser = Adviser(simulation, policy_for("E12D1", simulation))
    assert adviser.advice is not None and adviser.advice.words == {"E": "472.4409", "D": "1"}
    write_values(tmp_path / "values.nc", simulation, [adviser.advice])
    assert "#101=472.4409 (E, INCH/MIN, PART 1, BLOCK 1)" in (tmp_path / "values.nc").read_text()
    adviser.take(readings_of({"E": 500.0}, "here"))
    assert simulation.read(adviser.episode.observation())["last_speed"][0] == pytest.approx(12.7)
    with pytest.raises(GrindError, match=r"E is 9000, but must lie between 118\.11 and 1181\.1 inch/min"):
        check_readings(readings_of({"E": 9000}, "here"), simulation, 1, "here")


def rows_of(path: Path, text: str, *, follow: bool = False) -> list[dict[str, Any]]:
    def stop(seconds: float) -> None:
        raise TimeoutError

    path.write_text(text)
    source, rows = CsvSource(path, follow=follow, wait=stop), []
    try:
        while (row := source.next("")) is not None:
            rows.append(readings_of(row.table, row.place).given())
    except TimeoutError:
        pass
    return rows


def test_a_csv_is_read_with_commas_or_semicolons_and_while_it_grows(tmp_path: Path) -> None:
    path, wanted = tmp_path / "m.csv", [{"block": 1, "peak_power": 2400.5}, {"block": 2, "size_error": -1.5}]
    commas = "block,peak_power,size_error\n1,2400.5,\n\n2,,-1.5\n"
    assert rows_of(path, commas) == wanted
    assert rows_of(path, "\ufeff" + commas.replace(",", ";").replace(".", ",")) == wanted
    assert rows_of(path, commas.rstrip("\n")) == wanted
    assert rows_of(path, commas.rstrip("\n"), follow=True) == wanted[:1]
    assert rows_of(path, "block,peak", follow=True) == []
    with pytest.raises(GrindError, match=r"m.csv, row 2 has 3 cells, but the header 2"):
        rows_of(path, "block,peak_power\n1,2,3\n")


def test_values_are_those_of_the_variables_that_the_blocks_read(tmp_path: Path) -> None:
    simulation: Any = batch(PLATE, 2).simulation()
    adviser = Adviser(simulation, policy_for("E12D1", simulation))
    assert adviser.advice is not None
    write_values(tmp_path / "O77.nc", simulation, [adviser.advice])
    lines = (tmp_path / "O77.nc").read_text().splitlines()
    assert lines == [
        "O77",
        "#101=12000. (E, MM/MIN, PART 1, BLOCK 1)",
        "#102=1 (D)",
        "#103=9000. (E, MM/MIN, AS PROGRAMMED)",
        "#104=0 (D)",
        "M99",
    ]
    assert variables_of(simulation.blocks[1], 1) == (103, 104)
    check_variables(simulation)

    def block(text: str) -> Any:
        plan = SimpleNamespace(code="G82")
        return SimpleNamespace(part=0, plan=plan, block=SimpleNamespace(source=SimpleNamespace(text=text, line=7)))

    assert variables_of(block("N50 g82 Y-.17 e#500 P9100 D # 7"), 3) == (500, 7)
    assert variables_of(block("N50 G82 Y-.17 E9000. P9100 D#7"), 3) == (107, 7)
    with pytest.raises(GrindError, match=r"line 7: E is an expression.* such as E#101"):
        variables_of(block("G82 Y-.17 E[#500*2]"), 0)
    shared: Any = SimpleNamespace(blocks=[block("E#101 D#102"), block("E#101")])
    with pytest.raises(GrindError, match="blocks 1 and 2 of one part both read #101"):
        check_variables(shared)


# --- the command ----------------------------------------------------------------------------------------------


def test_the_command_reads_a_file_again_and_refuses_what_does_not_fit(grind: Grind, tmp_path: Path) -> None:
    program, measured = tmp_path / "part.nc", tmp_path / "measured.csv"
    program.write_bytes(PLATE.read_bytes())
    program.with_suffix(".toml").write_bytes(PLATE.with_suffix(".toml").read_bytes())
    measured.write_text("mean_power,size_error\n2500,\n")
    words = ("advise", program, "--parts", 2, "--measurements", measured)
    status, out, _ = grind(*words)
    assert status == 0 and "block 1 of 4, part 1: E" in out and "expected power" in out and "a dress costs" in out
    measured.write_text("mean_power,size_error\n2500,\n,3\n")
    status, out, _ = grind(*words)
    assert status == 0 and out.startswith("block 2 of 4") and "block 3 of 4, part 2" in out
    measured.write_text("mean_power,size_error\n2600,\n,3\n")
    other = saved_agent(tmp_path / "a.safetensors", batch(PLATE, 5))
    for wrong, message in (
        (words, "row 2 says something else of block 1 than it did before: give --restart"),
        ((*words[:3], 3, *words[4:]), "was written with another number of parts"),
        ((*words, "--policy", "E9D0"), "was written with another policy"),
        ((*words, "--policy", "hindsight"), "cannot advise at a machine"),
        ((*words, "--policy", other), "was trained for plate_g82_x5"),
        ((*words, "--by", "day"), "--by is 'day', but must be block or part"),
        ((*words, "--write", program), "would be lost"),
        (("advise", program, "--follow"), "name it with --measurements"),
    ):
        status, _, err = grind(*wrong)
        assert status == 2 and message in err and err.count("\n") == 1, err
    status, out, _ = grind(*words, "--restart")
    assert status == 0 and out.startswith("block 1 of 4")


def plate_in(folder: Path) -> Path:
    """The example in a folder of its own, with its job."""
    for path in (PLATE, PLATE.with_suffix(".toml")):
        (folder / path.name).write_bytes(path.read_bytes())
    return folder / PLATE.name


def test_no_file_but_its_own_is_replaced(grind: Grind, tmp_path: Path) -> None:
    program, measured = plate_in(tmp_path), tmp_path / "measured.csv"
    measured.write_text("mean_power,size_error\n2500,\n")
    words = ("advise", program, "--parts", 2, "--policy", "E12D0", "--measurements", measured, "--state")
    for name in ("d.json", "d.csv", "values.nc"):
        (tmp_path / name).write_text("mine\n")
        for more in ((), ("--restart",)):
            written = ("--write", tmp_path / "values.nc") if name == "values.nc" else ()
            status, _, err = grind(*words, tmp_path / "d.json", *written, *more)
            assert status == 2 and f"{name}" in err and "is there already and would be lost" in err
            assert (tmp_path / name).read_text() == "mine\n"
        (tmp_path / name).unlink()
    (tmp_path / "values.nc").write_text("#101=12000. (as it was)\n#102=0\nM30\n")
    for more in ((), (), ("--restart",)):
        assert grind(*words, tmp_path / "d.json", "--write", tmp_path / "values.nc", *more)[0] == 0
        assert (tmp_path / "values.nc").read_text().startswith("#101=12000. (E, MM/MIN, PART 1, BLOCK 1)\n")
    assert {path.name for path in tmp_path.glob("*d.*")} == {"d.json", "d.csv", "measured.csv"}


def test_values_may_be_a_program_that_is_called(grind: Grind, tmp_path: Path) -> None:
    program, values = plate_in(tmp_path), tmp_path / "O9050.nc"
    program.write_text(program.read_text().replace("M30", "M30\nO1\nM98 P9050\nM99", 1))
    words = ("advise", program, "--parts", 1, "--policy", "E12D0", "--measurements", tmp_path / "m.csv")
    (tmp_path / "m.csv").write_text("mean_power\n2500\n")
    values.write_text("#101=12000.\nM99\n")
    assert grind(*words, "--write", values)[0] == 0
    assert values.read_text().startswith("O9050\n#101=12000. (E, MM/MIN, PART 1, BLOCK 1)\n")
    values.write_text("#101=12000.\nG04 P1.\nM99\n")
    status, _, err = grind(*words, "--write", values)
    assert status == 2 and "O9050.nc is read here and would be lost" in err
    (tmp_path / "m.csv").write_text("")
    status, _, err = grind(*words, "--write", tmp_path / "m.csv")
    assert status == 2 and "m.csv is read here and would be lost" in err


def test_one_adviser_at_a_time_works_with_a_state(grind: Grind, tmp_path: Path) -> None:
    program, state = plate_in(tmp_path), tmp_path / "plate_g82.advise.json"
    (tmp_path / "link.json").symlink_to(state)
    (tmp_path / "m.csv").write_text("mean_power\n2500\n")
    words = ("advise", program, "--parts", 1, "--policy", "E12D0", "--measurements", tmp_path / "m.csv")
    with held(state):
        for more in ((), ("--state", tmp_path / "link.json"), ("--restart",)):
            status, out, err = grind(*words, *more)
            assert (status, out) == (2, "") and "another adviser works with" in err
        assert not state.exists()
    assert grind(*words)[0] == 0
    assert len(json.loads(state.read_text())["steps"]) == 1 and not list(tmp_path.glob(".grind*"))


@pytest.mark.parametrize("steps", [{}, "", None, 0, {"0": {}}])
def test_steps_that_are_no_list_are_damaged(steps: Any, tmp_path: Path) -> None:
    origin = Origin(parts=1, program="", job="", policy="")
    path = tmp_path / "state.json"
    path.write_text(json.dumps({"format": 1, "origin": asdict(origin), "steps": steps}))
    with pytest.raises(GrindError, match=r"is damaged: its steps are .* and no list: give --restart"):
        read_state(path, origin)


def test_what_it_writes_is_known_for_its_own(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        session_of(tmp_path, ROWS[:2], []).run()
    for name, own in (("state.json", STATE), ("state.csv", LOG), ("values.nc", VALUES)):
        assert own.fits(tmp_path / name) and own.fits(tmp_path / "none")
        for other in ("state.json", "state.csv", "values.nc"):
            assert own.fits(tmp_path / other) == (other == name)
    (tmp_path / "state.json").write_text((tmp_path / "state.json").read_text()[:-40])
    assert STATE.fits(tmp_path / "state.json")
    for name in (PLATE, PLATE.with_suffix(".toml")):
        assert not any(own.fits(name) for own in (STATE, LOG, VALUES))


def test_standard_input_that_is_closed_is_told(grind: Grind, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", None)
    status, out, err = grind("advise", plate_in(tmp_path), "--parts", 1, "--policy", "E12D0")
    assert (status, out) == (2, "") and "standard input is closed" in err and "--measurements" in err


def test_lines_before_one_that_cannot_be_read_are_taken() -> None:
    source = JsonLines(BytesIO(b'\n{"Ra": 0.4}\n\xef\xbb\xbf{}\n{"Ra": \xff}\n{}\n' + b" " * LONGEST_LINE))
    assert source.next("") == Row({"Ra": 0.4}, "line 2 of the input")
    for what in ("line 3 of the input is", r"line 4 of the input: its byte 8 is not text in UTF-8"):
        with pytest.raises(GrindError, match=what):
            source.next("")
    assert source.next("") == Row({}, "line 5 of the input")
    with pytest.raises(GrindError, match="line 6 of the input has no end"):
        source.next("")


def test_what_is_typed_in_another_code_is_asked_for_again(tmp_path: Path) -> None:
    lines, said = iter([b"Ra=\xff", b"mean_power=2100", b"stop"]), list[str]()
    session = session_of(tmp_path, [], said)
    session.source = Prompt(lambda text: next(lines).decode())
    session.run()
    assert session_steps(tmp_path) == [{"mean_power": 2100.0}]
    assert any("is not text in UTF-8: type it again" in line for line in said)


def test_it_needs_no_torch_and_survives_a_kill(tmp_path: Path, grind: Grind) -> None:
    code = "import sys; sys.modules['torch'] = None; from grind_env.cli import main; main(sys.argv[1:])"
    state, measured = tmp_path / "state.json", tmp_path / "measured.csv"
    measured.write_text("mean_power,size_error\n2500,\n")
    words = [sys.executable, "-c", code, "advise", str(PLATE), "--parts", "2", "--json", "--state", str(state)]
    follow = [*words, "--measurements", str(measured), "--follow"]
    environment = os.environ | {"PYTHONPATH": str(Path(grind_env.__file__).parents[1])}
    with subprocess.Popen(follow, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        assert [json.loads(process.stdout.readline())["block"] for _ in range(2)] == [1, 2]
        status, _, err = grind("advise", PLATE, "--parts", 2, "--state", state, "--measurements", measured)
        assert status == 2 and "another adviser works with" in err
        process.send_signal(signal.SIGKILL)
    ended = subprocess.run(words, input='{"size_error": 2}\n', capture_output=True, text=True, env=environment)
    assert ended.returncode == 0, ended.stderr
    assert [json.loads(line)["block"] for line in ended.stdout.splitlines()] == [2, 3]
    assert len(json.loads(state.read_text())["steps"]) == 2


# --- the guard ------------------------------------------------------------------------------------------------


def advisers(
    rows: Iterable[dict[str, Any]], parts: int = 6, **arguments: Any
) -> tuple[Adviser, list[tuple[float, int]]]:
    """An adviser of plates that was told these rows of blocks, and what it advised."""
    simulation: Any = batch(PLATE, 6).simulation()
    adviser = Adviser(simulation, policy_for(None, simulation, arguments.pop("step", 1.25)), **arguments)
    advice = []
    for number, row in enumerate(rows):
        assert adviser.advice is not None
        advice.append((adviser.advice.speed, adviser.advice.executions))
        readings = readings_of(row, "here")
        check_readings(readings, simulation, number, "here")
        adviser.take(readings)
    return adviser, advice


def test_it_begins_at_the_words_of_the_program_and_rises_step_by_step() -> None:
    for step in (1.25, 1.1):
        _, advice = advisers([{}] * 10, step=step)
        for kind, own in ((0, 15_000.0), (1, 9000.0)):
            speeds = [own, *(speed for speed, _ in advice[kind::2])]
            assert max(b / a for a, b in pairwise(speeds)) < step + 1e-3
            assert speeds[-1] > 1.2 * own


def test_advice_stays_within_bounds() -> None:
    _, advice = advisers([{}] * 10, bounds=(10.0, 17.0))
    assert all(10_000.0 <= speed <= 17_000.0 for speed, _ in advice)
    simulation: Any = batch(PLATE, 2).simulation()
    for bounds in ((17.0, 10.0), (1.0, 20.0), (10.0, 99.0)):
        with pytest.raises(GrindError, match=r"--bounds are .* but must lie between 3 and 30 m/min, in order"):
            Adviser(simulation, policy_for(None, simulation), bounds=bounds)
    with pytest.raises(GrindError, match=r"--step is 0\.9, but must be a factor above 1"):
        policy_for(None, simulation, 0.9)


def test_a_power_beyond_its_limit_is_noticed_in_words_and_dressed_away() -> None:
    rows: list[dict[str, Any]] = [
        {"mean_power": 2400.0, "peak_power": 2700.0},
        {"mean_power": 1500.0, "size_error": 1.0},
    ]
    adviser, _ = advisers([*rows, *rows, {"mean_power": 6000.0, "peak_power": 8800.0}])
    assert adviser.guard is not None and adviser.guard.alarmed[0]
    said = adviser.guard.said(0)
    assert said[0].startswith("alarm: peak power 8.80 kW, where") and "the limit is 7.50" in said[0]
    assert "empirical_rule decides in place of look_ahead" in said[1]
    adviser.take(readings_of({"mean_power": 5000.0, "size_error": 2.0}, "here"))
    assert adviser.advice is not None and adviser.advice.executions == 1


def test_a_part_that_came_out_too_thick_is_answered_before_the_next_one() -> None:
    thick = {"mean_power": 1500.0, "size_error": 10.0}
    adviser, advice = advisers([{}, thick, {}, thick])
    assert adviser.advice is not None and adviser.advice.executions >= 1
    adviser.take(readings_of({}, "here"))
    # the finish of the part that was too thick sets how fast the next ones are
    assert adviser.advice.speed < min(advice[1][0], advice[3][0])


def test_idle_power_is_not_there_for_grinding(tmp_path: Path) -> None:
    job = PLATE.with_suffix(".toml").read_text()
    (tmp_path / "p.nc").write_bytes(PLATE.read_bytes())
    (tmp_path / "p.toml").write_text(job + "\n[setup.machine_overrides]\npower_limit = 2400\nidle_power = 600\n")
    simulation: Any = find_problem(str(tmp_path / "p.nc"), None, 2).simulation()
    forecast = Adviser(simulation, policy_for(None, simulation)).forecast()
    assert forecast is not None and forecast.power_limit == 1800.0


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"mean_power": 2.6}, "mean_power is 2.6 W: if that is kW, write 2600"),
        ({"peak_power": 2.9}, "peak_power is 2.9 W: if that is kW, write 2900"),
        ({"mean_power": 2600.0, "peak_power": 2000.0}, "peak_power is 2000, but a mean power 2600 W"),
        ({"first_power": 2600.0, "peak_power": 2000.0}, "no mean is above the highest load"),
    ],
)
def test_what_cannot_be_read_is_asked_back(row: dict[str, Any], message: str, tmp_path: Path) -> None:
    simulation: Any = batch(PLATE, 2).simulation()
    with pytest.raises(GrindError, match=f"row 7: .*{message}"):
        check_readings(readings_of(row, "row 7"), simulation, 0, "row 7")
    with pytest.raises(GrindError, match=r"size_error is -0.004 um: if that is mm, write -4"):
        check_readings(readings_of({"size_error": -0.004}, "row 7"), simulation, 1, "row 7")
    # what noise may do to a peak and a mean that are the same
    check_readings(readings_of({"mean_power": 2600.0, "peak_power": 2400.0}, "row 7"), simulation, 0, "row 7")


def test_a_refused_reading_ends_no_session(tmp_path: Path) -> None:
    said: list[str] = []
    session = session_of(tmp_path, [], said, as_json=True)
    session.source = JsonLines(BytesIO(b'{"mean_power": 2.6}\nnothing\n{"mean_power": 2600}\n'))
    session.run()
    refused = [line["refused"] for line in advised(said) if "refused" in line]
    assert len(refused) == 2 and "line 1 of the input: mean_power is 2.6 W" in refused[0]
    assert session_steps(tmp_path) == [{"mean_power": 2600.0}]


def test_a_row_that_is_refused_in_a_file_that_grows_is_awaited_corrected(tmp_path: Path) -> None:
    measured, said = tmp_path / "m.csv", list[str]()
    measured.write_text("mean_power\n2.6\n")
    session = session_of(tmp_path, [], said)

    def wait(seconds: float) -> None:
        if not any("if that is kW" in line for line in said) or "2600" in measured.read_text():
            raise KeyboardInterrupt
        measured.write_text("mean_power\n2600\n")

    session.source = CsvSource(measured, follow=True, wait=wait)
    with pytest.raises(KeyboardInterrupt):
        session.run()
    assert session_steps(tmp_path) == [{"mean_power": 2600.0}]


def test_values_that_the_program_sets_or_uses_itself_are_refused(grind: Grind, tmp_path: Path) -> None:
    program = plate_in(tmp_path)
    text = program.read_text()
    words = ("advise", program, "--parts", 1, "--set", "#103=1", "--measurements", tmp_path / "m.csv")
    words = (*words, "--write", tmp_path / "v.nc")
    (tmp_path / "m.csv").write_text("mean_power\n")
    for line, message in (
        ("#102=5", "the program sets #102 itself, which would be written for D"),
        ("G04 X[0*#103+1]", "the program uses #103 itself, which would be written for E"),
    ):
        program.write_text(text.replace("N20 ", f"{line}\nN20 ", 1))
        status, _, err = grind(*words, "--restart")
        assert status == 2 and message in err.splitlines()[-1], err
    program.write_text(text.replace("E15000. P9100 D1", "E#101 P9100 D1").replace("N20 ", "#101=15000\nN20 ", 1))
    status, _, err = grind(*words, "--restart")
    assert status == 2 and "the program sets #101 itself" in err
    program.write_text(text.replace("N20 ", "(#102=5 IN A COMMENT)\nN20 ", 1))
    assert grind(*words, "--restart")[0] == 0


def test_a_shadow_follows_what_others_decide_and_says_from_when_on_it_was_right(tmp_path: Path) -> None:
    problem = batch(PLATE, 6)
    simulation: Any = problem.simulation()
    rows: list[dict[str, Any]] = []
    for number, (observation, speed, executions) in enumerate(played(problem, Fixed(14.0, 1, 2), SEED)):
        rows.append({"E": speed, "D": executions})
        if number:
            rows[number - 1] |= told(simulation, observation, number - 1)
    rows.pop()
    said: list[str] = []
    adviser = Adviser(simulation, policy_for(None, simulation), shadow=True)
    session = session_of(tmp_path, rows, said)
    session.adviser, session.shadow = adviser, Shadow()
    with pytest.raises(KeyboardInterrupt):
        session.run()
    assert said[0].startswith("block 1 of 12, part 1: would be E")
    lines = session.shadow.lines()
    assert lines[0] == "forecasts beside readings:" and "forecast" in lines[1] and "part 1: peak power" in lines[1]
    assert lines[-1].endswith("on") or lines[-1].endswith("yet")
    # without E and D in a row the words of the program hold
    alone = Adviser(simulation, policy_for(None, simulation), shadow=True)
    alone.take(readings_of({}, "here"))
    assert float(simulation.read(alone.episode.observation())["last_speed"][0]) == pytest.approx(15.0)


def test_a_shadow_is_right_from_the_part_on_from_which_forecasts_held() -> None:
    off = [Beside(part, "size error", "um", 9.0, 2.0, 1.0) for part in range(2)]
    right = [Beside(part, "size error", "um", 3.0, 2.0, 1.0) for part in range(2, 8)]
    assert Shadow(off + right).right_from() == 2
    assert Shadow(off).right_from() is None
    assert Shadow(off + right).lines()[-1] == "75 % of the forecasts held; they are right from part 3 on"
    assert Shadow().lines() == ["nothing was read that could be compared with a forecast"]
