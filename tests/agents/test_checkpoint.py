"""A training that is killed and started again ends in the very agent of one that was left alone."""

import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from agents.learning.checkpoint import CheckpointError, Training, checkpoint_path, read_checkpoint, write_checkpoint
from agents.learning.curve import curve_path, read_curve
from agents.learning.settings import DEFAULTS
from agents.learning.train import new_model, train
from grind_env.policies.problem import find_problem

PROBLEM = find_problem("oracle6")
TINY = {
    "ppo": replace(
        DEFAULTS["ppo"],
        steps=24 * 48,
        envs=4,
        hidden=(8,),
        hyper={**DEFAULTS["ppo"].hyper, "n_steps": 6, "batch_size": 24, "n_epochs": 2},
    ),
    "dqn": replace(
        DEFAULTS["dqn"],
        steps=24 * 20,
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

CHILD = """
import os, signal, sys
from pathlib import Path
from agents.learning.training_env import LearnerVecEnv
from tests.agents.test_checkpoint import PROBLEM, TINY
from agents.learning.train import train

kind, folder, moment, count = sys.argv[1], Path(sys.argv[2]), sys.argv[3], int(sys.argv[4])
owner, name = {"step": (LearnerVecEnv, "step_wait"), "write": (Path, "replace")}[moment]
plain, calls = getattr(owner, name), [0]

def mortal(self, *arguments):
    calls[0] += moment == "step" or str(self).endswith(".partial")
    if calls[0] == count:
        os.kill(os.getpid(), signal.SIGKILL)
    return plain(self, *arguments)

setattr(owner, name, mortal)
train(PROBLEM, kind, 3, TINY[kind], folder, quiet=True)
"""


@pytest.mark.bits
@pytest.mark.parametrize("kind", ["ppo", "dqn"])
def test_a_killed_training_goes_on_bit_by_bit(kind: str, tmp_path: Path):
    whole = train(PROBLEM, kind, 3, TINY[kind], tmp_path / "whole", quiet=True)
    moments = np.random.default_rng()
    for moment, count in (("step", moments.integers(30, 60)), ("write", moments.integers(1, 8))):
        command = [sys.executable, "-c", CHILD, kind, str(tmp_path / "killed"), moment, str(count)]
        killed = subprocess.run(command, check=False, capture_output=True)
        assert killed.returncode == -signal.SIGKILL, killed.stderr
    (checkpoint,) = (tmp_path / "killed" / PROBLEM.name).glob("*.checkpoint")
    steps = read_checkpoint(checkpoint).model.num_timesteps
    assert 0 < steps < TINY[kind].steps
    resumed = train(PROBLEM, kind, 3, TINY[kind], tmp_path / "killed", quiet=True)
    assert resumed.name == whole.name
    assert resumed.read_bytes() == whole.read_bytes()
    for one, other in zip(read_curve(curve_path(whole)), read_curve(curve_path(resumed)), strict=True):
        assert (one.steps, one.reward, one.cost) == (other.steps, other.reward, other.cost)
    left = sorted(path.name for path in resumed.parent.iterdir())
    assert left == sorted([resumed.name, curve_path(resumed).name, "tensorboard"])


@pytest.mark.parametrize("kind", ["ppo", "dqn"])
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
    path = train(PROBLEM, "ppo", 3, TINY["ppo"], tmp_path, quiet=True)
    whole = path.read_bytes()
    path.unlink()
    stem = path.with_suffix("")
    ours = checkpoint_path(stem)
    other = ours.with_name(f"{stem.name}-01234567.checkpoint")
    for left in (other, other.with_name(f".{other.name}.partial")):
        left.write_bytes(b"objects of other code")
    assert other != ours
    assert train(PROBLEM, "ppo", 3, TINY["ppo"], tmp_path, quiet=True).read_bytes() == whole
    left_over = [each.name for each in path.parent.iterdir() if "checkpoint" in each.name]
    assert not left_over


def test_a_damaged_checkpoint_does_not_stop_a_fresh_training(tmp_path: Path):
    path = train(PROBLEM, "ppo", 3, TINY["ppo"], tmp_path, quiet=True)
    path.unlink()
    checkpoint_path(path.with_suffix("")).write_bytes(b"damaged")
    with pytest.raises(CheckpointError, match="train with --fresh"):
        train(PROBLEM, "ppo", 3, TINY["ppo"], tmp_path, quiet=True)
    assert train(PROBLEM, "ppo", 3, TINY["ppo"], tmp_path, fresh=True, quiet=True).exists()
