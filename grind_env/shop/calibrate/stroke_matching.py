"""Place the strokes of a program in a power log, by the shape of their runs and in order.

For each run and every place in the log, the expected power of the model is correlated with the logged power, so that
idle power and scale of the meter do not matter. Dynamic programming then puts all runs in order, with waiting times of
any length for a dress, a gauge or the next part.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats, Numbers
from grind_env.optional_libraries import needing
from grind_env.shop.calibrate.log_alignment import (
    ALIKE_RUNS,
    FEWEST,
    FINE,
    MARGIN,
    MATCHES,
    SAME_FEED,
    Alignment,
    LogMatch,
    between,
    template,
)
from grind_env.shop.calibrate.power_logs import Log, averaged
from grind_env.shop.calibrate.stroke_schedule import Pattern

with needing("shop", "a calibration needs"):
    from scipy import fft

#: greatest step between places in the log that are tried, s; the step is the interval of its rows, at least `FINE`
COARSE = 0.2
LOWEST, HIGHEST = 0.5, 1.5  #: lowest and highest feed override that is searched
#: logarithmic standard deviation of overrides; an explanation of the log without an override is preferred
USUAL_OVERRIDE = 0.2
SHORTEST_PAUSE = 0.3  #: least share of the programmed pause between two runs
#: least log-likelihood that a further execution must add, as a share of the mean of the earlier ones; less is noise
LEAST_EXECUTION_GAIN = 0.03
#: greatest factor between the gain (power over expected power) of an execution and of the most likely one
MOST_GAIN_RATIO = 2.0
ENOUGH_QUALITY = 0.9  #: median correlation from which on no other unit of time is tried
MOST_EXECUTIONS = 150


def align(log: Log, pattern: Pattern, expected: Floats) -> Alignment:
    """Return the runs of a program in a log, perhaps none; `expected` is the power of each stroke above idle, W.

    In a log without a time unit ms is tried first; if ms agrees badly, the better of ms and s is taken.
    """
    if log.sure_of_time:
        return _aligned(log, pattern, expected, 1.0)
    in_ms = _aligned(log, pattern, expected, 1e-3)
    if in_ms.quality >= ENOUGH_QUALITY:
        return in_ms
    in_s = _aligned(log, pattern, expected, 1.0)
    return max(in_s, in_ms, key=lambda each: each.quality)


class _Binned(NamedTuple):
    """Log in even steps, with the Fourier transforms for correlations."""

    origin: float
    step: float
    size: int
    filled: NDArray[np.complex128]
    sums: NDArray[np.complex128]
    # sums of filled bins, of the power in them and of its square, up to each bin; twice around, shape (3, bins)
    totals: Floats
    length: int
    lag: float


def _aligned(log: Log, pattern: Pattern, expected: Floats, unit: float) -> Alignment:
    time = unit * log.time
    step = float(np.clip(np.median(np.diff(time)), FINE, COARSE))
    log = averaged(log, time, step)
    spans = np.array([pattern.times(run)[2] for run in range(pattern.runs)])
    total, length = float(spans.sum() + pattern.pause.sum()), float(log.time[-1] - log.time[0])
    none = np.empty((0, pattern.runs))
    best = Alignment(none, none, none, none, none, unit)
    if log.time.size < FEWEST or not 0.3 * spans.max() < length < MOST_EXECUTIONS * 20.0 * total:
        return best
    binned = _transformed(log, step, total)
    scores, overrides, gains = zip(
        *(_scores(binned, pattern, expected, run) for run in range(pattern.runs)), strict=True
    )
    scores = _alike(scores, overrides, gains, binned, pattern)
    most = min(int(length / (0.6 * total)) + 2, MOST_EXECUTIONS)
    so_far, first = 0.0, np.ones(1)
    for number, (begin, override, likely) in enumerate(_placed(scores, overrides, binned, pattern, most)):
        found = LogMatch(log, pattern, expected, begin, override).alignment(unit)
        # tried at n places, noise reaches a log-likelihood of ln n somewhere
        worth_it = number == 0 or likely - so_far >= max(LEAST_EXECUTION_GAIN * so_far / number, np.log(binned.size))
        matches, gain = (
            _of_executions(each, found.correlation, pattern, expected) for each in (found.correlation, found.gain)
        )
        first = gain if number == 0 else first
        alike = first.size and np.all(between(gain, float(first.mean()), MOST_GAIN_RATIO))
        if not (worth_it and np.all(matches >= MATCHES) and alike):
            break
        best, so_far = found, likely
    if not best.executions:
        return best
    match = LogMatch(log, pattern, expected, best.begin, best.override)
    match.settle()
    return match.alignment(unit)


def _alike(
    scores: Sequence[Floats], overrides: Sequence[Floats], gains: Sequence[Floats], binned: _Binned, pattern: Pattern
) -> tuple[Floats, ...]:
    """Return the scores, set to 0 where the power is far weaker or stronger than in the most likely execution.

    Noise can have the expected shape, too.
    """
    begin, _, _ = _placed(scores, overrides, binned, pattern, 1)[0]
    at = np.clip(np.round((begin[0] - binned.origin) / binned.step).astype(np.int64), 0, binned.size - 1)
    weight = np.array([scores[run][place] for run, place in enumerate(at.tolist())])
    gain = np.array([gains[run][place] for run, place in enumerate(at.tolist())])
    order = np.argsort(gain)
    total = np.cumsum(weight[order])
    usual = float(gain[order[np.searchsorted(total, 0.5 * total[-1])]])
    return tuple(
        np.where(between(gained, usual, ALIKE_RUNS), score, 0.0) for score, gained in zip(scores, gains, strict=True)
    )


def _transformed(log: Log, step: float, around: float) -> _Binned:
    """Return the log in bins, with an empty span of `around` s before and after it, into which a part may reach."""
    time, power = log.time, log.power
    origin = float(time[0]) - around
    size = int(np.ceil((time[-1] - time[0] + 2.0 * around) / step)) + 1
    length = fft.next_fast_len(size + int(np.ceil((around + 2.0 * MARGIN) / step * 2.5)), real=True)
    place = np.round((time - origin) / step).astype(np.int64)
    filled, sums = np.zeros(length), np.zeros(length)
    np.add.at(filled, place, 1.0)
    np.add.at(sums, place, power - np.median(power))
    sums /= np.maximum(filled, 1.0)
    filled = np.minimum(filled, 1.0)
    totals = np.cumsum(np.tile([filled, sums, sums * sums], 2), axis=1)
    return _Binned(
        origin, step, size, fft.rfft(filled), fft.rfft(sums), np.pad(totals, ((0, 0), (1, 0))), length, log.lag
    )


def _scores(binned: _Binned, pattern: Pattern, expected: Floats, run: int) -> tuple[Floats, Floats, Floats]:
    """Return the likelihood of a run at each place, its override, and its power over the expected power.

    The likelihood is the logarithm of the ratio to the likelihood of a constant power.
    """
    strokes = int((pattern.run == run).sum())
    apart = np.clip(0.2 / strokes, 0.004, 0.05)
    low, high = (LOWEST, HIGHEST) if pattern.overridable else (1.0 / SAME_FEED, SAME_FEED)
    tried = np.exp(np.arange(np.log(low), np.log(high), apart))
    tried = np.append(tried[np.abs(np.log(tried)) > 0.4 * apart], 1.0)
    best, override, gain = np.full(binned.size, -np.inf), np.ones(binned.size), np.zeros(binned.size)
    for each in tried.tolist():
        at = np.arange(-MARGIN, pattern.times(run, each)[2] + MARGIN, binned.step)
        if at.size > binned.length - binned.size:
            continue
        shape = template(pattern, expected, run, each, at, binned.step, binned.lag)
        highest = max(float(shape.max()), 1e-9)
        shape = shape / highest
        form, square = (np.conj(fft.rfft(values, binned.length)) for values in (shape, shape * shape))
        s, ss, ys = (
            fft.irfft(first * second, binned.length)
            for first, second in ((binned.filled, form), (binned.filled, square), (binned.sums, form))
        )
        ends = at.size + binned.length
        n, y, yy = binned.totals[:, at.size : ends] - binned.totals[:, : binned.length]
        n = np.maximum(n, 1.0)
        covariance, spread, variance = ys - y * s / n, ss - s * s / n, yy - y * y / n
        squared = np.where(
            (covariance > 0.0) & (spread > 1e-3) & (variance > 1e-9 * np.abs(yy).max()) & (n >= FEWEST),
            covariance**2 / np.maximum(spread * variance, 1e-300),
            0.0,
        )
        likely = -0.5 * n * np.log1p(-np.minimum(squared, 0.9999)) - 0.5 * (np.log(each) / USUAL_OVERRIDE) ** 2
        factor = covariance / np.maximum(spread, 1e-3) / highest
        # an index of the array is the place of the margin before the run
        likely, factor = (np.roll(values, round(MARGIN / binned.step))[: binned.size] for values in (likely, factor))
        better = likely > best
        best, override, gain = (
            np.where(better, new, old) for new, old in ((likely, best), (each, override), (factor, gain))
        )
    return np.maximum(best, 0.0), override, gain


def _placed(
    scores: Sequence[Floats], overrides: Sequence[Floats], binned: _Binned, pattern: Pattern, most: int
) -> list[tuple[Floats, Floats, float]]:
    """Return the most likely 1, 2, ... executions: begins and overrides, shape (executions, runs), and likelihood."""
    reached = np.zeros(binned.size)  # best score of the earlier runs, if they end by this place
    came: Numbers = np.zeros(binned.size, np.int64)
    chains: list[Numbers] = []
    found = []
    places = np.arange(binned.size)
    lengths = [_lengths(pattern, run, overrides[run], binned.step) for run in range(pattern.runs)]
    for number in range(most * pattern.runs):
        run = number % pattern.runs
        total = reached + scores[run]
        chains.append(came)
        end = np.minimum(places + lengths[run], binned.size - 1)
        next_reached, next_came = np.full(binned.size, -np.inf), np.zeros(binned.size, np.int64)
        order = np.argsort(total, kind="stable")
        next_reached[end[order]], next_came[end[order]] = total[order], order  # the last of several is the best
        running = np.maximum.accumulate(next_reached)
        latest = np.maximum.accumulate(np.where(next_reached >= running, places, 0))
        reached, came = running, next_came[latest]
        if run == pattern.runs - 1:
            last = int(np.argmax(total))
            found.append((*_traced(chains, last, binned, overrides, pattern.runs), float(total[last])))
    return found


def _lengths(pattern: Pattern, run: int, overrides: Floats, step: float) -> Numbers:
    """Return the steps from the begin of a run to the earliest begin of the next one."""
    span, after = pattern.times(run)[2], pattern.pause[(run + 1) % pattern.runs]
    lengths: Numbers = np.floor((0.98 * span / overrides + SHORTEST_PAUSE * after) / step).astype(np.int64)
    return np.maximum(lengths, 1)


def _traced(
    chains: Sequence[Numbers], last: int, binned: _Binned, overrides: Sequence[Floats], runs: int
) -> tuple[Floats, Floats]:
    places = [last]
    for came in reversed(chains[1:]):
        places.append(int(came[places[-1]]))
    order = np.array(places[::-1])
    chosen = np.array([overrides[number % runs][place] for number, place in enumerate(order.tolist())])
    return (binned.origin + binned.step * order).reshape(-1, runs), chosen.reshape(-1, runs)


def _of_executions(values: Floats, correlation: Floats, pattern: Pattern, expected: Floats) -> Floats:
    """Return the mean of each execution; a run's weight is the sum of its squared expected powers."""
    weights = np.array([np.square(expected[pattern.run == run]).sum() for run in range(pattern.runs)])
    weight = np.where(np.isfinite(correlation), weights, 0.0)
    return np.asarray((np.nan_to_num(values) * weight).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-300))
