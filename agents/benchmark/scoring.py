"""Costs and scores of results on the same episodes, and their intervals."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import groupby
from typing import Any

import numpy as np

from agents.benchmark.results import PLANTS, PREFIXES, Result
from grind_env.array_types import Array
from grind_env.envs.task_names import environment_id
from grind_env.policies import score_statistics
from grind_env.policies.registry import FIXED_PLANS, REFERENCE, UNIFORM_PLANS
from grind_env.score_scale import find_reference

Draws = tuple[Array, Array]  #: values of k results, shape (k,), and values of each resample, shape (resamples, k)


class Sampled:
    """Results of one task with resamples of its episodes, equal for results with equal numbers of episodes.

    Results with fewer episodes have the first episodes of the others; comparisons use the common episodes.
    """

    def __init__(self, results: Iterable[Result], prefix: str = "") -> None:
        self.results, self.prefix = list(results), prefix
        self.lengths = np.array([len(getattr(each, f"{prefix}cost")) for each in self.results])
        self.index = {(each.policy, each.seed): i for i, each in enumerate(self.results)}

    def of_first(self, n: int) -> tuple[Draws, Draws]:
        """Return mean cost, $, and good parts over the first n episodes and of resamples; NaN for shorter results."""
        return _of_first(tuple(self.results), self.prefix, n)

    def fixed(self) -> int | None:
        """Return the index of the fixed plan of least mean cost; None if one of `UNIFORM_PLANS` was not run."""
        plans = {name: self.index[name, None] for name in FIXED_PLANS if (name, None) in self.index}
        if not plans.keys() >= set(UNIFORM_PLANS):
            return None
        (mean, _), _ = self.of_first(self.lengths[list(plans.values())].min())
        return min(plans.values(), key=lambda i: float(mean[i]))

    def runs(self, policy: str) -> list[int]:
        """Return the indices of the results of a policy, in the order of their seeds."""
        return [i for i, each in enumerate(self.results) if each.policy == policy]

    def scores(self) -> Draws | None:
        """Return scores, shape (k,), and of each resample, shape (resamples, k); None if an anchor was not run."""
        return self._against(score_statistics.score_of_means, self.fixed(), self.index.get((REFERENCE, None)))

    def ratios(self) -> Draws | None:
        """Return costs over the cost of the best fixed plan, with resamples; None if a fixed plan was not run."""
        return self._against(np.divide, self.fixed())

    def costs(self) -> Draws:
        """Return costs per good part, $, with resamples."""
        return self._each(lambda cost, good, i: cost[..., i] / good[..., i], self.lengths)

    def gain(self, ours: str, theirs: str) -> score_statistics.Interval | None:
        """Return the score of one policy minus the score of another, paired over episodes, and over the runs of each.

        None if one of the policies or an anchor was not run.
        """
        fixed, planner = self.fixed(), self.index.get((REFERENCE, None))
        runs = self.runs(ours), self.runs(theirs)
        if fixed is None or planner is None or not all(runs):
            return None
        (mean, draws), _ = self.of_first(self.lengths[[*runs[0], *runs[1], fixed, planner]].min())
        drawn = [
            score_statistics.resampled_runs(draws[:, of, None], seed)[..., 0].mean(axis=-1)
            for seed, of in enumerate(runs)
        ]
        one, other = (score_statistics.score_of_means(mean[of].mean(), mean[fixed], mean[planner]) for of in runs)
        ones, others = (score_statistics.score_of_means(each, draws[:, fixed], draws[:, planner]) for each in drawn)
        return score_statistics.percentile_interval(float(one - other), ones - others)

    def _against(self, of_costs: Callable[..., Array], *anchors: int | None) -> Draws | None:
        """Return `of_costs` of the mean costs of each result and of the anchors, over their common episodes."""
        known = [each for each in anchors if each is not None]
        if len(known) < len(anchors):
            return None
        lengths = np.minimum(self.lengths, self.lengths[known].min())
        return self._each(lambda cost, _, i: of_costs(cost[..., i], *(cost[..., [k]] for k in known)), lengths)

    def _each(self, number: Callable[[Array, Array, list[int]], Array], lengths: Array) -> Draws:
        """Return `number` for each result over its first `lengths` episodes, and for each resample."""
        mean, draws = np.empty(len(lengths)), np.empty((score_statistics.RESAMPLES, len(lengths)))
        for n in np.unique(lengths):
            of = np.flatnonzero(lengths == n).tolist()
            (cost, costs), (good, goods) = self.of_first(int(n))
            mean[of], draws[:, of] = number(cost, good, of), number(costs, goods, of)
        return mean, draws


# the tables of a page need the same resamples many times
@lru_cache(maxsize=32)
def _of_first(results: tuple[Result, ...], prefix: str, n: int) -> tuple[Draws, Draws]:
    found = [np.asarray(getattr(each, f"{prefix}{name}"), float) for name in ("cost", "good") for each in results]
    values, k = np.array([each[:n] if len(each) >= n else np.full(n, np.nan) for each in found]), len(results)
    means, draws = values.mean(axis=-1), score_statistics.resampled_means(values)
    return (means[:k], draws[:, :k]), (means[k:], draws[:, k:])


def sampled(results: Iterable[Result], prefix: str) -> Sampled | None:
    """Return the results of a task that have episodes in columns of a prefix; None if there are none."""
    found = [each for each in results if getattr(each, f"{prefix}episodes")]
    return Sampled(found, prefix) if found else None


def over_runs(found: tuple[Array, Array] | None, runs: Sequence[int]) -> score_statistics.Interval | None:
    """Return the mean over the results with these indices, with an interval over runs and episodes."""
    if found is None or not runs:
        return None
    values, draws = found[0][list(runs)], score_statistics.resampled_runs(found[1][:, list(runs), None])[..., 0]
    return score_statistics.percentile_interval(float(values.mean()), draws.mean(axis=-1))


def is_ratio(task: str) -> bool:
    """Return whether both anchors cost so nearly the same that a score would be noise."""
    known = find_reference(environment_id(task))
    return known is not None and known.ratio


def judged(results: Sequence[Result]) -> list[Result]:
    """Return the results with costs, scores and ratios, which need fixed plan and planner of their task."""
    filled: list[Result] = []
    for _, of_task in groupby(results, key=lambda each: each.task):
        group = list(of_task)
        columns: list[dict[str, Any]] = [{} for _ in group]
        for prefix in PREFIXES:
            of = sampled(group, prefix)
            if of is None:
                continue
            found: dict[str, Draws | None] = {f"{prefix}cost_per_good_part": of.costs()}
            if prefix != PLANTS:  # drawn machines have no anchors
                found |= {f"{prefix}score": of.scores(), f"{prefix}cost_ratio": of.ratios()}
            for i, result in enumerate(of.results):
                row = columns[group.index(result)]
                for name, pair in found.items():
                    row.update(spread(name, over_runs(pair, [i])))
        filled += [replace(result, **row) for result, row in zip(group, columns, strict=True)]
    return filled


def spread(name: str, interval: score_statistics.Interval | None) -> dict[str, float | None]:
    """Return an interval as three columns; nan becomes None."""
    values = (None, None, None) if interval is None or np.isnan(interval.value) else interval
    return dict(zip((name, f"{name}_low", f"{name}_high"), values, strict=True))
