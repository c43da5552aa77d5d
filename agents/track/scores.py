"""What runs of the track are worth: scores between two anchors on the same lots, with intervals over machines."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from agents.track.knowing import FIXED, PLANNER
from agents.track.running import TrackRun, TrackTrial
from grind_env.arrays import Array
from grind_env.policies.problem import Problem
from grind_env.policies.statistics import Interval, percentile_interval, score_of_means

RESAMPLES = 2000
WORST = 0.1
"""Share of the machines that are the worst ones."""
LEAST_SCRAP, SCRAP_SHARE = 1.0, 0.01
"""The safe budget: so many bad parts, or that share of all, whichever is more."""

Found: TypeAlias = Mapping[TrackTrial, TrackRun]
Key: TypeAlias = tuple[Problem, str, str, int]
Runs: TypeAlias = Mapping[Key, TrackRun]
"""By problem, machine, adapter and seed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scored:
    """An adapter after so many blocks on each of some machines.

    Attributes:
        score: mean over machines: 0 the fixed plan that was retuned on the machine, 100 the planner that holds it.
        median: of the machines.
        better: machines on which it is better than the fixed plan.
        worst: mean of the worst tenth of the machines, one at least.
        scrap: share of the parts in the episodes that judge.
        spent: cost of the blocks on the machine over that of the fixed plan on the same lots; NaN before any.
        learning_scrap: share of the parts in these blocks likewise.
        violations: runs with more bad parts in them than the safe budget has.
        runs: machines times seeds.
        beaten: blocks on the machine from which on all of them together have cost less than with the fixed plan, median
            of the runs; infinite where they never have.
        cpu_seconds: of a run, with judging.
    """

    task: str
    adapter: str
    blocks: int
    machines: int
    score: Interval
    median: float
    better: int
    worst: Interval
    scrap: float
    spent: float
    learning_scrap: float
    violations: int
    runs: int
    beaten: float
    cpu_seconds: float


def scored(found: Found) -> list[Scored]:
    """All adapters after all numbers of blocks, in the order of the cells."""
    keys = dict.fromkeys((cell.problem, cell.adapter, blocks) for cell in found for blocks in cell.blocks)
    runs = {_of(cell): run for cell, run in found.items()}
    return [
        _scored(
            [cell for cell in found if (cell.problem, cell.adapter) == (problem, adapter) and blocks in cell.blocks],
            runs,
            blocks,
        )
        for problem, adapter, blocks in keys
    ]


def _scored(cells: Sequence[TrackTrial], runs: Runs, blocks: int) -> Scored:
    one, shifts = cells[0], blocks // cells[0].problem.simulation().task.blocks
    ours, fixed = ([runs[_of(replace(cell, adapter=name))] for cell in cells] for name in (one.adapter, FIXED))
    costs = np.stack([_by_machine(runs, cells, name, blocks) for name in (one.adapter, FIXED, PLANNER)])
    values, draws = machine_scores(costs), resampled(costs)
    parts, bad = (np.array([sum(getattr(run, name)[:shifts]) for run in ours]) for name in ("parts", "scrap"))
    spent, plain = (sum(sum(run.costs[:shifts]) for run in each) for each in (ours, fixed))
    _, good, finished = np.array([run.judged[f"{blocks}"] for run in ours]).sum(axis=(0, 2))
    after = [beaten(run.costs, plan.costs) for run, plan in zip(ours, fixed, strict=True)]
    return Scored(
        task=one.problem.name,
        adapter=one.adapter,
        blocks=blocks,
        machines=len(values),
        score=percentile_interval(float(values.mean()), draws.mean(axis=1)),
        median=float(np.median(values)),
        better=int((values > 0.0).sum()),
        worst=percentile_interval(float(worst_of(values)), worst_of(draws)),
        scrap=float(1.0 - good / finished),
        spent=spent / plain if shifts else math.nan,
        learning_scrap=float(bad.sum() / parts.sum()) if shifts else math.nan,
        violations=int((bad > np.maximum(LEAST_SCRAP, SCRAP_SHARE * parts)).sum()),
        runs=len(cells),
        beaten=one.problem.simulation().task.blocks * float(np.median(after)),
        cpu_seconds=float(np.mean([run.cpu_seconds for run in ours])),
    )


def machine_scores(costs: Array) -> Array:
    """Score on each machine, of costs of the adapter and the two anchors, shape (3, machines, seeds, episodes)."""
    ours, fixed, planner = costs.mean(axis=(2, 3))
    return score_of_means(ours, fixed, planner)


def resampled(costs: Array, seed: int = 0) -> Array:
    """The same of resamples of machines, of the seeds of each and of the episodes of these, (resamples, machines)."""
    rng, (_, machines, seeds, episodes) = np.random.default_rng(seed), costs.shape
    found = list[Array]()
    drawn = (machines, (machines, 1, 1)), (seeds, (machines, seeds, 1)), (episodes, (machines, seeds, episodes))
    for _ in range(RESAMPLES):
        m, s, e = (rng.integers(0, n, shape) for n, shape in drawn)
        found.append(machine_scores(costs[:, m, s, e]))
    return np.array(found)


def worst_of(scores: Array) -> Array:
    """Mean of the worst tenth of the machines, along the last axis, one at least."""
    count = max(int(WORST * scores.shape[-1]), 1)
    return np.asarray(np.sort(scores, axis=-1)[..., :count].mean(axis=-1))


def beaten(costs: Sequence[float], fixed: Sequence[float]) -> float:
    """Shifts after which all of them together have cost less than with the fixed plan, and remain so.

    Infinite where they have not.
    """
    behind = np.flatnonzero(np.cumsum(np.subtract(fixed, costs)) <= 0.0)
    first = float(np.max(behind, initial=-1)) + 2.0
    return first if first <= len(costs) else math.inf


def _of(cell: TrackTrial) -> Key:
    return cell.problem, cell.plant, cell.adapter, cell.seed


def _by_machine(runs: Runs, cells: Sequence[TrackTrial], adapter: str, blocks: int) -> Array:
    """Costs of the episodes that judge, shape (machines, seeds, episodes)."""
    rows = [
        [runs[_of(replace(cell, adapter=adapter))].judged[f"{blocks}"][0] for cell in cells if cell.plant == plant]
        for plant in dict.fromkeys(cell.plant for cell in cells)
    ]
    return np.array(rows)
