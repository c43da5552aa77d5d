"""Power of the idling spindle, which drifts as it warms up and as the coolant changes."""

import numpy as np
from numpy.typing import NDArray

from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.calibrate.sheet import Floats

NEIGHBOURS = 40
"""Samples between strokes from which the idle power under a stroke is read."""
HALF, ENOUGH = 20, 8
"""Of them in pauses, on either side of it, and how many there must be."""
FARTHEST = 120.0
"""s from a stroke at which its idle power may still be read."""
TUKEY = 4.0
"""Times the scatter from which on a sample has no weight."""
ROUNDS = 4
SCATTER = 1.4826
"""Standard deviation over the median deviation."""


def idle_at(
    when: Floats, time: Floats, power: Floats, pausing: NDArray[np.bool_] | None = None
) -> tuple[Floats, Floats]:
    """Idle power under each stroke: a straight line through the samples nearest to it, outliers weighing less.

    Those of pauses alone where there are enough on both sides of a stroke.

    Args:
        when: middle of each stroke, s.
        time: of the samples between strokes, rising, s.
        power: of them, W.
        pausing: which of them lie in pauses; None for none.

    Returns:
        Idle power and its standard error, W; NaN where no sample is near.

    Raises:
        CalibrationError: there is no such sample at all.
    """
    if time.size < 3:
        raise CalibrationError(
            "the log has no samples between its strokes, so that the power of the idling spindle is not known; "
            "log faster, or from before the first stroke on"
        )
    idle, error = np.full(when.size, np.nan), np.full(when.size, np.nan)
    for k, moment in enumerate(when.tolist()):
        low, high = np.searchsorted(time, (moment - FARTHEST, moment + FARTHEST))
        if high - low < 3:
            continue
        span = np.arange(low, high)
        quiet = span if pausing is None else span[pausing[low:high]]
        before, after = quiet[time[quiet] < moment][-HALF:], quiet[time[quiet] >= moment][:HALF]
        near = np.concatenate([before, after])
        if pausing is None or min(before.size, after.size) < ENOUGH:
            near = span[np.argsort(np.abs(time[span] - moment), kind="stable")[:NEIGHBOURS]]
        idle[k], error[k] = _line(time[near] - moment, power[near])
    return idle, error


def _line(x: Floats, y: Floats) -> tuple[float, float]:
    """Value at 0 of a straight line through points, and its standard error; Tukey's bisquare by reweighting."""
    weight = np.ones(x.size)
    span = max(float(np.abs(x).max()), 1e-9)
    design = np.column_stack([np.ones(x.size), x / span])
    ridge = np.diag([1e-9, 0.1])  # a line from one side only must not run away
    for _ in range(ROUNDS):
        inverse = np.linalg.inv(design.T @ (weight[:, None] * design) + ridge)
        line = inverse @ design.T @ (weight * y)
        rest = y - design @ line
        scatter = max(SCATTER * float(np.median(np.abs(rest - np.median(rest)))), 1e-6 * (abs(line[0]) + 1.0))
        weight = np.square(np.maximum(1.0 - np.square(rest / (TUKEY * scatter)), 0.0)) + 1e-9
    sigma = np.sqrt(np.sum(weight * rest * rest) / max(weight.sum() - 2.0, 1.0))
    return float(line[0]), float(sigma * np.sqrt(inverse[0, 0]))
