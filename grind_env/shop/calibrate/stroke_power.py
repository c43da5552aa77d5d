"""Mean power above idle of each stroke of an aligned log, with its uncertainty."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats, Numbers
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.log_alignment import Alignment
from grind_env.shop.calibrate.meter_lag import sharpened
from grind_env.shop.calibrate.power_logs import Log
from grind_env.shop.calibrate.stroke_schedule import Pattern

#: least relative error of a model of the power of a stroke, and of a block of strokes that cross
DISCREPANCY, DISCREPANCY_ACROSS = 0.01, 0.03
#: shares of the time on the part, and of the time beside it, that are left out at begin and end: the wheel runs in and
#: out, and meters lag
EDGE_IN, EDGE_OUT = 0.35, 0.1
ENOUGH = 5  #: least number of samples a stroke for a mean of each stroke; with fewer there is one mean for each run
#: time that a table takes to turn, s. If a meter lags by more, the idle power is read in longer pauses, and short
#: strokes are averaged over all samples from the first stroke of a run until after the last
TURNS = 0.2
#: time at the ends of a long pause in which the idle power is read, in lags of the meter; at least a stroke's time
LAGS = 2.0
#: expected number of rows between strokes above which some must exist, and the least share of them that must exist
ENOUGH_RESTS, FEW_RESTS = 20.0, 0.2
FEWEST = 2  #: least number of samples of a stroke or run; with fewer it is left out
NEIGHBOURS = 40  #: number of samples between strokes from which the idle power under a stroke is read
HALF, ENOUGH_QUIET = 20, 8  #: greatest and least number of samples in pauses on either side of a stroke
FARTHEST = 120.0  #: greatest time between a stroke and the samples of its idle power, s
TUKEY = 4.0  #: multiple of the scatter from which on a sample has no weight
ROUNDS = 4
SCATTER = 1.4826  #: ratio of the standard deviation to the median deviation


def idle_at(
    when: Floats, time: Floats, power: Floats, pausing: NDArray[np.bool_] | None = None
) -> tuple[Floats, Floats]:
    """Return the idle power in the middle of each stroke (s), and its standard error, W; NaN without samples nearby.

    A robust straight line is fitted to the nearest samples between strokes (s, W), or to `pausing` samples alone if
    there are enough on both sides of a stroke.
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
        if pausing is None or min(before.size, after.size) < ENOUGH_QUIET:
            nearest = span[np.argsort(np.abs(time[span] - moment), kind="stable")[:NEIGHBOURS]]
        near[k, : nearest.size] = nearest
    idle, error = np.full((2, when.size), np.nan)
    known = near[:, 0] >= 0
    inside = near[known] >= 0
    x, y = np.where(inside, time[near[known]] - when[known, None], np.nan), np.where(inside, power[near[known]], np.nan)
    idle[known], error[known] = _lines(x, y)
    return idle, error


