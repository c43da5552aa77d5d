"""`grind play --output`: program and job beside it, which `grind run` grinds to what the episode was."""

import json
from pathlib import Path

import numpy as np
import pytest

import grind_env
from grind_env.policies.play import play
from grind_env.policies.problem import find_problem
from grind_env.policies.scripted.rules import Fixed
from tests.command import status as ended
from tests.examples import few, nightly

EXAMPLES = Path(grind_env.__file__).parent / "examples"
SEED = 2_000_004


def outcomes(problem, policy: str) -> list:
    """The outcomes of the episode, block by block, from the environment."""
    env = problem.make().unwrapped
    env.reset(seed=SEED)
    speed, dresses = policy[1:].split("D")
    over = False
    while not over:
        action = env.codec.encode(np.array([float(speed)]), np.array([float(dresses)]))[0]
        over = env.step(action)[2]
    return env.outcomes


@pytest.mark.parametrize("name", few(["power_limited", "wide_rails", "rush", "CBN", "wide_plates", "oracle6", "job"]))
def test_grind_run_of_both_shows_the_numbers_of_the_episode(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, policy = tmp_path / "played.nc", "E9000D1"
    if name == "job":
        problem = find_problem(str(EXAMPLES / "rail_g83.nc"), None, 4)
        named = ("--program", EXAMPLES / "rail_g83.nc", "--parts", 4)
    else:
        problem, named = find_problem(name), ("--task", name)
    assert ended("play", *named, "--policy", policy, "--seed", SEED, "--output", path) == 0
    capsys.readouterr()
    ended("run", path, "--json")
    found = json.loads(capsys.readouterr().out)
    wanted = [each for each in outcomes(problem, policy) if each.finished > 0.0]
    parts = found["parts"]
    assert len(parts) == len(wanted) > 1
    for key, field in (("Ra", "roughness"), ("survival", "good")):
        np.testing.assert_allclose(
            [part[key] for part in parts], [getattr(each, field) for each in wanted], rtol=1e-7, atol=1e-9
        )
    played = play(Fixed(9000.0, 1), problem, SEED)
    assert found["good_parts"] == pytest.approx(played.good)
    assert sum(part["dresses"] for part in parts) == played.dresses
    if name in ("power_limited", "oracle6"):
        # a block a part: all but the wheel that is handed over is what the program costs
        assert sum(part["total_cost"] for part in parts) + played.handover == pytest.approx(played.cost)
    assert len({part["Ra"] for part in parts}) > 1 or name == "oracle6"


@pytest.mark.parametrize("base", ["power_limited", nightly("reciprocation"), nightly("wide_plates")])
def test_grind_run_of_what_a_task_of_ones_own_was_played_as_costs_what_the_episode_cost(
    base: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    task, path = tmp_path / "mine.toml", tmp_path / "played.nc"
    task.write_text(f'title = "Mine"\nbase = "{base}"\nblocks = 6\n')
    assert ended("play", "--task", task, "--policy", "E9000D1", "--seed", SEED, "--output", path) == 0
    told = capsys.readouterr().out
    # where the operator asks for the dresses, the files cannot say so, but the command that is told does
    asked = told.partition(f"grind run {path}")[2].partition("\n")[0].split()
    played = play(Fixed(9000.0, 1), find_problem(str(task)), SEED)
    assert asked.count("--dress-at") == len(played.requests) == (6 if base == "reciprocation" else 0)
    ended("run", path, *asked, "--json")
    found = json.loads(capsys.readouterr().out)
    assert sum(part["dresses"] for part in found["parts"]) == played.dresses == 6
    cost = sum(part["total_cost"] for part in found["parts"])
    assert cost + played.handover == pytest.approx(played.cost, rel=1e-6)
    assert found["good_parts"] == pytest.approx(played.good)


@pytest.mark.parametrize("seed", [2_000_000, 2_000_010])
def test_where_the_operator_asks_for_dresses_it_is_told_when(
    seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # in these episodes infeeds end within a ms after the table has turned: a request before that is met elsewhere
    path = tmp_path / "played.nc"
    assert ended("play", "--task", "reciprocation", "--policy", "E9000D1", "--seed", seed, "--output", path) == 0
    told = capsys.readouterr().out
    command, _, _ = told.partition("grind run ")[2].partition("\n")
    assert command.startswith(str(path))
    options = command.removeprefix(str(path)).split()
    ended("run", path, *options, "--json")
    found = json.loads(capsys.readouterr().out)
    assert sum(part["dresses"] for part in found["parts"]) == options.count("--dress-at") > 1
    played = play(Fixed(9000.0, 1), find_problem("reciprocation"), seed)
    cost = sum(part["total_cost"] for part in found["parts"])
    assert cost + played.handover == pytest.approx(played.cost, rel=1e-9)


def test_a_program_under_the_name_of_its_job_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ended("play", "--task", "oracle6", "--policy", "E9000D1", "--output", tmp_path / "played.toml") == 2
    assert "is the name of what is written beside it, too; name another file with --output" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_job_is_written_over_its_own_kind_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, job = tmp_path / "played.nc", tmp_path / "played.toml"
    words = ("play", "--task", "oracle6", "--policy", "E9000D1", "--output", path)
    job.write_text("# mine\n")
    assert ended(*words) == 2
    assert "played.toml, written beside" in capsys.readouterr().err
    assert (job.read_text(), path.exists()) == ("# mine\n", False)
    job.unlink()
    assert ended(*words) == 0
    written = job.read_bytes()
    assert ended(*words) == 0
    assert job.read_bytes() == written
    words = ("play", "--program", path, "--job", job, "--policy", "E9000D1")
    assert ended(*words, "--output", tmp_path / "played.ngc") == 2
    assert "is read here and would be lost" in capsys.readouterr().err


def test_a_job_that_lists_its_parts_is_no_batch(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "played.nc"
    assert ended("play", "--task", "oracle6", "--policy", "E9000D1", "--output", path) == 0
    assert ended("play", "--program", path, "--policy", "E9000D1", "--no-window") == 2
    assert "[[parts]]" in capsys.readouterr().err


def test_parts_of_several_kinds_are_told_by_their_own_limits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "played.nc"
    assert ended("play", "--task", "rush", "--policy", "E12000D1", "--seed", 3, "--output", path) == 0
    capsys.readouterr()
    ended("run", path, "--json")
    parts = json.loads(capsys.readouterr().out)["parts"]
    scrap = [part for part in parts if part["survival"] < 0.5]
    assert scrap and all(part["beyond"] for part in scrap)
    assert all(part["survival"] < 0.6 for part in parts if part["beyond"])
