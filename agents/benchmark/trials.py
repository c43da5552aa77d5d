"""The cells of a benchmark as trials of a study, and their cached rows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from agents.benchmark import grid
from agents.benchmark.measure import measure
from agents.benchmark.plan import LIMITED, BenchmarkCell, Request
from agents.benchmark.results import EPISODES, Result
from agents.cells import code_of, sources
from agents.study import Study
from grind_env.policies.problem import Problem
from grind_env.policies.registry import make_policy


@dataclass(frozen=True)
class BenchmarkTrial:
    """A cell, and how it is measured."""

    cell: BenchmarkCell
    request: Request

    @property
    def problem(self) -> Problem:
        return self.cell.problem

    def __str__(self) -> str:
        return f"{self.cell}, seeds from {self.request.first}"


def row(trial: BenchmarkTrial) -> dict[str, Any]:
    """Return the row of a cell."""
    found = measure(trial.cell, trial.request)
    return {each.name: getattr(found, each.name) for each in fields(Result)}


def result(row: Mapping[str, Any]) -> Result:
    """Return a row that was cached."""
    return Result(**{**row, **{name: np.array(row[name], np.float32) for name in EPISODES}})


def decides(trial: BenchmarkTrial) -> object:
    """Stands for the parameters and the code of a policy, or for what trains it."""
    cell, request = trial.cell, trial.request
    if cell.trains:
        return sources("agents.benchmark.agents"), sources("grind_env.training.gru_ppo")
    policy = make_policy(cell.base, cell.problem.simulation(), request.configs)
    return code_of(policy, cell.problem), sources("agents.tuning.rules") if cell.variant == LIMITED else None


def seconds(trial: BenchmarkTrial) -> float:
    """CPU-seconds of a trial, about."""
    return grid.making(trial.cell, trial.request) + grid.running(trial.cell, trial.request)


def study(
    name: str, cells: Sequence[BenchmarkCell], *requests: Request, files: Mapping[str, str], **more: Any
) -> Study:
    """Return the study of cells, each measured as every request says."""
    trials = [BenchmarkTrial(cell, request) for request in requests for cell in cells]
    return Study(name=name, title="", trials=trials, run=row, decides=decides, seconds=seconds, files=files, **more)
