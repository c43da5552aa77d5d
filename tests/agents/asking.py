"""Functions that run commands of `python -m agents`, and trials in this process."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from agents import __main__, study
from agents.study import Options, StudyOptions
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.problem_lookup import Problem


def evaluation(*cost: float, good: float = 1.0, finished: float = 1.0, blocks: int = 2) -> Evaluation:
    """Return an evaluation of episodes with these costs and numbers of parts; E is 9 m/min and D is 1."""
    n = len(cost)
    each = np.full(n, good), np.full(n, finished), np.full((n, blocks), 9000.0), np.ones((n, blocks))
    return Evaluation(np.array(cost, float), *each)


def run_here(
    trials: Any, run: Callable[[Any], Any], jobs: int, console: Any, ray: Any, done: Callable[[Any, Any], Any]
) -> dict[Any, str]:
    """Run trials like `runner.run_all`, but in this process; the first failure ends the run."""
    for trial in trials:
        done(trial, run(trial))
    return {}


def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let studies run their trials in this process."""
    monkeypatch.setattr(study, "run_all", run_here)


def study_options(folder: Path, *problems: Problem, episodes: int = 2, seeds: int = 1, steps: int = 1) -> StudyOptions:
    """Return the options of a study whose cache and results lie below a folder."""
    options = Options(runs=folder / "runs", console=Console(quiet=True))
    return StudyOptions(
        problems=problems, episodes=episodes, seeds=seeds, steps=steps, configs=None, results=folder, options=options
    )


def status(monkeypatch: pytest.MonkeyPatch, *words: object) -> int:
    """Run a command; return its exit status."""
    monkeypatch.setattr("sys.argv", ["agents", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        __main__.main()
    return int(ended.value.code or 0)
