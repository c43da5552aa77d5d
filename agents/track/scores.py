"""Scores of the track: costs between two anchors on the same lots, with intervals over machines and seeds."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias
from warnings import catch_warnings, simplefilter

import numpy as np

from agents.csv_tables import csv_of, csv_rows
from agents.track.scale_anchors import PLAN, PLANNER, TRAINED, MachineRuns
from grind_env.array_types import Array
from grind_env.policies.score_statistics import Interval, percentile_interval, score_of_means
from grind_env.policies.track import BASELINE, TrackRuns
from grind_env.policies.tuned_parameters import write_whole
from grind_env.task_version import TASK_VERSION

RESAMPLES = 2000
ANCHORS = "track_anchors.csv"
Ground: TypeAlias = Mapping[str, Mapping[str, MachineRuns]]  #: runs by machine and name of the policy


class Anchors(NamedTuple):
    """Costs that set the scales of a machine, $ per block for each seed, and the policy that sets the bound."""

    plan: Array
    robust: Array
    trained_on_machine: Array
    bound: Array
    bound_by: str
    said: str


COLUMNS = ("task_version", "plant", "seed", *Anchors._fields)


class Summary(NamedTuple):
    """Mean and median of the scores of machines, and the score of the summed costs, with 95 % intervals."""

    mean: Interval
    median: Interval
    of_sums: Interval


def points(ours: Array, zero: Array, hundred: Array) -> Array:
    """Return scores, 0 for the cost `zero` and 100 for `hundred`; NaN where `hundred` is no cheaper."""
    return np.where(hundred < zero, score_of_means(ours, zero, hundred), np.nan)


def summary(ours: Array, zero: Array, hundred: Array) -> Summary:
    """Return the scores of costs, shape (machines, seeds); resamples of machines and seeds are equal for all costs."""
    costs, rng, (machines, seeds) = np.stack([ours, zero, hundred]), np.random.default_rng(0), ours.shape
    m, s = rng.integers(0, machines, (RESAMPLES, machines, 1)), rng.integers(0, seeds, (RESAMPLES, machines, seeds))
    value, draws = costs.mean(axis=2), costs[:, m, s].mean(axis=3)
    statistics: tuple[Callable[[Array], Array], ...] = (
        lambda costs: np.nanmean(points(*costs), axis=-1),
        lambda costs: np.nanmedian(points(*costs), axis=-1),
        lambda costs: points(*costs.sum(axis=-1)),
    )

    def interval(statistic: Callable[[Array], Array]) -> Interval:
        drawn, found = statistic(draws), float(statistic(value))
        return Interval(found, found, found) if np.isnan(found) else percentile_interval(found, drawn[~np.isnan(drawn)])

    with catch_warnings():
        simplefilter("ignore")  # a resample may have no machine with a score
        return Summary(*map(interval, statistics))


def collected(found: Mapping[Any, Mapping[str, MachineRuns]]) -> Ground:
    """Return the runs of all seeds by machine and name, as the mean over trainings."""
    parts: dict[str, dict[str, dict[int, list[MachineRuns]]]] = {}
    for trial, runs in found.items():
        for name, each in runs.items():
            of = parts.setdefault(trial.plant, {}).setdefault(name, {})
            of.setdefault(trial.training, []).append(each)
    return {plant: {name: _joined([*of.values()]) for name, of in names.items()} for plant, names in parts.items()}


def _joined(trainings: Sequence[Sequence[MachineRuns]]) -> MachineRuns:
    by_training = [[np.concatenate(each) for each in zip(*(one.runs for one in of), strict=True)] for of in trainings]
    seconds = float(np.mean([one.cpu_seconds for of in trainings for one in of]))
    return MachineRuns(TrackRuns(*np.mean(by_training, axis=0)), trainings[0][0].said, seconds)


def anchors_of(runs: Mapping[str, MachineRuns]) -> Anchors:
    """Return the anchors of a machine; the bound is the cheapest policy that was run on it."""
    cost = {name: each.runs.cost.mean(axis=1) for name, each in runs.items()}
    best = min(cost, key=lambda name: float(cost[name].mean()))
    said = f"{PLAN} {runs[PLAN].said}; {PLANNER} {runs[PLANNER].said}"
    return Anchors(cost[PLAN], cost[BASELINE], cost[TRAINED], cost[best], best, said)


def read_anchors(path: Path, seeds: Sequence[int]) -> dict[str, Anchors]:
    """Return the frozen anchors of the present task version by machine, for machines with all seeds."""
    rows = [row for row in csv_rows(path) if row["task_version"] == f"{TASK_VERSION}"] if path.exists() else []
    found = {}
    for plant in dict.fromkeys(row["plant"] for row in rows):
        of = {int(row["seed"]): row for row in rows if row["plant"] == plant}
        if {*seeds} <= {*of}:
            plan, robust, trained, bound = (
                np.array([float(of[seed][name]) for seed in seeds]) for name in Anchors._fields[:4]
            )
            found[plant] = Anchors(plan, robust, trained, bound, of[seeds[0]]["bound_by"], of[seeds[0]]["said"])
    return found


def write_anchors(path: Path, anchors: Mapping[str, Anchors]) -> None:
    """Write the anchors of machines, a row for each seed."""
    rows = [
        [TASK_VERSION, plant, seed, *(f"{cost:.6g}" for cost in costs), each.bound_by, each.said]
        for plant, each in anchors.items()
        for seed, costs in enumerate(zip(*each[:4], strict=True))
    ]
    write_whole(path, csv_of(COLUMNS, rows))
