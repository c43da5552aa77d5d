from pathlib import Path

import gymnasium as gym
import minari
import numpy as np
import pytest
import typer

from agents.commands import dataset as command
from agents.offline.dataset import PLACE, make_dataset, recorded
from grind_env.errors import GrindError
from grind_env.files import FileError
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.problem import find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.scripted.handbook import Handbook
from grind_env.scores import normalise

NAME = "grind/oracle6/adaptive-rule-v0"
PROBLEM = find_problem("oracle6")
ORACLE = PROBLEM.simulation()
SEEDS = episode_seeds("training", 3)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(PLACE, str(tmp_path))
    return tmp_path


@pytest.mark.parametrize(
    ("task", "policy"),
    [("oracle6", "adaptive_rule"), ("rush", "random"), ("wide_plates", "handbook")],
)
def test_the_environment_gives_a_loaded_episode_again(task: str, policy: str, folder: Path):
    problem = find_problem(task)
    simulation = problem.simulation()
    path = make_dataset(make_policy(policy, simulation), problem, SEEDS)
    name = f"grind/{task}/{policy.replace('_', '-')}-v0"
    assert path == folder / name
    loaded = minari.load_dataset(name)
    steps = np.count_nonzero(~np.isnan(run_seeds(make_policy(policy, simulation), simulation, SEEDS).speeds))
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


def test_a_dataset_is_what_the_evaluation_of_its_policy_was():
    problem = find_problem("power_limited")
    simulation = problem.simulation()
    policy = make_policy("adaptive_rule", simulation)
    data, run = recorded(policy, problem, SEEDS), run_seeds(policy, simulation, SEEDS)
    assert [-simulation.task.reference_cost * each[2].sum() for each in data] == pytest.approx(run.cost)
    assert [each[3].sum() for each in data] == pytest.approx(run.finished - run.good)


def test_a_dataset_says_where_it_comes_from_and_how_it_is_scored():
    policy = make_policy("full_state_rule", ORACLE)
    make_dataset(policy, PROBLEM, SEEDS)
    loaded = minari.load_dataset("grind/oracle6/full-state-rule-v0")
    metadata = loaded.storage.metadata
    assert (metadata["policy"], metadata["policy_sees"]) == ("full_state_rule", "state")
    assert (metadata["made_with"]["seeds"], metadata["split"]) == ("0..2", "all")
    assert metadata["code_permalink"] == metadata["made_with"]["commit"]
    returns = np.array([episode.rewards.sum() for episode in loaded.iterate_episodes()])
    assert 100.0 * minari.get_normalized_score(loaded, returns) == pytest.approx(
        [normalise("grind/Oracle6-v0", each) for each in returns]
    )
    assert loaded.env_spec is not None
    # a full observation would show the state to an agent that is to see measurements
    assert gym.make(loaded.env_spec).observation_space != gym.make("grind/Oracle6-v0").observation_space


def test_a_dataset_is_replaced_on_request_only(folder: Path):
    policy = make_policy("adaptive_rule", ORACLE)
    make_dataset(policy, PROBLEM, SEEDS)
    for others in (SEEDS[:1], episode_seeds("validation", 3)):
        with pytest.raises(
            GrindError, match=r"there is a dataset grind/oracle6/adaptive-rule-v0 in .* already: --fresh"
        ):
            make_dataset(policy, PROBLEM, others)
    make_dataset(policy, PROBLEM, SEEDS[:1], fresh=True)
    assert minari.load_dataset(NAME).total_episodes == 1
    assert list(minari.list_local_datasets()) == [NAME]
    assert [each.name for each in folder.iterdir()] == ["grind"]


def test_a_folder_that_cannot_be_is_told_in_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv(PLACE, str(tmp_path / "file" / "datasets"))
    with pytest.raises(FileError, match=r"datasets \(Not a directory\): make room, or name another folder in MINARI"):
        make_dataset(make_policy("handbook", ORACLE), PROBLEM, SEEDS)


def test_a_dataset_that_cannot_be_written_leaves_the_one_before(folder: Path, monkeypatch: pytest.MonkeyPatch):
    def full(*_: object, **__: object) -> None:
        raise OSError(27, "File too large")

    path = make_dataset(make_policy("adaptive_rule", ORACLE), PROBLEM, SEEDS)
    before = {each: each.read_bytes() for each in folder.rglob("*") if each.is_file()}
    monkeypatch.setattr(minari, "create_dataset_from_buffers", full)
    with pytest.raises(FileError, match=r"cannot be written to .* \(File too large\): make room"):
        make_dataset(make_policy("adaptive_rule", ORACLE), PROBLEM, SEEDS[:1], fresh=True)
    assert {each: each.read_bytes() for each in folder.rglob("*") if each.is_file()} == before and path.exists()


def said(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """What the command prints."""
    app = typer.Typer()
    command.register(app)
    app(words, standalone_mode=False)
    return capsys.readouterr().out


def test_the_command(folder: Path, capsys: pytest.CaptureFixture[str]):
    printed = said(capsys, "--task", "oracle6", "--episodes", "2", "--policy", "E21D1")
    assert "12 steps" in printed
    assert str(folder) in printed
    (name,) = minari.list_local_datasets()
    assert name in printed


def test_a_task_file_is_recorded_from_the_folder_that_it_is_in(folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(folder)
    Path("my shop.toml").write_text('base = "oracle6"', encoding="utf-8")
    problem = find_problem("my shop.toml")
    path = make_dataset(Handbook(), problem, SEEDS)
    assert path == folder / "grind" / "my-shop" / "handbook-v0"
    monkeypatch.chdir(folder / "grind")
    env = minari.load_dataset("grind/my-shop/handbook-v0").recover_environment()
    assert env.unwrapped.task.name == "my shop"
