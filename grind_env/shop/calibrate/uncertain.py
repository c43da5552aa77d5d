"""What a calibration leaves open: the table `[uncertainty]` of its catalogue file."""

import numpy as np

from grind_env.arrays import Numbers
from grind_env.machine.job import Job
from grind_env.machine.job.worlds import USUAL_DRIFT
from grind_env.shop.calibrate.fit import Fit
from grind_env.shop.calibrate.parameters import chosen_parameters
from grind_env.shop.calibrate.solver import Data
from grind_env.shop.measurements.sheet import Floats

ENOUGH_PARTS = 4
"""From which on it can be told whether levels wander from part to part."""
MANY_PARTS = 20
"""From which on it can be told that they wander by more than they usually do."""
SINGULAR = 1e-6
"""By which correlations are less than found, so that they may be rounded."""


def missed(fitted: Fit, data: Data, block: Numbers) -> tuple[float, float]:
    """Logarithmic standard deviation of the power of blocks that the model does not follow, and of a step of its level.

    By parts that are predicted from all others, if there are several; the steps are those from part to part.
    """
    predicted = np.where(np.isfinite(fitted.held_out), fitted.held_out, fitted.predicted)
    rest = np.where(fitted.used, data.value - predicted, np.nan)
    seen = np.isfinite(rest) & (block > 0)
    of_block = _levels(rest[seen], data.value[seen], data.error[seen], block[seen])
    of_part = _levels(rest[seen], data.value[seen], data.error[seen], data.part[seen])
    drift = 0.0
    if of_part.size > ENOUGH_PARTS:
        once, twice = (float(np.mean(np.square(of_part[k:] - of_part[:-k]))) for k in (1, 2))
        drift = float(np.sqrt(max(twice - once, 0.0)))
    if of_part.size < MANY_PARTS:  # what a model misses of a few parts may look like a drift, which adds up over a lot
        drift = min(drift, USUAL_DRIFT)
    return float(np.sqrt(np.mean(np.square(of_block)))), drift


def _levels(rest: Floats, value: Floats, error: Floats, group: Numbers) -> Floats:
    """Of each group, how much of its power is missed, as far as it is known."""
    _, number = np.unique(group, return_inverse=True)
    weight = value / np.square(error)
    found: Floats = np.bincount(number, weight * rest) / np.bincount(number, weight * value)
    return found


def uncertainty_lines(job: Job, fitted: Fit, source: str, residual: float, drift: float) -> list[str]:
    """The table as TOML."""
    left = fitted.left
    names = [each.name for each in left.parameters]
    others = [each for each in chosen_parameters(job, None) if each.name not in names]
    count, spread = len(names), left.spread * np.array([each.spread for each in left.parameters])
    scale = np.sqrt(np.diag(left.covariance))
    correlation = np.eye(count + len(others))
    correlation[:count, :count] = (1.0 - SINGULAR) * left.covariance / np.outer(scale, scale)
    np.fill_diagonal(correlation, 1.0)
    rows = ",\n".join("  [" + ", ".join(f"{each:.8g}" for each in row) + "]" for row in correlation.round(8).tolist())
    return [
        "# What is not known after it: standard deviations of logarithms, of exponents themselves, and how they hang",
        "# together; of the power of a block that is not followed, and of a step of its level from part to part.",
        "[uncertainty]",
        f"source = {source}",
        f"names = [{', '.join(f'{chr(34)}{each}{chr(34)}' for each in (*names, *(each.name for each in others)))}]",
        f"spread = [{', '.join(f'{each:.4g}' for each in (*spread.tolist(), *(each.spread for each in others)))}]",
        f"correlation = [\n{rows},\n]",
        f"residual = {residual:.4g}",
        f"drift = {drift:.4g}",
    ]
