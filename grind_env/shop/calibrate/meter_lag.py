"""Lag of the power meter: its time constant, and the strokes of a program in the log of such a meter."""

from dataclasses import replace

import numpy as np

from grind_env.array_types import Floats
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.log_alignment import Alignment, clarity, refined
from grind_env.shop.calibrate.power_logs import Log, averaged
from grind_env.shop.calibrate.stroke_matching import ENOUGH_QUALITY, align
from grind_env.shop.calibrate.stroke_schedule import Pattern

NEEDED = 0.7  #: least median correlation of the runs at which a log is taken to be of the program
FINEST = 0.05  #: shortest interval of rows, s; rows closer together are averaged
LAGS = (0.05, 0.1, 0.2, 0.4)  #: time constants of the meter that are tried, s
LONG_LAGS = (0.5, 1.0, 2.0)  #: longer time constants, s, tried if the strokes are not clear without one
STEP, LEAST_STEP = 1.41, 1.03  #: first and last factor of the steps that refine the time constant
LONG_LAG_GAIN = 0.02  #: least gain of correlation by a long time constant
LONGEST_INTERVAL = 0.2  #: longest interval of rows at which a time constant can be found, s
SHORT_LAG_GAIN = 0.002  #: least gain of correlation by a short time constant
LAG_RUNS = 6  #: number of runs in which the time constant is searched


def find_program(log: Log, pattern: Pattern, expected: Floats) -> tuple[Alignment, float]:
    """Return the strokes of a program in a log, and the meter's time constant, s; 0 if it is short.

    A `CalibrationError` says how far a log is from matching the program.
    """
    best, lag = align(log, pattern, expected), 0.0
    if best.quality < ENOUGH_QUALITY and log.sure_of_time and log.interval <= LONGEST_INTERVAL:
        means = averaged(log, log.time, FINEST)
        for each in LONG_LAGS:
            found = align(replace(means, lag=each), pattern, expected)
            if found.executions and found.quality > best.quality + LONG_LAG_GAIN:
                best, lag = found, each
    if best.executions == 0 or best.quality < NEEDED:
        reached = f"{best.quality:.3f}" if best.executions else "none worth naming"
        raise CalibrationError(
            f"the log does not match the program: where they agree best the correlation is {reached}, and {NEEDED} is "
            "needed; check that it is the log of this program and job, and that the right column is taken for the power"
        )
    return best, lag


def with_lag(log: Log, pattern: Pattern, found: Alignment, expected: Floats, about: float) -> tuple[Log, Alignment]:
    """Return a log with the lag of its meter, and the strokes in it.

    The lag, a short one or one near `about`, is the one with the best correlation between the log and the expected
    power.
    """
    best, step = about, STEP
    tried = {0.0: SHORT_LAG_GAIN}

    def quality(lag: float) -> float:
        if lag not in tried:
            tried[lag] = clarity(found, replace(log, lag=lag), pattern, expected, LAG_RUNS)
        return tried[lag]

    if log.interval <= LONGEST_INTERVAL:
        tried[0.0] += clarity(found, log, pattern, expected, LAG_RUNS)
        best = max((0.0, *LAGS, about), key=quality)
        while best and step > LEAST_STEP:
            nearer = max((best, best / step, best * step), key=quality)
            best, step = nearer, step if nearer != best else np.sqrt(step)
    log = replace(log, lag=best)
    return log, refined(found, log, pattern, expected)


def sharpened(log: Log) -> Floats:
    """Return the power as a meter without lag shows it.

    A meter of first order shows y with lag dy/dt = P - y, so that the power is P = y + lag dy/dt.
    """
    return log.power + log.lag * np.gradient(log.power, log.time) if log.lag else log.power
