"""Sessions of the adviser: they resume after every stop, and only one runs at a time."""

import csv
import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import grind_env
from grind_env.errors import GrindError
from grind_env.shop.advise.adviser import policy_for
from grind_env.shop.advise.state import AdviceOrigin, StateError, locked_state, origin_of, read_state
from tests.command import Grind
from tests.shop import advising


def test_a_session_stopped_at_any_block_resumes_with_the_same_advice(tmp_path: Path) -> None:
    whole: list[str] = []
    (tmp_path / "whole").mkdir()
    advising.session_of(tmp_path / "whole", list(advising.ROWS), whole, as_json=True).run()
    wanted = advising.advised(whole)
    assert len(wanted) == 8
    for number in (0, 3, 6, 8):
        said: list[str] = []
        session = advising.session_of(
            tmp_path, advising.ROWS[len(advising.session_steps(tmp_path)) : number], said, as_json=True
        )
        session.resume()
        begun = len(session.steps)
        if number < 8:
            with pytest.raises(KeyboardInterrupt):
                session.run()
        else:
            session.run()
        assert advising.advised(said) == wanted[begun : number + 1]
    assert advising.session_steps(tmp_path) == advising.session_steps(tmp_path / "whole")
    with (tmp_path / "state.csv").open(newline="") as file:
        log = list(csv.DictReader(file))
    assert [row["advised_E"] for row in log] == [each["E"] for each in wanted]
    assert [row["E"] for row in log][2] == "20000.0" and [row["part"] for row in log] == list("11223344")


def test_advice_by_part_is_given_ahead_and_repeated_after_a_stop(tmp_path: Path) -> None:
    said: list[str] = []
    session = advising.session_of(tmp_path, [{"part": 1, "size_error": 1.0}], said, by_part=True, as_json=True)
    with pytest.raises(KeyboardInterrupt):
        session.run()
    assert [each["block"] for each in advising.advised(said)] == [1, 2, 3, 4]
    again: list[str] = []
    other = advising.session_of(tmp_path, [], again, by_part=True, as_json=True)
    other.resume()
    with pytest.raises(KeyboardInterrupt):
        other.run()
    assert advising.advised(again) == advising.advised(said)[2:]
    assert (tmp_path / "values.nc").read_text().splitlines()[-1] == "M30"
    assert len((tmp_path / "values.nc").read_text().splitlines()) == 5


def test_a_foreign_or_damaged_state_is_refused(tmp_path: Path) -> None:
    session = advising.session_of(tmp_path, [advising.ROWS[0]], [])
    with pytest.raises(KeyboardInterrupt):
        session.run()
    path, origin = tmp_path / "state.json", session.origin
    assert len(read_state(path, origin)) == 1
    with pytest.raises(StateError, match="was written with another policy: give --restart"):
        read_state(path, replace(origin, policy="other"))
    stock = {**origin.inputs, "part.stock": 0.3}
    said = "was written for another part: part.stock is 0.3, but was 0.2; give --restart"
    with pytest.raises(StateError, match=said):
        read_state(path, replace(origin, inputs=stock))
    good = json.loads(path.read_text())
    steps = [json.dumps(good | {"steps": each}) for each in ([{"time": 3}], {}, "", None, 0, {"0": {}})]
    for text in ("", "[]", "{}", path.read_text()[:-9], '{"format": 3}', *steps):
        path.write_text(text)
        with pytest.raises(GrindError, match="--restart"):
            read_state(path, origin)
    # as version 0.1 wrote it, with hashes
    path.write_text(json.dumps(good | {"format": 1, "origin": {"parts": 4, "program": "", "job": "", "policy": ""}}))
    with pytest.raises(StateError, match="was written by another version of grind_env: give --restart to begin anew"):
        read_state(path, origin)
    good["steps"][0]["words"]["E"] = "7."
    path.write_text(json.dumps(good))
    with pytest.raises(GrindError, match="which advised otherwise: give --restart"):
        advising.session_of(tmp_path, [], []).resume()


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        ({"mean_power": -5}, r"state.json, block 1: mean_power is -5, but must lie between 0 and .*; give --restart"),
        ({"mean_power": 2.6}, "block 1: mean_power is 2.6 W: if that is kW, write 2600; give --restart"),
        ({"mean_power": "1500"}, r"readings.mean_power is '1500', but must be a finite number\): give --restart"),
        ({"mean_power": True}, "readings.mean_power is True"),
        ({"new_wheel": 1}, "readings.new_wheel is 1, but must be true or false"),
        ({"part": 1.5}, "readings.part is 1.5, but must be a whole number"),
        ({"part": 2}, "block 1: this is of part 2, but part 1 is awaited"),
        ({"power": 1500}, "readings has an unknown key power"),
    ],
)
def test_edited_readings_in_a_state_are_checked_like_new_ones(
    readings: dict[str, Any], said: str, tmp_path: Path
) -> None:
    session = advising.session_of(tmp_path, [advising.ROWS[0]], [])
    with pytest.raises(KeyboardInterrupt):
        session.run()
    path = tmp_path / "state.json"
    state = json.loads(path.read_text())
    state["steps"][0]["readings"] = readings
    path.write_text(json.dumps(state))
    with pytest.raises(StateError, match=said):
        advising.session_of(tmp_path, [], []).resume()


