"""Cells of a benchmark as trials of a study, and their cached rows."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from agents.benchmark.cell_measurement import measure
from agents.benchmark.cpu_time import evaluation_seconds, training_seconds
from agents.benchmark.plan import BenchmarkCell, Request
from agents.benchmark.results import Result, row_of
from agents.evaluation_cache import code_of
from agents.study import Study, of_problem
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.registry import make_policy


@dataclass(frozen=True)
class BenchmarkTrial:
    """Cell, and request for its measurement."""

    cell: BenchmarkCell
    request: Request

    @property
    def problem(self) -> Problem:
        return self.cell.problem

    def __str__(self) -> str:
        return f"{self.cell}, seeds from {self.request.first}"


@dataclass(frozen=True, kw_only=True)
class BenchmarkStudy(Study):
    """Study of cells; published rows are not run again."""

    finished: dict[str, Result]  #: published rows by their digests

    def digest(self, trial: BenchmarkTrial) -> str:
        return digest(trial)

    def cached(self, trial: BenchmarkTrial, runs: Path) -> Mapping[str, Any] | None:
        found: Mapping[str, Any] | None = super().cached(trial, runs)
        published = self.finished.get(digest(trial))
        return found if found is not None or published is None else row_of(published)


@cache
def digest(trial: BenchmarkTrial) -> str:
    """Return a hash of all inputs of a row: the task, and parameters and code of a policy or of its training."""
    cell, request = trial.cell, trial.request
    if cell.trains:
        # torch takes seconds to import
        from agents.benchmark.agent_training import code_of_training

        decides = code_of_training(cell, request)
    else:
        decides = code_of(make_policy(cell.base, cell.problem.simulation(), request.configs), cell.problem)
    parts = repr(trial), of_problem(cell.problem), decides
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def run(trial: BenchmarkTrial) -> dict[str, Any]:
    """Return the row of a cell."""
    return row_of(replace(measure(trial.cell, trial.request), digest=digest(trial)))


def seconds(trial: BenchmarkTrial) -> float:
    """Return the estimated CPU time of a trial, s."""
    return training_seconds(trial.cell, trial.request) + evaluation_seconds(trial.cell, trial.request)


def study(
    name: str,
    cells: Sequence[BenchmarkCell],
    *requests: Request,
    files: Mapping[str, str],
    finished: Sequence[Result] = (),
    **more: Any,
) -> BenchmarkStudy:
    """Return the study that measures each cell for each request; finished rows are not run again."""
    trials = [BenchmarkTrial(cell, request) for request in requests for cell in cells]
    known = {each.digest: each for each in finished if each.digest}
    return BenchmarkStudy(
        name=name, title="", trials=trials, run=run, seconds=seconds, files=files, finished=known, **more
    )
