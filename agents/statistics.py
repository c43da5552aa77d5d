"""Interval estimates for policies compared on the same episodes."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RESAMPLES = 4000
COVERAGE = 0.95


class Interval(NamedTuple):
    """An estimate and its 95 % bootstrap interval."""

    value: float
    low: float
    high: float

    @property
    def half_width(self) -> float:
        """Half the length of the interval."""
        return 0.5 * (self.high - self.low)


def cost_per_good_part(cost: Array, good: Array) -> Array:
    """Sum of costs over the sum of survival probabilities, along the last axis."""
    return np.asarray(cost.sum(axis=-1) / good.sum(axis=-1))


def normalised_score(cost: Array, fixed: Array, planner: Array) -> Array:
    """100 (J_fix - J) / (J_fix - J_plan) with J the mean cost of an episode, along the last axis.

    0 is the best fixed plan, 100 the hindsight planner (scenarios, section 2); nan where these two cost the same.
    """
    J, J_fix, J_plan = cost.mean(axis=-1), fixed.mean(axis=-1), planner.mean(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(J_fix == J_plan, np.nan, 100.0 * (J_fix - J) / (J_fix - J_plan))


def bootstrap(statistic: Callable[..., Array], *samples: Array, seed: int = 0, resamples: int = RESAMPLES) -> Interval:
    """Percentile bootstrap over episodes.

    Args:
        statistic: takes the samples and reduces their last axis.
        samples: values of the same episodes, each shape (episodes,); all are resampled together, so that the
            interval of a comparison is that of paired episodes.
        seed: of the resampling.
        resamples: number of resamples.

    Raises:
        ValueError: if the samples differ in shape.
    """
    if len({sample.shape for sample in samples}) != 1:
        raise ValueError(
            f"samples have shapes {[sample.shape for sample in samples]}, but must be of the same episodes"
        )
    n = samples[0].shape[0]
    index = np.random.default_rng(seed).integers(0, n, (resamples, n))
    values = statistic(*[sample[index] for sample in samples])
    tail = 50.0 * (1.0 - COVERAGE)
    low, high = np.percentile(values, [tail, 100.0 - tail])
    return Interval(float(statistic(*samples)), float(low), float(high))
