"""The meter of the power: rows finer than needed as their means, and its lag taken out."""

from dataclasses import replace

import numpy as np

from grind_env.shop.calibrate.align import SURE, align, refuse_unlike
from grind_env.shop.calibrate.alignment import Alignment
from grind_env.shop.calibrate.likeness import clarity, refined
from grind_env.shop.calibrate.logs import Log, averaged
from grind_env.shop.calibrate.pattern import Pattern
from grind_env.shop.measurements.sheet import Floats

FINEST = 0.05
"""s; rows closer together than that are averaged."""
LAGS = (0.05, 0.1, 0.2, 0.4)
"""s; time constants that are tried."""
LONG_LAGS = (0.5, 1.0, 2.0)
"""s; that are tried where the strokes are not clearly seen without."""
STEP, LEAST_STEP = 1.41, 1.03
"""Factors by which it is then tried to come nearer."""
CLEARER = 0.02
"""By which their correlation must be better than without."""
FAST_ENOUGH = 0.2
"""s between rows up to which a lag can be told."""
CLEARLY = 0.002
"""By which the correlation must be better than without."""
LOOKED_AT = 6
"""Runs of strokes in which the lag is looked for."""


def find(log: Log, pattern: Pattern, expected: Floats) -> tuple[Alignment, float]:
    """The strokes of a program in a log, and about which time constant the meter has, if it is long, else 0, s."""
    best, lag = align(log, pattern, expected), 0.0
    if best.quality < SURE and log.sure_of_time and log.interval <= FAST_ENOUGH:
        means = averaged(log, log.time, FINEST)
        for each in LONG_LAGS:
            found = align(replace(means, lag=each), pattern, expected)
            if found.executions and found.quality > best.quality + CLEARER:
                best, lag = found, each
    refuse_unlike(best)
    return best, lag


def with_lag(log: Log, pattern: Pattern, found: Alignment, expected: Floats, about: float) -> tuple[Log, Alignment]:
    """A log with the lag of its meter, and the strokes in it.

    The lag is that with which the log is most like what such a meter shows of the program, of short ones or of those
    `about` a long one.
    """
    best, step = about, STEP
    tried = {0.0: CLEARLY}

    def quality(lag: float) -> float:
        if lag not in tried:
            tried[lag] = clarity(found, replace(log, lag=lag), pattern, expected, LOOKED_AT)
        return tried[lag]

    if log.interval <= FAST_ENOUGH:
        tried[0.0] += clarity(found, log, pattern, expected, LOOKED_AT)
        best = max((0.0, *LAGS, about), key=quality)
        while best and step > LEAST_STEP:
            nearer = max((best, best / step, best * step), key=quality)
            best, step = nearer, step if nearer != best else np.sqrt(step)
    log = replace(log, lag=best)
    return log, refined(found, log, pattern, expected)


def sharpened(log: Log) -> Floats:
    """The power as a meter without lag shows it.

    What a meter of first order shows, y, follows the power P by lag dy/dt = P - y: so y + lag dy/dt is the power.
    """
    return log.power + log.lag * np.gradient(log.power, log.time) if log.lag else log.power
