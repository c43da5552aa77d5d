"""Datasets of Minari: their content, their origin and their error messages."""

import shutil
from pathlib import Path

import gymnasium as gym
import minari
import numpy as np
import pytest

from agents.commands.dataset import PLACE, make_dataset
from grind_env.errors import GrindError
from grind_env.files import FileError
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.scripted.handbook import Handbook
from grind_env.score_scale import normalise

PROBLEM = find_problem("oracle6")
ORACLE = PROBLEM.simulation()
SEEDS = episode_seeds("training", 3)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(PLACE, str(tmp_path))
    return tmp_path


@pytest.mark.parametrize(
    ("task", "policy"), [("oracle6", "adaptive_rule"), ("rush", "random"), ("wide_plates", "handbook")]
)
def test_the_environment_repeats_a_loaded_episode(task: str, policy: str, folder: Path) -> None:
    problem = find_problem(task)
    simulation = problem.simulation()
    name = f"grind/{task}/{policy.replace('_', '-')}-v0"
    assert make_dataset(make_policy(policy, simulation), problem, SEEDS).id == name
    assert (folder / name).is_dir()
    loaded = minari.load_dataset(name)
    run = run_seeds(make_policy(policy, simulation), simulation, SEEDS)
    rewards, scrap = np.array([(each.rewards.sum(), each.infos["cost"].sum()) for each in loaded.iterate_episodes()]).T
    assert -simulation.task.reference_cost * rewards == pytest.approx(run.cost)
    assert scrap == pytest.approx(run.finished - run.good)
    steps = np.count_nonzero(~np.isnan(run.speeds))
    assert (loaded.total_episodes, loaded.total_steps) == (3, steps)
    assert steps == 3 * simulation.task.blocks
    env = loaded.recover_environment()
    assert env.unwrapped.observation_space == loaded.observation_space
    assert env.action_space == loaded.action_space
    for episode, seed in zip(loaded.iterate_episodes(), SEEDS, strict=True):
        assert next(iter(loaded.storage.get_episode_metadata([episode.id])))["seed"] == seed
        observation, _ = env.reset(seed=seed)
        for k, action in enumerate(episode.actions):
            assert np.array_equal(observation, episode.observations[k])
            observation, reward, terminated, truncated, info = env.step(action)
            assert reward == episode.rewards[k]
            assert info["cost"] == pytest.approx(episode.infos["cost"][k + 1], abs=1e-15)
            assert (terminated, truncated) == (episode.terminations[k], episode.truncations[k])
        assert np.array_equal(observation, episode.observations[-1])
        assert terminated


def test_a_dataset_records_its_origin_and_its_score_scale() -> None:
    policy = make_policy("full_state_rule", ORACLE)
    make_dataset(policy, PROBLEM, SEEDS)
    loaded = minari.load_dataset("grind/oracle6/full-state-rule-v0")
    metadata = loaded.storage.metadata
    assert (metadata["algorithm_name"], metadata["policy_sees"]) == ("full_state_rule", "state")
    assert (metadata["made_with"]["seeds"], metadata["split"]) == ("0..2", "all")
    assert metadata["code_permalink"] == metadata["made_with"]["commit"]
    returns = np.array([episode.rewards.sum() for episode in loaded.iterate_episodes()])
    assert 100.0 * minari.get_normalized_score(loaded, returns) == pytest.approx(
        [normalise("grind/Oracle6-v0", each) for each in returns]
    )
    assert loaded.env_spec is not None
    # the recorded environment must not show the state to an agent on measurements
    assert gym.make(loaded.env_spec).observation_space != gym.make("grind/Oracle6-v0").observation_space


def test_a_dataset_is_not_replaced() -> None:
    policy = make_policy("adaptive_rule", ORACLE)
    make_dataset(policy, PROBLEM, SEEDS)
    with pytest.raises(GrindError, match=r"there is a dataset grind/oracle6/adaptive-rule-v0 in .*: delete it"):
        make_dataset(policy, PROBLEM, SEEDS[:1])
    assert minari.load_dataset("grind/oracle6/adaptive-rule-v0").total_episodes == 3


def test_an_impossible_folder_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(PLACE, str(tmp_path / "file" / "datasets"))
    with pytest.raises(FileError, match=r"datasets \(Not a directory\): make room"):
        make_dataset(make_policy("handbook", ORACLE), PROBLEM, SEEDS)


def test_a_full_disk_is_refused_before_anything_is_written(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    policy, free = make_policy("adaptive_rule", ORACLE), shutil.disk_usage(folder)
    with monkeypatch.context() as patched, pytest.raises(FileError, match=r"\(it needs 0\.1 MB\): make room"):
        patched.setattr(shutil, "disk_usage", lambda path: free._replace(free=10_000))
        make_dataset(policy, PROBLEM, SEEDS)
    assert list(folder.iterdir()) == []
    path = folder / make_dataset(policy, PROBLEM, SEEDS).id
    assert sum(each.stat().st_size for each in path.rglob("*") if each.is_file()) < 100_000
    assert [each.name for each in folder.iterdir()] == ["grind"]


def test_a_dataset_of_a_task_file_works_from_another_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    Path("my shop.toml").write_text('base = "oracle6"', encoding="utf-8")
    problem = find_problem("my shop.toml")
    assert make_dataset(Handbook(), problem, SEEDS).id == "grind/my-shop/handbook-v0"
    monkeypatch.chdir(folder / "grind")
    env = minari.load_dataset("grind/my-shop/handbook-v0").recover_environment()
    assert env.unwrapped.task.name == "my shop"
