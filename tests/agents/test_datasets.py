import fcntl
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from pathlib import Path

import gymnasium as gym
import minari
import numpy as np
import pytest
import typer

from agents.commands import dataset as command
from agents.offline import dataset as datasets
from agents.offline.dataset import alone, holds, make_dataset, recorded
from agents.offline.writer import PLACE, Content, Recorded, write, write_apart
from grind_env.errors import GrindError
from grind_env.files import FileError
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.problem import find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.scripted.handbook import Handbook
from grind_env.scores import normalise
from tests.agents.killing import kill_until_done

NAME = "grind/oracle6/adaptive-rule-v0"
PROBLEM = find_problem("oracle6")
ORACLE = PROBLEM.simulation()
SEEDS = episode_seeds("training", 3)
ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(PLACE, str(tmp_path))
    return tmp_path


def write_here(content: Content, folder: Path, _lock: int) -> None:
    """In place of `write_apart`: writes in this process, for a start of Minari in another takes seconds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(PLACE, str(folder))
        write(content)


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(datasets, "write_apart", write_here)


@pytest.mark.usefixtures("here")
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
    assert -simulation.task.reference_cost * data.rewards.sum(axis=1) == pytest.approx(run.cost)
    assert data.scrap.sum(axis=1) == pytest.approx(run.finished - run.good)


@pytest.mark.usefixtures("here")
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


@pytest.mark.usefixtures("here")
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
    with pytest.raises(FileError, match=r"datasets \(Not a directory\): it needs about .* another folder in MINARI"):
        make_dataset(make_policy("handbook", ORACLE), PROBLEM, SEEDS)


@pytest.mark.usefixtures("here")
def test_a_dataset_that_is_there_already_stays_as_it_is(folder: Path):
    policy = make_policy("adaptive_rule", ORACLE)
    before = files(make_dataset(policy, PROBLEM, SEEDS))
    assert files(make_dataset(policy, PROBLEM, SEEDS)) == before


@pytest.mark.usefixtures("here")
def test_other_numbers_under_the_same_id_are_another_dataset(folder: Path):
    path = make_dataset(make_policy("adaptive_rule", ORACLE), PROBLEM, SEEDS)
    data = recorded(make_policy("adaptive_rule", ORACLE), PROBLEM, SEEDS)
    assert holds(path, SEEDS, "all", data)
    assert not holds(path, SEEDS, "inner", data)
    for name in data._fields:
        other = np.copy(getattr(data, name))
        other.flat[-1] -= 1.0 if name == "steps" else 0.5
        assert not holds(path, SEEDS, "all", data._replace(**{name: other}))
    assert not holds(path.parent, SEEDS, "all", data)


def files(path: Path) -> dict[Path, tuple[bytes, int]]:
    """Content and time of every file below a folder."""
    return {
        each.relative_to(path): (each.read_bytes(), each.stat().st_mtime_ns)
        for each in path.rglob("*")
        if each.is_file()
    }


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """Let no file become larger for a while, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("seen", ["before the recording", "while it is written"])
def test_a_full_disk_is_one_sentence_and_nothing_is_lost(seen: str, folder: Path, monkeypatch: pytest.MonkeyPatch):
    policy, many = make_policy("adaptive_rule", ORACLE), episode_seeds("training", 50)
    path = make_dataset(policy, PROBLEM, SEEDS)
    before, asked = files(folder), []

    def spied(*arguments: object) -> Recorded:
        asked.append(arguments)
        return recorded(*arguments)

    monkeypatch.setattr(datasets, "recorded", spied)
    if seen == "while it is written":
        # somebody else was quicker to fill it
        monkeypatch.setattr(datasets, "reserved", lambda path, size: nullcontext())
        monkeypatch.setattr(datasets, "write_apart", write_apart)
    with (
        largest_file(500_000),
        pytest.raises(
            FileError, match=r"cannot be written to .* \(File too large\): it needs about 1\.\d MB"
        ) as caught,
    ):
        make_dataset(policy, PROBLEM, many, fresh=True)
    assert str(caught.value).endswith("run the same command again")
    assert "\n" not in str(caught.value)
    assert bool(asked) == (seen == "while it is written")
    assert files(folder) == before
    assert make_dataset(policy, PROBLEM, many, fresh=True) == path
    assert minari.load_dataset(NAME).total_episodes == 50


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("task", "policy"), [("oracle6", "adaptive_rule"), ("power_limited", "random"), ("rush", "random")]
)
def test_what_is_asked_for_is_what_a_dataset_takes(task: str, policy: str, monkeypatch: pytest.MonkeyPatch):
    problem, sizes = find_problem(task), []

    def spied(path: Path, size: int) -> AbstractContextManager[None]:
        sizes.append(size)
        return nullcontext()

    monkeypatch.setattr(datasets, "reserved", spied)
    path = make_dataset(make_policy(policy, problem.simulation()), problem, episode_seeds("training", 30))
    taken = sum(each.stat().st_size for each in path.rglob("*") if each.is_file())
    assert taken <= sizes[0] <= 1.3 * taken