def _lines(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the value at x = 0 of a straight line through the points of each row, and its standard error.

    NaN is a missing point. The line is fitted with Tukey's bisquare by reweighting.
    """
    inside, span = np.isfinite(x), np.maximum(np.nanmax(np.abs(x), axis=1, initial=1e-9), 1e-9)
    x, weight = np.nan_to_num(x / span[:, None]), inside.astype(np.float64)
    for _ in range(ROUNDS):
        # a line through points on one side must not run away: a weight holds its slope near 0
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


class Observations(NamedTuple):
    """Observations from a log.

    Arrays have a value for each stroke; for each run if strokes are too short for the log; for each block of a cycle
    that crosses.
    """

    execution: Numbers  #: execution of the program, from 0
    stroke: Numbers  #: stroke of the program; of several the first one
    time: Floats  #: time of its middle, s of the log
    power: Floats  #: mean power above idle, W; in the unit of the log if the scale of its meter is unknown
    error: Floats  #: standard error of `power`
    idle: Floats  #: power of the idling spindle during the strokes
    weights: Floats  #: weights of the strokes of all executions, shape (observations, executions x strokes)
    by_stroke: bool  #: whether each is of one stroke, except in cycles that cross


def observe(log: Log, pattern: Pattern, found: Alignment) -> Observations:
    """Return the mean power of strokes or runs from a log in s."""
    time, power = log.time, sharpened(log)
    strokes, executions = pattern.run.size, found.executions
    on, off = (np.full((executions, strokes), np.nan) for _ in range(2))
    for row, run in np.argwhere(found.sure).tolist():
        chosen = pattern.run == run
        begins, ends, _ = pattern.times(run, float(found.override[row, run]))
        on[row, chosen], off[row, chosen] = found.begin[row, run] + begins, found.begin[row, run] + ends
    on[off <= on] = np.nan
    numbers = np.flatnonzero(np.isfinite(on.ravel()))
    numbers = numbers[np.argsort(on.ravel()[numbers])]
    starts, stops = on.ravel()[numbers], off.ravel()[numbers]
    of, idling = _sorted_out(time, starts, stops, log.dressing, log.lag)
    counts = np.bincount(of[of >= 0], minlength=numbers.size)
    _refuse_without_idle(time, starts, stops, of, idling)
    by_stroke = bool(np.median(np.diff(np.searchsorted(time, np.column_stack([starts, stops])), axis=1)) >= ENOUGH)
    if log.lag > TURNS and not by_stroke:
        of, counts = _as_wholes(time, starts, stops, log.dressing)
    middle = 0.5 * (starts + stops)
    pausing = _pausing(time, starts, stops)[idling] if log.lag > TURNS else None
    idle, idle_error = idle_at(middle, time[idling], power[idling], pausing)
    samples = _Samples(
        of=of,
        above=np.where(of >= 0, power - idle[np.maximum(of, 0)], np.nan),
        counts=counts,
        noise=_noise(of, power),
        idle=idle,
        idle_error=idle_error,
    )
    group = _groups(numbers, pattern, by_stroke)
    members = [np.flatnonzero(group == each) for each in range(int(group.max(initial=-1)) + 1)]
    members = [each for each in members if _tells(samples, each)]
    if not members:
        raise CalibrationError("no stroke of the program has samples in the log; log faster, or for longer")
    first = np.array([numbers[each[0]] for each in members])
    weights = np.zeros((len(members), executions * strokes))
    for row, each in enumerate(members):
        weights[row, numbers[each]] = counts[each] / counts[each].sum()
    means = np.array([_mean(samples, each) for each in members])
    return Observations(
        execution=first // strokes,
        stroke=first % strokes,
        time=np.array([middle[each].mean() for each in members]),
        power=means[:, 0],
        error=means[:, 1],
        idle=means[:, 2],
        weights=weights,
        by_stroke=by_stroke,
    )


def _refuse_without_idle(time: Floats, starts: Floats, stops: Floats, of: Numbers, idling: NDArray[np.bool_]) -> None:
    """Refuse a log recorded only above some power: between strokes it has only the wheel running in and out."""
    gap = starts[1:] - stops[:-1]
    short = gap < 2.0 * np.median(np.diff(starts, prepend=starts[:1] - 1.0))
    last = np.searchsorted(starts, time, side="right") - 1
    rests = idling & (last >= 0) & (last < gap.size)
    rests[rests] = short[last[rests]]
    share = 1.0 - EDGE_IN - EDGE_OUT
    in_strokes, in_rests = share * float(np.sum(stops - starts)), share * float(np.sum(gap[short]))
    expected = float((of >= 0).sum()) * in_rests / max(in_strokes, 1e-9)
    if expected > ENOUGH_RESTS and rests.sum() < FEW_RESTS * expected:
        raise CalibrationError(
            f"between its strokes the log has {rests.sum()} rows where about {expected:.0f} should be, so that the "
            "power of the idling spindle is not known; log all the time, and not only above some power"
        )


class _Samples(NamedTuple):
    """Samples of a log, sorted by strokes."""

    of: Numbers  #: number of the stroke of each sample, or -1
    above: Floats  #: power of each sample above idle, W
    counts: Numbers  #: number of samples of each stroke while the wheel is over the part
    noise: float  #: standard deviation of a sample, W
    idle: Floats  #: idle power under each stroke, W
    idle_error: Floats  #: standard error of `idle`, W


def _tells(samples: _Samples, members: Numbers) -> bool:
    """Return whether strokes have enough samples in total, and a known idle power wherever they have samples."""
    counts = samples.counts[members]
    return bool(counts.sum() >= FEWEST and np.isfinite(samples.idle[members[counts > 0]]).all())


def _mean(samples: _Samples, members: Numbers) -> tuple[float, float, float]:
    """Return the mean power of strokes above idle, its standard error, and the idle power under them, W."""
    counts = samples.counts[members]
    share = counts / counts.sum()
    # the idle power of neighbouring strokes is read from the same samples: its errors do not average out
    idle_error = float(np.sum(share * np.nan_to_num(samples.idle_error[members])))
    above = samples.above[np.isin(samples.of, members)]
    error = above.size * float(np.hypot(samples.noise / np.sqrt(above.size), idle_error))
    return (
        float(np.sum(above)) / counts.sum(),
        error / counts.sum(),
        float(np.sum(share * np.nan_to_num(samples.idle[members]))),
    )


def _groups(numbers: Numbers, pattern: Pattern, by_stroke: bool) -> Numbers:
    """Return for each stroke of all executions the index of its mean."""
    strokes = pattern.run.size
    execution, stroke = numbers // strokes, numbers % strokes
    own = stroke if by_stroke else strokes + pattern.run[stroke]
    keys = np.where(pattern.crosses[stroke], -1 - pattern.line[stroke], own)
    part = execution * pattern.parts + pattern.part[stroke]
    _, group = np.unique(np.column_stack([part, keys]), axis=0, return_inverse=True)
    return np.asarray(group.ravel())


def _sorted_out(
    time: Floats, starts: Floats, stops: Floats, dressing: NDArray[np.bool_], lag: float
) -> tuple[Numbers, NDArray[np.bool_]]:
    """Return for each sample its stroke, or -1, and whether it lies between strokes; samples near edges are neither."""
    last = np.searchsorted(starts, time, side="right") - 1
    here = np.maximum(last, 0)
    length = stops[here] - starts[here]
    begin, end = starts[here] + EDGE_IN * length, stops[here] - EDGE_OUT * length
    within = (last >= 0) & (time >= begin) & (time <= end) & ~dressing
    following = np.minimum(last + 1, starts.size - 1)
    usual = float(np.median(np.diff(starts))) if starts.size > 1 else 1.0
    # in a longer gap the wheel may be dressed or the spindle may stand still: only the ends of the gap count
    gap = np.minimum(np.where((last >= 0) & (following > last), starts[following] - stops[here], usual), usual)
    begin, end = stops[here] + EDGE_IN * gap, starts[following] - EDGE_OUT * gap
    clear = ((last < 0) | (time >= begin)) & ((following == last) | (time <= end)) & ~dressing
    ends = max(usual, LAGS * lag)
    near = ((last >= 0) & (time <= stops[here] + ends)) | ((following > last) & (time >= starts[following] - ends))
    between = clear & near
    return np.where(within, last, -1), between


def _as_wholes(time: Floats, starts: Floats, stops: Floats, dressing: NDArray[np.bool_]) -> tuple[Numbers, Numbers]:
    """Return for each sample the last stroke begun, or -1 after the run; and the samples of each stroke on the part."""
    last = np.searchsorted(starts, time, side="right") - 1
    here = np.maximum(last, 0)
    over = float(np.median(starts[1:] - stops[:-1])) if starts.size > 1 else 0.0
    within = (last >= 0) & (time <= stops[here] + over) & ~dressing
    counts = np.bincount(last[within & (time <= stops[here])], minlength=starts.size)
    return np.where(within, last, -1), counts


def _pausing(time: Floats, starts: Floats, stops: Floats) -> NDArray[np.bool_]:
    """Return which samples are in a pause; the short gap of a table turn is no pause, because meters hardly show it."""
    last = np.searchsorted(starts, time, side="right") - 1
    inside = (last >= 0) & (last < starts.size - 1)
    here = np.clip(last, 0, starts.size - 2) if starts.size > 1 else np.zeros(time.size, np.int64)
    usual = float(np.median(np.diff(starts))) if starts.size > 1 else 0.0
    gap = np.where(inside, starts[np.minimum(here + 1, starts.size - 1)] - stops[here], np.inf)
    return np.asarray(gap > usual, np.bool_)


def _noise(of: Numbers, power: Floats) -> float:
    """Return the standard deviation of a sample within a stroke, W, enlarged if neighbours are correlated."""
    same = (of[1:] >= 0) & (of[1:] == of[:-1])
    if same.sum() < 2 * ENOUGH:
        inside = power[of >= 0]
        return SCATTER * float(np.median(np.abs(inside - np.median(inside)))) if inside.size else 0.0
    count = np.maximum(np.bincount(of[of >= 0]), 1)
    mean = np.bincount(of[of >= 0], power[of >= 0]) / count
    rest = np.where(of >= 0, power - mean[np.maximum(of, 0)], 0.0)
    variance = float(np.mean(np.square(rest[of >= 0]))) * float(np.mean(count)) / max(float(np.mean(count)) - 1.0, 0.5)
    alike = float(np.clip(np.mean((rest[1:] * rest[:-1])[same]) / max(variance, 1e-12), 0.0, 0.95))
    return float(np.sqrt(variance * (1.0 + alike) / (1.0 - alike)))
