"""Costs and scores of results on the same episodes, and their intervals."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np

from agents.benchmark.results import Result
from grind_env.arrays import Array
from grind_env.envs.names import environment_id
from grind_env.policies.registry import FIXED_PLANS, REFERENCE, UNIFORM_PLANS
from grind_env.policies.statistics import Interval, percentile_interval, resampled_means, resampled_runs, score_of_means
from grind_env.scores import find_reference

CLIP = -100.0
"""Lower scores count as this one in aggregates (scenarios, section 2)."""
INTERPOLATION = "interpolation_"
"""What the names of columns begin with that are of contexts of that split."""


class Sampled:
    """Results of one task with resamples of its episodes, the same ones for all of them.

    Args:
        results: of one task and the same episodes; at least one.
        interpolation: take the episodes with contexts of that split.

    Attributes:
        results: the results that have such episodes.
        cost: mean cost of an episode, $, shape (k,), and of each resample, shape (resamples, k).
        good: likewise, mean number of good parts.
    """

    def __init__(self, results: Iterable[Result], interpolation: bool = False) -> None:
        prefix = INTERPOLATION if interpolation else ""
        self.results = list(results)
        values = np.array(
            [np.asarray(getattr(each, f"{prefix}{name}"), float) for name in ("cost", "good") for each in self.results]
        )
        k = len(self.results)
        means, draws = values.mean(axis=-1), resampled_means(values)
        self.cost, self.good = (means[:k], draws[:, :k]), (means[k:], draws[:, k:])
        self.index = {(each.policy, each.seed): i for i, each in enumerate(self.results)}

    def fixed(self) -> int | None:
        """Number of the fixed plan of least mean cost; None if one that every task has was not run."""
        plans = {name: self.index[name, None] for name in FIXED_PLANS if (name, None) in self.index}
        known = plans.keys() >= set(UNIFORM_PLANS)
        return min(plans.values(), key=lambda i: float(self.cost[0][i])) if known else None

    def runs(self, policy: str) -> list[int]:
        """Numbers of the results of a policy, in the order of their seeds."""
        return [i for i, each in enumerate(self.results) if each.policy == policy]

    def scores(self) -> tuple[Array, Array] | None:
        """Scores, shape (k,), and those of each resample, shape (resamples, k); None if an anchor was not run."""
        fixed, planner = self.fixed(), self.index.get((REFERENCE, None))
        if fixed is None or planner is None:
            return None
        mean, draws = (score_of_means(J, J[..., [fixed]], J[..., [planner]]) for J in self.cost)
        return mean, draws

    def ratios(self) -> tuple[Array, Array] | None:
        """Costs over that of the best fixed plan, likewise."""
        fixed = self.fixed()
        if fixed is None:
            return None
        mean, draws = (J / J[..., [fixed]] for J in self.cost)
        return mean, draws

    def costs(self) -> tuple[Array, Array]:
        """Costs per good part, $, likewise."""
        return self.cost[0] / self.good[0], self.cost[1] / self.good[1]


def sampled_interpolation(results: Iterable[Result]) -> Sampled | None:
    """The results of a task with contexts of the split `interpolation`; None if there are none."""
    found = [each for each in results if each.interpolation_episodes]
    return Sampled(found, interpolation=True) if found else None


def over_runs(found: tuple[Array, Array] | None, runs: Sequence[int]) -> Interval | None:
    """Mean over the runs of a policy, with an interval over its runs and the episodes.

    Args:
        found: of each result, shape (k,), and of each resample, shape (resamples, k).
        runs: numbers of the results.
    """
    if found is None or not runs:
        return None
    values, draws = found[0][list(runs)], resampled_runs(found[1][:, list(runs), None])[..., 0]
    return percentile_interval(float(values.mean()), draws.mean(axis=-1))


def is_ratio(task: str) -> bool:
    """Whether both anchors cost nearly the same, so that a score between them would be noise (scenarios, section 5)."""
    known = find_reference(environment_id(task))
    return known is not None and known.ratio


def judged(results: Sequence[Result]) -> list[Result]:
    """The results with what depends on the fixed plan and the planner of their task."""
    filled: list[Result] = []
    for _, of_task in groupby(results, key=lambda each: each.task):
        group = list(of_task)
        columns: list[dict[str, Any]] = [{} for _ in group]
        for prefix, sampled in (("", Sampled(group)), (INTERPOLATION, sampled_interpolation(group))):
            if sampled is None:
                continue
            found = {
                f"{prefix}cost_per_good_part": sampled.costs(),
                f"{prefix}score": sampled.scores(),
                f"{prefix}cost_ratio": sampled.ratios(),
            }
            for i, result in enumerate(sampled.results):
                row = columns[group.index(result)]
                for name, pair in found.items():
                    row.update(spread(name, over_runs(pair, [i])))
        filled += [replace(result, **row) for result, row in zip(group, columns, strict=True)]
    return filled


def spread(name: str, interval: Interval | None) -> dict[str, float | None]:
    """An interval as three columns; nan becomes None."""
    values = (None, None, None) if interval is None or np.isnan(interval.value) else interval
    return dict(zip((name, f"{name}_low", f"{name}_high"), values, strict=True))
