"""Power of the idling spindle, which drifts as it warms up and as the coolant changes."""

import numpy as np
from numpy.typing import NDArray

from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.measurements.sheet import Floats

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
    """
    if time.size < 3:
        raise CalibrationError(
            "the log has no samples between its strokes, so that the power of the idling spindle is not known; "
            "log faster, or from before the first stroke on"
        )
    near = np.full((when.size, NEIGHBOURS), -1)
    for k, moment in enumerate(when.tolist()):
        low, high = np.searchsorted(time, (moment - FARTHEST, moment + FARTHEST))
        if high - low < 3:
            continue
        span = np.arange(low, high)
        quiet = span if pausing is None else span[pausing[low:high]]
        before, after = quiet[time[quiet] < moment][-HALF:], quiet[time[quiet] >= moment][:HALF]
        nearest = np.concatenate([before, after])
        if pausing is None or min(before.size, after.size) < ENOUGH:
            nearest = span[np.argsort(np.abs(time[span] - moment), kind="stable")[:NEIGHBOURS]]
        near[k, : nearest.size] = nearest
    idle, error = np.full((2, when.size), np.nan)
    known = near[:, 0] >= 0
    inside = near[known] >= 0
    x, y = np.where(inside, time[near[known]] - when[known, None], np.nan), np.where(inside, power[near[known]], np.nan)
    idle[known], error[known] = _lines(x, y)
    return idle, error


def _lines(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Value at 0 of a straight line through the points of each row, NaN for none, and its standard error.

    Tukey's bisquare by reweighting.
    """
    inside, span = np.isfinite(x), np.maximum(np.nanmax(np.abs(x), axis=1, initial=1e-9), 1e-9)
    x, weight = np.nan_to_num(x / span[:, None]), inside.astype(np.float64)
    for _ in range(ROUNDS):
        # a line from one side only must not run away: its slope has a weight of its own
        s, sx, sxx = (np.sum(weight * each, axis=1) for each in (1.0, x, x * x))
        sy, sxy = (np.sum(weight * each, axis=1, where=inside) for each in (y, x * y))
        s, sxx = s + 1e-9, sxx + 0.1
        per = 1.0 / (s * sxx - sx * sx)
        level, slope = per * (sxx * sy - sx * sxy), per * (s * sxy - sx * sy)
        rest = np.where(inside, y - level[:, None] - slope[:, None] * x, np.nan)
        apart = np.nanmedian(np.abs(rest - np.nanmedian(rest, axis=1)[:, None]), axis=1)
        scatter = np.maximum(SCATTER * apart, 1e-6 * (np.abs(level) + 1.0))
        weight = np.square(np.maximum(1.0 - np.square(rest / (TUKEY * scatter[:, None])), 0.0)) + 1e-9
        rest, weight = np.nan_to_num(rest), np.where(inside, weight, 0.0)
    sigma = np.sqrt(np.sum(weight * rest * rest, axis=1) / np.maximum(weight.sum(axis=1) - 2.0, 1.0))
    return level, sigma * np.sqrt(per * sxx)
