"""A training that is killed and started again ends in the very agent of one that was left alone."""

import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from agents.learning import train as training
from agents.learning.checkpoint import CheckpointError, Training, checkpoint_path, read_checkpoint, write_checkpoint
from agents.learning.curve import curve_path, read_curve
from agents.learning.settings import DEFAULTS
from agents.learning.train import new_model, train
from agents.learning.training_env import LearnerVecEnv
from grind_env.policies.problem import find_problem

PROBLEM = find_problem("oracle6")
TINY = {
    "ppo": replace(
        DEFAULTS["ppo"],
        steps=24 * 16,
        envs=4,
        hidden=(8,),
        hyper={**DEFAULTS["ppo"].hyper, "n_steps": 6, "batch_size": 24, "n_epochs": 2},
    ),
    "dqn": replace(
        DEFAULTS["dqn"],
        steps=24 * 16,
        envs=4,
        hidden=(8,),
        hyper={
            **DEFAULTS["dqn"].hyper,
            "buffer_size": 200,
            "learning_starts": 40,
            "batch_size": 16,
            "target_update_interval": 60,
        },
    ),
}
"""Settings of trainings of 96 steps of four environments, with a checkpoint every twelve."""


def trained(kind: str, folder: Path, fresh: bool = False) -> Path:
    """The file of an agent that was trained a little."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(training, "POINTS", 8)
        return train(PROBLEM, kind, 3, TINY[kind], folder, fresh=fresh, quiet=True)


def at_steps(count: Callable[[], None]) -> None:
    """Call a function before every step."""
    step = LearnerVecEnv.step_wait

    def counted(self: LearnerVecEnv) -> Any:
        count()
        return step(self)

    LearnerVecEnv.step_wait = counted


def at_writes(count: Callable[[], None]) -> None:
    """Call a function before every checkpoint takes the place of the last one."""
    replaced = Path.replace

    def counted(self: Path, target: Path) -> Path:
        if self.suffix == ".partial":
            count()
        return replaced(self, target)

    Path.replace = counted


KINDS = ["ppo", "dqn"]

KILLED = """
import sys
from functools import partial
from pathlib import Path
from torch.utils.tensorboard import SummaryWriter
from tests.agents.killing import ended
from tests.agents.test_checkpoint import KINDS, PROBLEM, TINY, at_steps, at_writes, new_model, trained

step, write = map(int, sys.argv[2:])
new_model(PROBLEM, "ppo", 0, TINY["ppo"])  # what is loaded here is not loaded again in every process
for kind in KINDS:
    work = partial(trained, kind, Path(sys.argv[1]) / kind)
    print(ended(work, at_steps, step), ended(work, at_writes, write))
"""
"""Begins a training of every kind, which is killed at a step, and again at a write."""


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with trainings that were killed twice."""
    folder, moments = tmp_path_factory.mktemp("killed"), np.random.default_rng()
    command = [sys.executable, "-c", KILLED, folder, str(moments.integers(30, 60)), str(moments.integers(1, 4))]
    run = subprocess.run(command, cwd=Path(__file__).parents[2], capture_output=True, text=True, check=True)
    assert set(run.stdout.split()) == {str(-signal.SIGKILL)}, run.stderr
    return folder


@pytest.mark.bits
@pytest.mark.parametrize("kind", KINDS)
def test_a_killed_training_goes_on_bit_by_bit(kind: str, killed: Path, tmp_path: Path):
    whole = trained(kind, tmp_path)
    (checkpoint,) = (killed / kind / PROBLEM.name).glob("*.checkpoint")
    steps = read_checkpoint(checkpoint).model.num_timesteps
    assert 0 < steps < TINY[kind].steps
    resumed = trained(kind, killed / kind)
    assert resumed.name == whole.name
    assert resumed.read_bytes() == whole.read_bytes()
    for one, other in zip(read_curve(curve_path(whole)), read_curve(curve_path(resumed)), strict=True):
        assert (one.steps, one.reward, one.cost) == (other.steps, other.reward, other.cost)
    left = sorted(path.name for path in resumed.parent.iterdir())
    assert left == sorted([resumed.name, curve_path(resumed).name, "tensorboard"])


@pytest.mark.parametrize("kind", KINDS)
def test_a_checkpoint_changes_nothing_and_holds_everything(kind: str, tmp_path: Path):
    model = new_model(PROBLEM, kind, 0, TINY[kind])
    model.learn(48)
    path = tmp_path / "a.checkpoint"
    write_checkpoint(path, Training(model, [], {"all": 1.5}))
    model.learn(120, reset_num_timesteps=False)
    drawn = np.random.random(), float(torch.rand(1))
    kept = read_checkpoint(path)
    assert kept.model.num_timesteps == 48
    assert kept.seconds == {"all": 1.5}
    kept.model.learn(120, reset_num_timesteps=False)
    for one, other in zip(model.policy.parameters(), kept.model.policy.parameters(), strict=True):
        assert torch.equal(one, other)
    assert (np.random.random(), float(torch.rand(1))) == drawn
    assert sorted(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_a_damaged_checkpoint_is_told(share: float, tmp_path: Path):
    path = tmp_path / "a.checkpoint"
    write_checkpoint(path, Training(new_model(PROBLEM, "ppo", 0, TINY["ppo"]), [], {}))
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(CheckpointError, match=r"a\.checkpoint is damaged"):
        read_checkpoint(path)


def test_a_checkpoint_that_cannot_be_written_is_told_and_stops_nothing_else(tmp_path: Path):
    model = new_model(PROBLEM, "ppo", 0, TINY["ppo"])
    model.learn(24)
    logger = model.logger
    with pytest.raises(CheckpointError, match=r"a\.checkpoint cannot be written \(.*\): ") as caught:
        write_checkpoint(tmp_path / "no folder" / "a.checkpoint", Training(model, [], {}))
    assert "\n" not in str(caught.value)
    assert model.logger is logger
    assert list(tmp_path.iterdir()) == []


def test_a_checkpoint_of_other_code_is_not_taken_up(tmp_path: Path):
    path = trained("ppo", tmp_path)
    whole = path.read_bytes()
    path.unlink()
    stem = path.with_suffix("")
    ours = checkpoint_path(stem)
    other = ours.with_name(f"{stem.name}-01234567.checkpoint")
    for left in (other, other.with_name(f".{other.name}.partial")):
        left.write_bytes(b"objects of other code")
    assert other != ours
    assert trained("ppo", tmp_path).read_bytes() == whole
    left_over = [each.name for each in path.parent.iterdir() if "checkpoint" in each.name]
    assert not left_over


def test_a_damaged_checkpoint_does_not_stop_a_fresh_training(tmp_path: Path):
    path = trained("ppo", tmp_path)
    path.unlink()
    checkpoint_path(path.with_suffix("")).write_bytes(b"damaged")
    with pytest.raises(CheckpointError, match="train with --fresh"):
        trained("ppo", tmp_path)
    assert trained("ppo", tmp_path, fresh=True).exists()
