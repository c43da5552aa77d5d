"""Trainings of `agents/train_sb3.py` follow the recipe of the docs, survive a kill and refuse other checkpoints."""

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from agents import train_sb3
from agents.provenance import ROOT
from agents.train_sb3 import RECIPES, train, trained
from agents.training_recipe_study import SOURCE, RecipeTrial, recipe, run, variant
from grind_env.cli import main as grind
from grind_env.errors import GrindError
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.problem_lookup import find_problem
from grind_env.sb3 import ModelPolicy, load_zip

PLATES, ORACLE = find_problem("power_limited"), find_problem("oracle6")
ROLLOUT = 128 * 60  #: environment steps of an update of PPO


def weights(model: Any) -> list[torch.Tensor]:
    return [each.detach() for each in model.policy.parameters()]


def same(one: Any, other: Any) -> bool:
    return all(torch.equal(a, b) for a, b in zip(weights(one), weights(other), strict=True))


def test_ppo_trains_the_same_weights_as_the_recipe_of_the_docs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = variant(recipe(SOURCE.read_text(encoding="utf-8")), RecipeTrial(PLATES, "belief", 3, 2 * ROLLOUT))
    monkeypatch.chdir(tmp_path)
    theirs = run(lines.partition("judged =")[0])["model"]
    assert same(train(PLATES, "ppo", 3, 2 * ROLLOUT, tmp_path / "ours.zip"), theirs)
    steps, cpu_seconds = trained(tmp_path / "ours.zip")
    assert steps == 2 * ROLLOUT and cpu_seconds > 0.0


@pytest.mark.parametrize("algorithm", [pytest.param(name, marks=pytest.mark.nightly) for name in RECIPES][1:])
def test_every_algorithm_learns_and_plays_from_its_file(algorithm: str, tmp_path: Path) -> None:
    path = tmp_path / "agent.zip"
    model = train(ORACLE, algorithm, 0, 12_800, path)
    before = train_sb3.begun(ORACLE, algorithm, 0, belief=True)
    assert not same(model, before)
    seeds, simulation = range(500_000, 500_004), ORACLE.simulation()
    ours = run_seeds(load_zip(path, simulation), simulation, seeds)
    theirs = run_seeds(ModelPolicy(model), simulation, seeds)
    assert np.array_equal(ours.cost, theirs.cost)


@pytest.mark.nightly
def test_a_killed_training_resumes_to_the_same_agent(tmp_path: Path) -> None:
    program = (
        "import os, signal, sys; from pathlib import Path\n"
        "from agents.train_sb3 import Checkpoints, train; from grind_env.policies.problem_lookup import find_problem\n"
        "wrote = Checkpoints._on_rollout_start\n"
        "def killing(self):\n"
        "    wrote(self)\n"
        "    if self.num_timesteps > 40_000: os.kill(os.getpid(), signal.SIGKILL)\n"
        "Checkpoints._on_rollout_start = killing\n"
        "train(find_problem('oracle6'), 'dqn', 1, 60_000, Path(sys.argv[1]))\n"
    )
    path = tmp_path / "part.zip"
    ended = subprocess.run([sys.executable, "-c", program, path], cwd=ROOT, check=False)
    assert ended.returncode == -signal.SIGKILL and path.with_suffix(".checkpoint").exists() and not path.exists()
    with pytest.raises(GrindError, match=r"is of another training .*: delete it, or name another --output"):
        train(ORACLE, "dqn", 2, 60_000, path)
    again = train(ORACLE, "dqn", 1, 60_000, path)
    assert same(train(ORACLE, "dqn", 1, 60_000, tmp_path / "whole.zip"), again) and trained(path)[0] >= 60_000
    assert sorted(each.name for each in tmp_path.iterdir()) == ["part.zip", "whole.zip"]


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_a_damaged_checkpoint_is_refused(share: float, tmp_path: Path) -> None:
    path = tmp_path / "agent.checkpoint"
    torch.save(([], (), None), path)
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(GrindError, match=r"agent\.checkpoint is damaged .*: delete it to train anew"):
        train(ORACLE, "ppo", 0, 10, tmp_path / "agent.zip")


def test_the_command_trains_an_agent_and_grind_evaluates_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "agent.zip"
    train_sb3.app(
        ["--task", "oracle6", "--algorithm", "a2c", "--steps", "1280", "-o", str(path)], standalone_mode=False
    )
    assert f"grind evaluate --task oracle6 --policy {path} --trust" in capsys.readouterr().out
    with pytest.raises(SystemExit) as ended:
        grind(["evaluate", "--task", "oracle6", "--episodes", "2", "--policy", str(path), "--trust"])
    assert not ended.value.code and "$ per good part" in capsys.readouterr().out
    with pytest.raises(GrindError, match=r"there is no algorithm 'ppp' .*did you mean ppo.*: choose from ppo, a2c"):
        train(ORACLE, "ppp", 0, 10, path)
