"""Names of environments, task files and programs; every way to step them gives the same numbers."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grind_env
from grind_env.errors import GrindError
from grind_env.policies.evaluation import episode_seeds, roll_out, start_episodes
from grind_env.policies.policy import Policy
from grind_env.policies.privileged_information import reveal
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.scripted.handbook import Handbook
from grind_env.policies.scripted.rules import Fixed
from tests.policies.harness import untuned

EXAMPLES = Path(grind_env.__file__).with_name("examples")
TASK = 'base = "oracle6"\nblocks = 3\n'
LOTS = "\n[lots]\nprobability = 0.5\ngrowth = 0.45\npressure = 0.08\nstock = 0.02\n"
#: a feedrate per revolution at a constant surface speed, which the control has to execute
BY_CONTROL = "N80 G80\nG00 Y20.\nG96 S1800\nG95 G01 Y2. F.05\nG94 F60."


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(name: str, text: str) -> str:
    Path(name).parent.mkdir(exist_ok=True)
    Path(name).write_text(text, encoding="utf-8")
    return name


def example(name: str) -> str:
    return (EXAMPLES / name).read_text(encoding="utf-8")


def test_an_edited_file_is_read_again() -> None:
    path = written("shop.toml", TASK)
    assert find_problem(path).simulation().task.blocks == 3
    written("shop.toml", TASK.replace("3", "6"))
    assert find_problem(path).simulation().task.blocks == 6


def test_a_problem_caches_its_simulation_and_is_pickled_by_name() -> None:
    problem = find_problem(written("shop.toml", TASK))
    assert problem.simulation() is problem.simulation()
    sent = pickle.dumps(problem)
    assert len(sent) < 1000
    assert pickle.loads(sent) == problem
    assert pickle.loads(sent).simulation().task.blocks == 3


@pytest.mark.parametrize("given", [("shop.toml", None), ("part.nc", None), ("part.nc", "other.toml")])
def test_a_problem_works_from_another_folder(
    given: tuple[str, str | None], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written("shop.toml", TASK)
    written("part.nc", example("plate_g82.nc"))
    for job in ("part.toml", "other.toml"):
        written(job, example("plate_g82.toml"))
    problem = find_problem(*given)
    (folder / "elsewhere").mkdir()
    monkeypatch.chdir(folder / "elsewhere")
    assert problem.simulation().task.blocks in (2, 3)
    assert find_problem(f"../{given[0]}", given[1] and f"../{given[1]}").simulation().task.blocks in (2, 3)


@pytest.mark.parametrize("name", ["power_limited.nc", "oracle6.toml", "Power_limited.toml", "wide_plates.nc"])
def test_a_file_named_like_a_task_of_the_package_is_refused(name: str) -> None:
    written(name, TASK if name.endswith(".toml") else example("plate_g82.nc"))
    with pytest.raises(GrindError, match=f"{name} has the name of a task of this package.*rename the file"):
        find_problem(name)


@pytest.mark.parametrize("name", ["shop.toml", "power_limited"])
@pytest.mark.parametrize("given", [{"job": "job.toml"}, {"parts": 30}])
def test_only_a_program_has_a_job_and_parts(name: str, given: dict[str, Any]) -> None:
    written("shop.toml", TASK)
    with pytest.raises(GrindError, match=f"'{name}' is no part program: leave out its job and its parts"):
        find_problem(name, **given)


@pytest.mark.parametrize("given", [{"parts": 0}, {"parts": 1001}, {"parts": None}, {"parts": "3"}, {"job": 5}])
def test_parts_and_a_job_of_a_wrong_type_are_refused(given: dict[str, Any]) -> None:
    with pytest.raises(GrindError, match=f"{next(iter(given))} is "):
        find_problem("grind/Job-v0", **given)


@pytest.mark.parametrize("name", [None, 5, Path("shop.toml"), b"shop.toml", ["shop.toml"], "x" * 5000, "a\0b", ""])
def test_an_invalid_problem_name_gives_a_short_message(name: Any) -> None:
    with pytest.raises(GrindError) as raised:
        grind_env.evaluate("handbook", name, episodes=2)
    assert len(str(raised.value)) < 400


def test_a_file_with_an_unprintable_name_is_refused() -> None:
    with pytest.raises(GrindError, match="has a name that cannot be printed: rename the file"):
        find_problem(written("a\nb.toml", TASK))


def problems() -> dict[str, Problem]:
    """Return problems of every kind; write their files into the current folder."""
    written("part.nc", example("plate_g82.nc"))
    written("rev.nc", example("plate_g82.nc").replace("N80 G80", BY_CONTROL))
    for job in ("part.toml", "rev.toml"):
        written(job, example("plate_g82.toml") + LOTS)
    written("shop.toml", TASK)
    return {
        **{name: find_problem(name) for name in ("reciprocation", "wide_plates", "shop.toml")},
        "part.nc": find_problem("part.nc", parts=3),
        "rev.nc": find_problem("rev.nc", parts=2),
    }


def stepped(policy: Policy, problem: Problem, seed: int) -> list[float]:
    """Step the environment; return cost and good parts of an episode."""
    env: Any = problem.make(info="full").unwrapped
    policy.begin(env.simulation, 1)
    observation, _ = env.reset(seed=seed)
    over, totals = False, np.zeros(2)
    while not over:
        decision = policy.act(observation[None], reveal(policy.sees, env.simulation, env.episodes))
        observation, _, over, _, info = env.step(env.codec.encode(*decision)[0])
        totals += info["block_cost"], info["good_parts"]
    return [float(value) for value in totals]


@pytest.mark.parametrize("name", ["reciprocation", "wide_plates", "shop.toml", "part.nc", "rev.nc"])
@pytest.mark.parametrize("rule", ["handbook", "full_state_rule"])
def test_an_evaluation_equals_stepping_and_leaves_the_episodes_unchanged(name: str, rule: str) -> None:
    problem, seeds = problems()[name], episode_seeds("evaluation", 2)
    simulation = problem.simulation()
    assert simulation.compiled == (name != "rev.nc")
    policy: Policy = Handbook() if rule == "handbook" else untuned(rule, simulation)
    episodes = start_episodes(simulation, seeds)
    before = {key: table.copy() for key, table in episodes.arrays().items()}
    run = roll_out(policy, simulation, episodes)
    for key, table in before.items():
        np.testing.assert_array_equal(episodes.arrays()[key], table)
    for number, seed in enumerate(seeds):
        assert stepped(policy, problem, seed) == pytest.approx([run.cost[number], run.good[number]], rel=1e-9)


@pytest.mark.parametrize("policy", [None, 5, Path("a.safetensors"), Fixed, object()])
def test_other_objects_are_refused_as_policies(policy: Any) -> None:
    with pytest.raises(GrindError, match="is no policy: give one"):
        grind_env.evaluate(policy, "oracle6", episodes=2)


@pytest.mark.parametrize("name", ["x" * 5000 + ".safetensors", "E12D" + "9" * 5000])
def test_a_very_long_policy_name_gives_a_short_message(name: str) -> None:
    with pytest.raises(GrindError) as raised:
        grind_env.evaluate(name, "oracle6", episodes=2)
    assert len(str(raised.value)) < 500


@pytest.mark.parametrize(
    "given",
    [
        *({"episodes": value} for value in (None, 2.0, "3", True, -1, 1, float("nan"))),
        *({"first_seed": value} for value in (2.0, "3", True, -1, float("nan"))),
        {"seeds": ["evaluation"]},
        {"split": ["all"]},
    ],
    ids=str,
)
def test_counts_seeds_and_splits_of_a_wrong_type_are_refused(given: dict[str, Any]) -> None:
    with pytest.raises(
        GrindError, match=r"must be a whole number|have no interval|first seed is -1|are no seeds|must be one of all,"
    ):
        grind_env.evaluate("handbook", "oracle6", **{"episodes": 2, **given})


def test_a_policy_with_an_unknown_sees_value_is_refused() -> None:
    policy: Any = Fixed(9000.0, 1)
    policy.sees = "everything"
    with pytest.raises(GrindError, match="constant sees 'everything', but must see one of measurements, state, future"):
        grind_env.evaluate(policy, "oracle6", episodes=2)
