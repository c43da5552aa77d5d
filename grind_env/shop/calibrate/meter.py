"""The meter of the power: rows finer than needed as their means, and its lag taken out."""

from dataclasses import replace

import numpy as np

from grind_env.shop.calibrate.align import SURE, Alignment, align, refined, refuse_unlike
from grind_env.shop.calibrate.logs import Log
from grind_env.shop.calibrate.pattern import Pattern
from grind_env.shop.calibrate.sheet import Floats

FINEST = 0.05
"""s; rows closer together than that are averaged."""
LAGS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
"""s; time constants that are tried."""
LONG_LAGS = (0.5, 1.0, 2.0)
"""s; that are tried where the strokes are not clearly seen without."""
AROUND = (0.5, 0.7, 0.85, 1.0, 1.2, 1.5)
"""Over the one of these that shows them best, that are tried then."""
CLEARER = 0.02
"""By which their correlation must be better than without."""
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


def find(log: Log, pattern: Pattern, expected: Floats) -> tuple[Alignment, float]:
    """The strokes of a program in a log, and about which time constant the meter has, if it is long, else 0, s.

    Raises:
        CalibrationError: they are not in it.
    """
    best, lag = align(log, pattern, expected), 0.0
    if best.quality < SURE and log.sure_of_time and log.interval <= FAST_ENOUGH:
        means = averaged(log, 1.0)
        for each in LONG_LAGS:
            found = align(sharpened(means, each), pattern, expected)
            if found.executions and found.quality > best.quality + CLEARER:
                best, lag = found, each
    refuse_unlike(best)
    return best, lag


def without_lag(
    log: Log, pattern: Pattern, found: Alignment, expected: Floats, about: float
) -> tuple[Log, Alignment, float]:
    """A log as a meter without lag shows it, the strokes in it, and the time constant of the meter, s.

    What a meter of first order shows, y, follows the power P by lag dy/dt = P - y: so y + lag dy/dt is the power. The
    lag is that with which the log is most like the program, of short ones or of those `about` a long one.
    """
    if log.interval > FAST_ENOUGH:
        return log, found, 0.0
    few = found.first(LOOKED_AT)
    best, least = 0.0, refined(few, log, pattern, expected).quality + CLEARLY
    for lag in LAGS if not about else [about * each for each in AROUND]:
        quality = refined(few, sharpened(log, lag), pattern, expected).quality
        if quality > least:
            best, least = lag, quality
    sharp = sharpened(log, best)
    return sharp, refined(found, sharp, pattern, expected), best


def sharpened(log: Log, lag: float) -> Log:
    """A log as a meter without that lag, s, shows it."""
    return replace(log, power=log.power + lag * np.gradient(log.power, log.time), lag=lag) if lag else log
