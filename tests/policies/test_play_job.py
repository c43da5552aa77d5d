"""`grind play --output` writes a program and its job, with which `grind run` repeats the episode."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grind_env import examples
from grind_env.policies.played_episodes import play
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.scripted.rules import Fixed
from tests.command import Grind
from tests.examples import few, nightly

RAIL = examples.path("rail_g83.nc")
SEED, PLAN = 2_000_004, Fixed(9000.0, 1)
ORACLE = ("play", "--task", "oracle6", "--policy", "E9000D1", "--output")

Played = Callable[..., tuple[list[str], dict[str, Any]]]


@pytest.fixture
def played(grind: Grind, tmp_path: Path) -> Played:
    """Return a function that plays an episode into a program and runs it: suggested options and results."""

    def call(*words: object, policy: str = "E9000D1", seed: int = SEED) -> tuple[list[str], dict[str, Any]]:
        path = tmp_path / "played.nc"
        status, told, _ = grind("play", *words, "--policy", policy, "--seed", seed, "--output", path)
        assert status == 0
        options = told.partition(f"grind run {path}")[2].partition("\n")[0].split()
        return options, json.loads(grind("run", path, *options, "--json")[1])

    return call


def finished_parts(problem: Problem) -> list[Any]:
    """Return the outcomes of the blocks that finish a part, from the environment."""
    env: Any = problem.make().unwrapped
    env.reset(seed=SEED)
    action, over = env.codec.encode(np.array([9000.0]), np.array([1.0]))[0], False
    while not over:
        over = env.step(action)[2]
    return [each for each in env.outcomes if each.finished > 0.0]


@pytest.mark.parametrize("name", few(["power_limited", "wide_rails", "rush", "CBN", "wide_plates", "oracle6", "job"]))
def test_grind_run_repeats_the_numbers_of_a_played_episode(name: str, played: Played) -> None:
    problem = find_problem(str(RAIL), None, 4) if name == "job" else find_problem(name)
    _, found = played(*(("--program", RAIL, "--parts", 4) if name == "job" else ("--task", name)))
    parts, wanted, episode = found["parts"], finished_parts(problem), play(PLAN, problem, SEED)
    assert len(parts) == len(wanted) > 1
    for key, field in (("Ra", "roughness"), ("survival", "good")):
        np.testing.assert_allclose(
            [part[key] for part in parts], [getattr(each, field) for each in wanted], rtol=1e-7, atol=1e-9
        )
    assert found["good_parts"] == pytest.approx(episode.good)
    assert sum(part["dresses"] for part in parts) == episode.dresses
    if name in ("power_limited", "oracle6"):
        # one block a part: the program costs as much as the episode without the handover
        assert sum(part["total_cost"] for part in parts) + episode.handover == pytest.approx(episode.cost)
    assert len({part["Ra"] for part in parts}) > 1 or name == "oracle6"


@pytest.mark.parametrize(
    ("base", "own", "seed"),
    [
        ("power_limited", True, SEED),
        nightly("wide_plates", True, SEED),
        # here infeeds end within 1 ms after the table has turned: an earlier request is served at another place
        ("reciprocation", False, 2_000_000),
        ("reciprocation", False, 2_000_010),
    ],
)
def test_grind_run_costs_as_much_as_the_episode_with_requested_dresses(
    base: str, own: bool, seed: int, played: Played, tmp_path: Path
) -> None:
    task = tmp_path / "mine.toml"
    task.write_text(f'title = "Mine"\nbase = "{base}"\nblocks = 6\n')
    named = str(task) if own else base
    # the files cannot hold the requests of an operator for dresses, but the suggested command does
    options, found = played("--task", named, seed=seed)
    episode = play(PLAN, find_problem(named), seed)
    assert options.count("--dress-at") == len(episode.requests)
    assert bool(episode.requests) == (base == "reciprocation")
    assert sum(part["dresses"] for part in found["parts"]) == episode.dresses >= 6
    cost = sum(part["total_cost"] for part in found["parts"])
    assert cost + episode.handover == pytest.approx(episode.cost, rel=1e-6 if own else 1e-9)
    assert found["good_parts"] == pytest.approx(episode.good)


def test_play_overwrites_only_jobs_written_by_play(tmp_path: Path, grind: Grind) -> None:
    path, job = tmp_path / "played.nc", tmp_path / "played.toml"
    job.write_text("# mine\n")
    status, _, err = grind(*ORACLE, path)
    assert status == 2 and "played.toml, written beside" in err
    assert (job.read_text(), path.exists()) == ("# mine\n", False)
    job.unlink()
    assert grind(*ORACLE, path)[0] == 0
    written = job.read_bytes()
    assert grind(*ORACLE, path)[0] == 0 and job.read_bytes() == written
    # a job that lists its parts is no batch
    status, _, err = grind("play", "--program", path, "--policy", "E9000D1", "--no-window")
    assert status == 2 and "[[parts]]" in err


def test_parts_of_several_kinds_are_judged_by_their_own_limits(played: Played) -> None:
    parts = played("--task", "rush", policy="E12000D1", seed=3)[1]["parts"]
    scrap = [part for part in parts if part["survival"] < 0.5]
    assert scrap and all(part["beyond"] for part in scrap)
    assert all(part["survival"] < 0.6 for part in parts if part["beyond"])
