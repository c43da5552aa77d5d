"""The meter of the power: rows finer than needed as their means, and its lag taken out."""

from dataclasses import replace

import numpy as np

from grind_env.shop.calibrate.align import Alignment, refined
from grind_env.shop.calibrate.logs import Log
from grind_env.shop.calibrate.pattern import Pattern
from grind_env.shop.calibrate.sheet import Floats

FINEST = 0.05
"""s; rows closer together than that are averaged."""
LAGS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
"""s; time constants that are tried."""
FAST_ENOUGH = 0.2
"""s between rows up to which a lag can be told."""
CLEARLY = 0.002
"""By which the correlation must be better than without."""
LOOKED_AT = 3
"""Executions in which the lag is looked for."""


def averaged(log: Log, unit: float) -> Log:
    """A log in s, with rows closer together than `FINEST` as their mean.

    Args:
        log: the log.
        unit: s of a unit of its time.
    """
    time = log.time * unit
    number = np.floor((time - time[0]) / FINEST).astype(np.int64)
    _, where, count = np.unique(number, return_inverse=True, return_counts=True)
    means = (np.bincount(where, values) / count for values in (time, log.power, log.dressing.astype(np.float64)))
    time, power, dressing = means
    return replace(log, time=time, power=power, dressing=dressing > 0.0)


def without_lag(log: Log, pattern: Pattern, found: Alignment, expected: Floats) -> tuple[Log, Alignment, float]:
    """A log as a meter without lag shows it, the strokes in it, and the time constant of the meter, s.

    What a meter of first order shows, y, follows the power P by lag dy/dt = P - y: so y + lag dy/dt is the power. The
    lag is that with which the log is most like the program.
    """
    if log.interval > FAST_ENOUGH:
        return log, found, 0.0
    few = found.first(LOOKED_AT)
    best, least = 0.0, refined(few, log, pattern, expected).quality + CLEARLY
    for lag in LAGS:
        quality = refined(few, sharpened(log, lag), pattern, expected).quality
        if quality > least:
            best, least = lag, quality
    sharp = sharpened(log, best)
    return sharp, refined(found, sharp, pattern, expected), best


def sharpened(log: Log, lag: float) -> Log:
    """A log as a meter without that lag, s, shows it."""
    return replace(log, power=log.power + lag * np.gradient(log.power, log.time)) if lag else log
