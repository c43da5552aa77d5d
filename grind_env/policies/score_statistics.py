"""Estimates and bootstrap intervals: of policies on the same episodes, and of training runs over tasks.

A run is one training seed; an untrained policy has one run. Scores of runs and tasks are aggregated as in Agarwal et
al., "Deep Reinforcement Learning at the Edge of the Statistical Precipice", NeurIPS 2021 (their library is rliable):
interquartile mean, and a bootstrap stratified over tasks. In addition, the episodes are resampled, alike for all
policies of a task, so that a policy with one run has an interval, too.
"""

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np

from grind_env.array_types import Array

RESAMPLES = 4000
COVERAGE = 0.95
AT_ONCE = 250_000  #: number of values drawn at once, which fit into the processor's cache


CLIP = -100.0  #: lowest score in aggregates; lower scores are raised to it


class Interval(NamedTuple):
    """An estimate and its 95 % bootstrap interval: `value`, `low` and `high` in the unit of the estimate."""

    value: float
    low: float
    high: float

    @property
    def half_width(self) -> float:
        """Half the length of the interval."""
        return 0.5 * (self.high - self.low)

    def __format__(self, spec: str) -> str:
        """Write the interval as text: `.2f` is the value with both ends, `±.2f` the value and half the length."""
        if spec.startswith("±"):
            return f"{self.value:{spec[1:]}} ± {self.half_width:{spec[1:]}}"
        return f"{self.value:{spec}} ({self.low:{spec}} to {self.high:{spec}})" if spec else str(self)


def cost_per_good_part(cost: Array, good: Array) -> Array:
    """Return the sum of costs over the sum of survival probabilities, along the last axis of shape (..., episodes).

    The result is infinite where no part is good.
    """
    with np.errstate(divide="ignore"):
        return np.asarray(cost.sum(axis=-1) / good.sum(axis=-1))


def normalised_score(cost: Array, fixed: Array, planner: Array) -> Array:
    """Return the score of mean episode costs, along the last axis of shape (..., episodes); see `score_of_means`."""
    return score_of_means(cost.mean(axis=-1), fixed.mean(axis=-1), planner.mean(axis=-1))


def score_of_means(J: Array, J_fix: Array, J_plan: Array) -> Array:
    """Return 100 (J_fix - J) / (J_fix - J_plan), where J is the mean cost of an episode; arrays of one shape.

    0 is the best fixed plan, 100 the hindsight planner; nan where these two cost the same.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(J_fix == J_plan, np.nan, 100.0 * (J_fix - J) / (J_fix - J_plan))


def bootstrap(statistic: Callable[..., Array], *samples: Array, seed: int = 0, resamples: int = RESAMPLES) -> Interval:
    """Return a percentile bootstrap interval over episodes.

    Args:
        statistic: function of the samples that reduces their last axis.
        samples: values of the same episodes, each shape (episodes,); all are resampled together, so that the
            interval of a comparison is that of paired episodes.
        seed: seed of the resampling.
        resamples: number of resamples.

    Raises:
        ValueError: the samples differ in shape.
    """
    if len({sample.shape for sample in samples}) != 1:
        raise ValueError(
            f"samples have shapes {[sample.shape for sample in samples]}, but must be of the same episodes"
        )
    n = samples[0].shape[0]
    index = np.random.default_rng(seed).integers(0, n, (resamples, n))
    values = statistic(*[sample[index] for sample in samples])
    return percentile_interval(float(statistic(*samples)), values)


def percentile_interval(value: float, draws: Array) -> Interval:
    """Return the interval of an estimate from the estimates of all resamples, shape (resamples,)."""
    tail = 50.0 * (1.0 - COVERAGE)
    # interpolation between two infinite draws gives nan
    method: Literal["nearest", "linear"] = "nearest" if np.isinf(draws).any() else "linear"
    low, high = np.percentile(draws, [tail, 100.0 - tail], method=method)
    return Interval(value, float(low), float(high))


def prediction(values: Array, others: int, *, seed: int = 0, resamples: int = RESAMPLES) -> Interval:
    """Predict the mean of other episodes, as a 95 % interval, from known ones: a bootstrap of both samples.

    Both samples are drawn from the known values. The difference of their means, in standard deviations of the first,
    estimates the error of the known mean: a sample that missed rare, expensive episodes is too low, and so is its
    deviation (bootstrap-t of Efron, Tibshirani, 1993, chapter 12).

    Args:
        values: shape (episodes,), in the unit of the result.
        others: number of the other episodes.
        seed: seed of the resampling.
        resamples: number of resamples.
    """
    rng, n = np.random.default_rng(seed), len(values)
    known = values[rng.integers(0, n, (resamples, n))]
    later = np.array([values[rng.integers(0, n, others)].mean() for _ in range(resamples)])
    deviation = known.std(axis=1)
    off = (later - known.mean(axis=1))[deviation > 0.0] / deviation[deviation > 0.0]
    mean = float(values.mean())
    return percentile_interval(mean, mean + values.std() * off) if off.size else Interval(mean, mean, mean)


def resampled_means(values: Array, *, seed: int = 0) -> Array:
    """Return means over resampled episodes, with the resamples of `bootstrap` but without copies of the values.

    Args:
        values: shape (k, episodes); all k are resampled together.
        seed: seed of the resampling.

    Returns:
        Shape (resamples, k).
    """
    rng, (k, n) = np.random.default_rng(seed), values.shape
    means = np.empty((RESAMPLES, k))
    for rows in np.array_split(np.arange(RESAMPLES), -(-RESAMPLES * n // AT_ONCE)):
        index = rng.integers(0, n, (len(rows), n)) + n * np.arange(len(rows))[:, None]
        counts = np.bincount(index.ravel(), minlength=index.size).reshape(index.shape)
        means[rows] = counts @ values.T / n
    return means


def resampled_runs(scores: Array, seed: int = 0) -> Array:
    """Resample runs with replacement within each task: the stratified bootstrap of rliable.

    Args:
        scores: scores of each resample of the episodes, or repeated scores, shape (resamples, runs, tasks).
        seed: seed of the resampling.
    """
    index = np.random.default_rng(seed).integers(0, scores.shape[1], scores.shape)
    return np.take_along_axis(scores, index, axis=1)


class ScoredRuns(NamedTuple):
    """Scores of a policy, clipped at `CLIP`."""

    scores: Array  #: ratio to the gap between fixed plan and hindsight, %, shape (runs, tasks)
    draws: Array  #: score ratio of every resample of runs and episodes, %, shape (resamples, runs, tasks)

    @classmethod
    def clipped(cls, scores: Array, draws: Array) -> "ScoredRuns":
        """Return runs with these scores, clipped at `CLIP`."""
        return cls(np.maximum(scores, CLIP), np.maximum(draws, CLIP))

    def interval(self, measure: Callable[[Array], Array]) -> Interval:
        """Return an aggregate with its interval; `measure`, like `mean_score`, takes shape (..., runs, tasks)."""
        return percentile_interval(float(measure(self.scores)), measure(self.draws))


def interquartile_mean(scores: Array) -> Array:
    """Return the mean of the middle half of scores of shape (..., runs, tasks); a quarter is rounded down."""
    runs = np.sort(scores.reshape(*scores.shape[:-2], -1), axis=-1)
    cut = runs.shape[-1] // 4
    return np.asarray(runs[..., cut : runs.shape[-1] - cut].mean(axis=-1))


def mean_score(scores: Array) -> Array:
    """Return the mean over runs and tasks of scores of shape (..., runs, tasks)."""
    return np.asarray(scores.mean(axis=(-2, -1)))