def test_the_origin_of_a_state_distinguishes_programs_jobs_and_policies(tmp_path: Path) -> None:
    def origin(text: str, job: str, policy: str) -> AdviceOrigin:
        program = tmp_path / "part.nc"
        program.write_text(text)
        program.with_suffix(".toml").write_text(job)
        simulation: Any = advising.batch(program, 2).simulation()
        return origin_of(simulation, policy_for(policy, simulation), None)

    text, job = advising.PLATE.read_text(), advising.PLATE.with_suffix(".toml").read_text()
    first = origin(text, job, "E12000D0")
    assert first == origin(text.replace("(ROUGH:", "(SCHRUPPEN:"), job, "E12000D0")
    assert first.inputs != origin(text.replace("J-.005", "J-.004"), job, "E12000D0").inputs
    assert first.inputs != origin(text, job.replace("load = 20", "load = 20\nwheel_change = 300"), "E12000D0").inputs
    # unlike an agent, a state depends on the initial diameter of the wheel
    assert first.inputs != origin(text, f"{job}\n[wheel]\ndiameter = 280", "E12000D0").inputs
    assert first.policy != origin(text, job, "E12000D1").policy


def test_the_command_rereads_its_file_and_refuses_conflicting_input(grind: Grind, tmp_path: Path) -> None:
    program, measured = advising.plate_in(tmp_path), tmp_path / "measured.csv"
    measured.write_text("mean_power,size_error\n2500,\n")
    words = ("advise", program, "--parts", 2, "--measurements", measured)
    status, out, _ = grind(*words)
    assert status == 0 and out.startswith("part 1, N50: E15000. D0 - E stays until the power of this block is read\n")
    measured.write_text("mean_power,size_error\n2500,\n,3\n")
    status, out, _ = grind(*words)
    assert status == 0 and out.startswith("part 1, N70") and "part 2, N50" in out
    measured.write_text("mean_power,size_error\n2600,\n,3\n")
    other = advising.saved_agent(tmp_path / "a.safetensors", advising.batch(advising.PLATE, 5))
    for wrong, message in (
        (words, "row 2 says something else of block 1 than it did before: give --restart"),
        ((*words[:3], 3, *words[4:]), "was written for another part: number of parts is 3, but was 2"),
        ((*words, "--policy", "E9000D0"), "was written with another policy"),
        ((*words, "--policy", "hindsight"), "cannot advise at a machine"),
        ((*words, "--policy", other), "was trained for plate_g82_x5"),
        ((*words, "--rows", "day"), "--rows is 'day', but must be block or part"),
        (("advise", program, "--follow"), "name it with --measurements"),
    ):
        status, _, err = grind(*wrong)
        assert status == 2 and message in err and err.count("\n") == 1, err
    status, out, _ = grind(*words, "--restart")
    assert status == 0 and out.startswith("part 1, N50")


def test_only_one_adviser_at_a_time_uses_a_state(grind: Grind, tmp_path: Path) -> None:
    program, state = advising.plate_in(tmp_path), tmp_path / "plate_g82.advise.json"
    (tmp_path / "link.json").symlink_to(state)
    (tmp_path / "m.csv").write_text("mean_power\n2500\n")
    words = ("advise", program, "--parts", 1, "--policy", "E12000D0", "--measurements", tmp_path / "m.csv")
    with locked_state(state):
        for more in ((), ("--state", tmp_path / "link.json"), ("--restart",)):
            status, out, err = grind(*words, *more)
            assert (status, out) == (2, "") and "another adviser works with" in err
        assert not state.exists()
    assert grind(*words)[0] == 0
    assert len(json.loads(state.read_text())["steps"]) == 1 and not list(tmp_path.glob(".grind*"))


def test_the_adviser_needs_no_torch_and_resumes_after_a_kill(tmp_path: Path, grind: Grind) -> None:
    code = "import sys; sys.modules['torch'] = None; from grind_env.cli import main; main(sys.argv[1:])"
    state, measured = tmp_path / "state.json", tmp_path / "measured.csv"
    measured.write_text("mean_power,size_error\n2500,\n")
    words = [sys.executable, "-c", code, "advise", str(advising.PLATE), "--parts", "2", "--json", "--state", str(state)]
    follow = [*words, "--measurements", str(measured), "--follow"]
    environment = os.environ | {"PYTHONPATH": str(Path(grind_env.__file__).parents[1])}
    with subprocess.Popen(follow, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None
        assert [json.loads(process.stdout.readline())["block"] for _ in range(2)] == [1, 2]
        status, _, err = grind("advise", advising.PLATE, "--parts", 2, "--state", state, "--measurements", measured)
        assert status == 2 and "another adviser works with" in err
        process.send_signal(signal.SIGKILL)
    ended = subprocess.run(words, input='{"size_error": 2}\n', capture_output=True, text=True, env=environment)
    assert ended.returncode == 0, ended.stderr
    assert [json.loads(line)["block"] for line in ended.stdout.splitlines()] == [2, 3]
    assert len(json.loads(state.read_text())["steps"]) == 2