def test_a_fault_that_is_no_full_disk_keeps_its_name(folder: Path):
    content = Content(
        "no id", PROBLEM, "", "", "", SEEDS, "all", recorded(make_policy("adaptive_rule", ORACLE), PROBLEM, SEEDS)
    )
    with alone(folder / "lock") as lock, pytest.raises(RuntimeError, match="Malformed dataset ID"):
        write_apart(content, folder, lock)


def watch(count: Callable[..., None]) -> None:
    """Call a function before every step by which a file or a folder changes its name or comes or goes."""
    for module, name in [*((os, name) for name in ("open", "mkdir", "rename", "unlink", "rmdir")), (fcntl, "flock")]:
        step = getattr(module, name)

        def counted(*arguments: object, step: Callable[..., object] = step, **options: object) -> object:
            count()
            return step(*arguments, **options)

        setattr(module, name, counted)


def made(folder: Path, fresh: bool, seeds: range = SEEDS) -> None:
    """A dataset, written in the process itself, so that it can be killed there."""
    datasets.write_apart = write_here
    os.environ[PLACE] = str(folder)
    make_dataset(make_policy("adaptive_rule", ORACLE), PROBLEM, seeds, fresh=fresh)


def kills(folder: Path, fresh: bool) -> int:
    """How often a dataset was killed, once at every step, before it was made."""
    return kill_until_done(partial(made, folder, fresh), watch, 0.0)


def test_a_dataset_killed_at_every_step_ends_as_one_that_was_not(folder: Path):
    script = (
        "import sys; from pathlib import Path\n"
        "from tests.agents.test_datasets import SEEDS, kills, made\n"
        "folder = Path(sys.argv[1])\n"
        "made(folder / 'whole', False)\n"
        "made(folder / 'replaced', False, SEEDS[:2])\n"
        "print(kills(folder / 'new', False), kills(folder / 'replaced', True))\n"
    )
    run = subprocess.run([sys.executable, "-c", script, folder], cwd=ROOT, capture_output=True, text=True, check=True)
    assert min(map(int, run.stdout.split())) > 20
    whole, *killed = (
        {path: content for path, (content, _) in files(folder / name).items()} for name in ("whole", "new", "replaced")
    )
    assert killed == [whole, whole]


KILLED = """
import os, signal, subprocess, sys, time
from pathlib import Path
from types import SimpleNamespace

from agents.__main__ import main
from agents.offline import writer


def run(command, *, input, check, **options):
    process = subprocess.Popen(command, stdin=subprocess.PIPE, **options)
    process.stdin.write(input)
    process.stdin.close()
    while not any(each.stat().st_size > 0 for each in Path({folder!r}).rglob("*.hdf5")):
        assert not process.poll(), process.stderr.read()
        time.sleep(0.005)
    os.kill(os.getpid(), signal.SIGKILL)


writer.subprocess = SimpleNamespace(run=run, PIPE=subprocess.PIPE)
sys.argv = {words!r}
main()
"""
"""The command, which ends itself as soon as a part of the dataset is on the disk, however busy the machine is."""


@pytest.mark.usefixtures("here")
def test_a_command_killed_while_its_dataset_is_written_goes_on(folder: Path, capsys: pytest.CaptureFixture[str]):
    words = ["--task", "oracle6", "--episodes", "50"]
    script = KILLED.format(folder=str(folder), words=["agents", "dataset", *words])
    first = subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=False)
    assert first.returncode == -signal.SIGKILL
    assert list(folder.rglob(".grind-*"))
    again = said(capsys, *words)
    assert "300 steps" in again
    assert minari.load_dataset(NAME).total_episodes == 50
    assert list(folder.rglob(".grind-*")) == []
    # and behind its end, too
    assert said(capsys, *words) == again


def said(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """What the command prints."""
    app = typer.Typer()
    command.register(app)
    app(words, standalone_mode=False)
    return capsys.readouterr().out


@pytest.mark.usefixtures("here")
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
