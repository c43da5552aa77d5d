from pathlib import Path

import gymnasium as gym
import minari
import numpy as np
import pytest
import typer

from agents.commands import dataset as command
from agents.datasets import make_dataset, recorded
from agents.evaluate import episode_seeds, evaluate
from agents.registry import make_policy
from grind_env.envs.tasks import load_task
from grind_env.errors import GrindError
from grind_env.scores import normalise

NAME = "grind/oracle6/adaptive-rule-v0"
TASK = load_task("oracle6")
SEEDS = episode_seeds("training", 3)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    return tmp_path


@pytest.mark.parametrize(("task", "policy"), [("oracle6", "adaptive_rule"), ("rush", "random")])
def test_the_environment_gives_a_loaded_episode_again(task: str, policy: str, folder: Path):
    job = load_task(task)
    path = make_dataset(make_policy(policy, job), job, SEEDS)
    name = f"grind/{task}/{policy.replace('_', '-')}-v0"
    assert path == folder / name
    loaded = minari.load_dataset(name)
    assert (loaded.total_episodes, loaded.total_steps) == (3, 3 * job.blocks)
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


def test_a_dataset_is_what_the_evaluation_of_its_policy_was():
    job = load_task("power_limited")
    policy = make_policy("adaptive_rule", job)
    data, run = recorded(policy, job, SEEDS), evaluate(policy, job, SEEDS)
    assert -job.reference_cost * data.rewards.sum(axis=1) == pytest.approx(run.cost)
    assert data.scrap.sum(axis=1) == pytest.approx(run.finished - run.good)


def test_a_dataset_says_where_it_comes_from_and_how_it_is_scored():
    policy = make_policy("full_state_rule", TASK)
    make_dataset(policy, TASK, SEEDS)
    loaded = minari.load_dataset("grind/oracle6/full-state-rule-v0")
    metadata = loaded.storage.metadata
    assert (metadata["policy"], metadata["policy_sees"]) == ("full_state_rule", "state")
    assert metadata["made_with"]["seeds"] == "0..2"
    assert metadata["code_permalink"] == metadata["made_with"]["commit"]
    returns = np.array([episode.rewards.sum() for episode in loaded.iterate_episodes()])
    assert 100.0 * minari.get_normalized_score(loaded, returns) == pytest.approx(
        [normalise("grind/Oracle6-v0", each) for each in returns]
    )
    assert loaded.env_spec is not None
    # a full observation would show the state to an agent that is to see measurements
    assert gym.make(loaded.env_spec).observation_space != gym.make("grind/Oracle6-v0").observation_space


def test_a_dataset_is_replaced_on_request_only(folder: Path):
    policy = make_policy("adaptive_rule", TASK)
    make_dataset(policy, TASK, SEEDS)
    with pytest.raises(GrindError, match=r"there is a dataset grind/oracle6/adaptive-rule-v0 in .* already: --fresh"):
        make_dataset(policy, TASK, SEEDS)
    make_dataset(policy, TASK, SEEDS[:1], fresh=True)
    assert minari.load_dataset(NAME).total_episodes == 1
    assert list(minari.list_local_datasets()) == [NAME]
    assert [each.name for each in folder.iterdir()] == ["grind"]


def test_a_dataset_that_fails_leaves_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object, **__: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(minari, "create_dataset_from_buffers", fail)
    with pytest.raises(OSError, match="no space left"):
        make_dataset(make_policy("adaptive_rule", TASK), TASK, SEEDS)
    assert not [each for each in folder.rglob("*") if each.is_file()]
    assert not (folder / NAME).exists()


def test_the_command(folder: Path, capsys: pytest.CaptureFixture[str]):
    app = typer.Typer()
    command.register(app)
    app(["--task", "oracle6", "--episodes", "2", "--policy", "E21D1"], standalone_mode=False)
    printed = capsys.readouterr().out
    assert "12 steps" in printed
    assert str(folder) in printed
    (name,) = minari.list_local_datasets()
    assert name in printed
