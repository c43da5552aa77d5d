"""Where the strokes of a program lie in a log: the program's runs of strokes, found by their shape, in their order.

Run by run and for every place in the log, the power that the model expects is compared with the power there, whatever
the idle power and the scale of the meter are; dynamic programming then puts all runs in order. How long is waited for a
dress, a gauge or the next part does not matter.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Numbers
from grind_env.extras import needing
from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.calibrate.logs import Log
from grind_env.shop.calibrate.pattern import Pattern
from grind_env.shop.calibrate.sheet import Floats

with needing("shop", "a calibration needs"):
    from scipy import fft, optimize

FINE, COARSE = 0.05, 0.2
"""s; steps of places in the log: as its rows lie, between these."""
MARGIN = 2.0
"""s before and after a run that must look like no stroke."""
LOWEST, HIGHEST = 0.5, 1.5
"""Feed overrides that are looked for."""
USUAL_OVERRIDE = 0.2
"""Logarithmic spread of overrides: what else explains the log is preferred."""
SAME_FEED = 1.04
"""An override by which a machine may differ from its model without one."""
ENOUGH_PARTS, MOST_PARTS = 3, 0.75
"""From which on, and share of them, a feed that they have in common is no override."""
SHORTEST_PAUSE = 0.3
"""Of the pause that the program makes between two runs."""
FEWEST = 5
"""Samples of which a correlation tells anything."""
MATCHES, NEEDED = 0.5, 0.7
"""Correlation from which on a run or a part is taken to be in the log, and what is needed of their median."""
WORTH = 0.03
"""Of the likelihood that each execution before has added: what one more must add, or it is noise."""
ALIKE, ALIKE_RUNS = 2.0, 4.0
"""Factors by which the power over that expected may differ: of one execution from the most likely one, and of a run
from the others."""
ODD, POOR = 3.0, 0.8
"""Times what the others miss by, and correlation, from and up to which a run is not as it is programmed."""
SURE = 0.9
"""Median correlation from which on no other unit of time is tried."""
UNSURE = 0.8
"""Of the best correlation of a run: what it must have a stroke later to be worth a trial."""
MOST_EXECUTIONS = 150


@dataclass(frozen=True, slots=True)
class Alignment:
    """Where the runs of a program lie in a log; arrays have shape (executions, runs).

    Attributes:
        begin: of each run, s of the log.
        override: of the feed in it.
        correlation: of the power expected in it with that of the log; NaN if the log has no samples there.
        gain: of the power in the log over that expected.
        rest: standard deviation of the power in the log from what is expected, in its unit.
        time_unit: s of a unit of the log's time; 1 unless it was found out.
    """

    begin: Floats
    override: Floats
    correlation: Floats
    gain: Floats
    rest: Floats
    time_unit: float = 1.0

    @property
    def executions(self) -> int:
        """How often the program was run."""
        return len(self.begin)

    def _only(self, executions: Numbers | slice) -> "Alignment":
        """That of some of the executions."""
        begin, override, correlation, gain, rest = (
            values[executions] for values in (self.begin, self.override, self.correlation, self.gain, self.rest)
        )
        return replace(self, begin=begin, override=override, correlation=correlation, gain=gain, rest=rest)

    def first(self, executions: int) -> "Alignment":
        """That of the first executions alone."""
        return self._only(slice(executions))

    @property
    def known(self) -> "Alignment":
        """That of the executions of which a run is sure; other work may look like one from afar."""
        return self._only(np.flatnonzero(self.sure.any(axis=1)))

    @property
    def quality(self) -> float:
        """Median of the correlations, from 0 to 1."""
        return float(np.nanmedian(self.correlation)) if np.isfinite(self.correlation).any() else 0.0

    @property
    def sure(self) -> NDArray[np.bool_]:
        """Which runs are in the log as they are programmed: as strong as the others, and no worse than they."""
        sure: NDArray[np.bool_] = self.correlation >= MATCHES
        if sure.any():
            sure = sure & _between(self.gain, float(np.median(self.gain[sure])), ALIKE_RUNS)
        if sure.any():
            sure = sure & ((self.correlation >= POOR) | (self.rest <= ODD * np.median(self.rest[sure])))
        return sure

    def overrides(self, pattern: Pattern) -> list[float]:
        """Of each part; 1 where the feed is as programmed but for what the machine differs from its model.

        What all parts are ground with is how the machine runs this program, and no override.
        """
        usual = self.usual_override(pattern)
        found = [value / usual for value in self._medians(pattern)]
        return [1.0 if abs(np.log(value)) < np.log(SAME_FEED) else value for value in found]

    def usual_override(self, pattern: Pattern) -> float:
        """The one of most parts, where there are enough, else 1."""
        found = np.array(self._medians(pattern))
        usual = float(np.median(found))
        alike = np.mean(np.abs(np.log(found / usual)) < np.log(SAME_FEED)) >= MOST_PARTS
        return usual if found.size >= ENOUGH_PARTS and alike else 1.0

    def _medians(self, pattern: Pattern) -> list[float]:
        part = pattern.part[pattern.firsts]
        each = [(row, part == number) for row in range(self.executions) for number in range(pattern.parts)]
        found = [self.override[row, chosen & self.sure[row]] for row, chosen in each]
        return [float(np.median(values)) if values.size else 1.0 for values in found]


def align(log: Log, pattern: Pattern, expected: Floats) -> Alignment:
    """Find the strokes of a program in a log; without any execution where they are not in it.

    Args:
        log: the log.
        pattern: of the program.
        expected: power of each of its strokes above idle, W.
    """
    if log.sure_of_time:
        return _aligned(log.time, log.power, pattern, expected, 1.0)
    return _in_either_unit(log, pattern, expected)


def refuse_unlike(found: Alignment) -> None:
    """Refuse a log that does not match the program; a `CalibrationError` says how far off it is."""
    if found.executions == 0 or found.quality < NEEDED:
        reached = f"{found.quality:.3f}" if found.executions else "none worth naming"
        raise CalibrationError(
            f"the log does not match the program: where they agree best the correlation is {reached}, and {NEEDED} is "
            "needed; check that it is the log of this program and job, and that the right column is taken for the power"
        )


def _in_either_unit(log: Log, pattern: Pattern, expected: Floats) -> Alignment:
    """In a log whose unit of time is not stated: ms if that agrees well, which is soon tried, else the better one."""
    in_ms = _aligned(1e-3 * log.time, log.power, pattern, expected, 1e-3)
    if in_ms.quality >= SURE:
        return in_ms
    in_s = _aligned(log.time, log.power, pattern, expected, 1.0)
    return max(in_s, in_ms, key=lambda each: each.quality)


def shifted(found: Alignment, log: Log, pattern: Pattern, expected: Floats, run: int, strokes: int) -> Alignment | None:
    """The same with a run some strokes later in all executions; None if the log clearly says that it is not there."""
    begin = found.begin.copy()
    chosen = pattern.run == run
    period = pattern.times(run)[2] / chosen.sum()
    begin[:, run] += strokes * period / found.override[:, run]
    other = _judged(begin, found.override, log.time, log.power, pattern, expected, found.time_unit)
    if len(other.begin) != len(begin):
        return None
    before, after = found.correlation[:, run], other.correlation[:, run]
    both = np.isfinite(before) & np.isfinite(after)
    return other if both.any() and np.median(after[both]) >= UNSURE * np.median(before[both]) else None


class _Binned(NamedTuple):
    """A log in even steps, and the transforms of what is needed for correlations."""

    origin: float
    step: float
    size: int
    filled: NDArray[np.complex128]
    sums: NDArray[np.complex128]
    squares: NDArray[np.complex128]
    length: int


def _aligned(time: Floats, power: Floats, pattern: Pattern, expected: Floats, unit: float) -> Alignment:
    step = float(np.clip(np.median(np.diff(time)), FINE, COARSE))
    bin_time, bin_power = _averaged(time, power, step)
    spans = np.array([pattern.times(run)[2] for run in range(pattern.runs)])
    total = float(spans.sum() + pattern.pause.sum())
    none = np.empty((0, pattern.runs))
    if bin_time.size < FEWEST or not 0.3 * spans.max() < bin_time[-1] - bin_time[0] < MOST_EXECUTIONS * 20.0 * total:
        return Alignment(none, none, none, none, none, unit)
    binned = _transformed(bin_time, bin_power, step, total)
    scores, overrides, gains = zip(
        *(_scores(binned, pattern, expected, run) for run in range(pattern.runs)), strict=True
    )
    scores = _alike(scores, overrides, gains, binned, pattern, expected)
    most = min(int((bin_time[-1] - bin_time[0]) / (0.6 * total)) + 2, MOST_EXECUTIONS)
    best = Alignment(none, none, none, none, none, unit)
    so_far, first = 0.0, np.ones(1)
    for number, (begin, override, likely) in enumerate(_placed(scores, overrides, binned, pattern, most)):
        found = _judged(begin, override, bin_time, bin_power, pattern, expected, unit)
        # noise that is tried at so many places is somewhere as likely as their number
        worth_it = number == 0 or likely - so_far >= max(WORTH * so_far / number, np.log(binned.size))
        matches, gain = (
            _of_executions(each, found.correlation, pattern, expected) for each in (found.correlation, found.gain)
        )
        first = gain if number == 0 else first
        alike = first.size and np.all(_between(gain, float(first.mean()), ALIKE))
        if not (worth_it and np.all(matches >= MATCHES) and alike):
            break
        best, so_far = found, likely
    return best


def _between(values: Floats, usual: float, factor: float) -> NDArray[np.bool_]:
    return (values > usual / factor) & (values < usual * factor)


def _alike(
    scores: Sequence[Floats],
    overrides: Sequence[Floats],
    gains: Sequence[Floats],
    binned: _Binned,
    pattern: Pattern,
    expected: Floats,
) -> tuple[Floats, ...]:
    """Scores without places so much weaker or stronger than the most likely execution that they are chance.

    Noise has some shape, too.
    """
    begin, _, _ = _placed(scores, overrides, binned, pattern, 1)[0]
    at = np.clip(np.round((begin[0] - binned.origin) / binned.step).astype(np.int64), 0, binned.size - 1)
    weight = np.array([scores[run][place] for run, place in enumerate(at.tolist())])
    gain = np.array([gains[run][place] for run, place in enumerate(at.tolist())])
    order = np.argsort(gain)
    total = np.cumsum(weight[order])
    usual = float(gain[order[np.searchsorted(total, 0.5 * total[-1])]])
    return tuple(
        np.where(_between(gained, usual, ALIKE_RUNS), score, 0.0) for score, gained in zip(scores, gains, strict=True)
    )


def _averaged(time: Floats, power: Floats, step: float) -> tuple[Floats, Floats]:
    """Rows closer together than a step as their mean."""
    number = np.floor((time - time[0]) / step).astype(np.int64)
    _, where = np.unique(number, return_inverse=True)
    count = np.bincount(where)
    return np.bincount(where, time) / count, np.bincount(where, power) / count


def _transformed(time: Floats, power: Floats, step: float, around: float) -> _Binned:
    """Bins with an empty span of `around` s before and after the log, into which a part may reach."""
    origin = float(time[0]) - around
    size = int(np.ceil((time[-1] - time[0] + 2.0 * around) / step)) + 1
    length = fft.next_fast_len(size + int(np.ceil((around + 2.0 * MARGIN) / step * 2.5)), real=True)
    place = np.round((time - origin) / step).astype(np.int64)
    filled, sums = np.zeros(length), np.zeros(length)
    np.add.at(filled, place, 1.0)
    np.add.at(sums, place, power - np.median(power))
    sums /= np.maximum(filled, 1.0)
    filled = np.minimum(filled, 1.0)
    return _Binned(origin, step, size, fft.rfft(filled), fft.rfft(sums), fft.rfft(sums * sums), length)


def _template(pattern: Pattern, expected: Floats, run: int, override: float, at: Floats, width: float) -> Floats:
    """Mean power that is expected in intervals of `width` s around times from the begin of a run on."""
    on, off, _ = pattern.times(run, override)
    height = expected[pattern.run == run]
    edges = np.ravel(np.column_stack([on, off]))
    work = np.concatenate([[0.0], np.cumsum(np.ravel(np.column_stack([height * (off - on), np.zeros(on.size)])))])[:-1]
    upper, lower = (np.interp(at + half, edges, work) for half in (0.5 * width, -0.5 * width))
    return np.asarray((upper - lower) / width, np.float64)


def _scores(binned: _Binned, pattern: Pattern, expected: Floats, run: int) -> tuple[Floats, Floats, Floats]:
    """How likely a run begins at each place, with which override, and how much larger its power is than expected.

    The likelihood is a logarithm, over a constant power there.
    """
    span, strokes = pattern.times(run)[2], int((pattern.run == run).sum())
    apart = np.clip(0.2 / strokes, 0.004, 0.05)
    low, high = (LOWEST, HIGHEST) if pattern.overridable else (1.0 / SAME_FEED, SAME_FEED)
    tried = np.exp(np.arange(np.log(low), np.log(high), apart))
    tried = np.append(tried[np.abs(np.log(tried)) > 0.4 * apart], 1.0)
    best, override, gain = np.full(binned.size, -np.inf), np.ones(binned.size), np.zeros(binned.size)
    for each in tried.tolist():
        at = np.arange(-MARGIN, pattern.times(run, each)[2] + MARGIN, binned.step)
        if at.size > binned.length - binned.size:
            continue
        shape = _template(pattern, expected, run, each, at, binned.step)
        highest = max(float(shape.max()), 1e-9)
        shape = shape / highest
        box, form, square = (
            np.conj(fft.rfft(values, binned.length)) for values in (np.ones(at.size), shape, shape * shape)
        )
        n, s, ss, y, ys, yy = (
            fft.irfft(first * second, binned.length)
            for first, second in (
                (binned.filled, box),
                (binned.filled, form),
                (binned.filled, square),
                (binned.sums, box),
                (binned.sums, form),
                (binned.squares, box),
            )
        )
        n = np.maximum(n, 1.0)
        covariance, spread, variance = ys - y * s / n, ss - s * s / n, yy - y * y / n
        squared = np.where(
            (covariance > 0.0) & (spread > 1e-3) & (variance > 1e-9 * np.abs(yy).max()) & (n >= FEWEST),
            covariance**2 / np.maximum(spread * variance, 1e-300),
            0.0,
        )
        likely = -0.5 * n * np.log1p(-np.minimum(squared, 0.9999)) - 0.5 * (np.log(each) / USUAL_OVERRIDE) ** 2
        factor = covariance / np.maximum(spread, 1e-3) / highest
        # a place of the array is that of the margin before the run
        likely, factor = (np.roll(values, round(MARGIN / binned.step))[: binned.size] for values in (likely, factor))
        better = likely > best
        best, override, gain = (
            np.where(better, new, old) for new, old in ((likely, best), (each, override), (factor, gain))
        )
    assert span > 0.0
    return np.maximum(best, 0.0), override, gain


def _placed(
    scores: Sequence[Floats], overrides: Sequence[Floats], binned: _Binned, pattern: Pattern, most: int
) -> list[tuple[Floats, Floats, float]]:
    """The most likely 1, 2, ... executions in a row: begins and overrides (executions, runs), and how likely."""
    reached = np.zeros(binned.size)  # the best score of all before, if they end by then
    came: Numbers = np.zeros(binned.size, np.int64)
    chains: list[tuple[Numbers, Numbers]] = []
    found = []
    places = np.arange(binned.size)
    lengths = [_lengths(pattern, run, overrides[run], binned.step) for run in range(pattern.runs)]
    for number in range(most * pattern.runs):
        run = number % pattern.runs
        total = reached + scores[run]
        chains.append((came.copy(), places))
        end = np.minimum(places + lengths[run], binned.size - 1)
        next_reached, next_came = np.full(binned.size, -np.inf), np.zeros(binned.size, np.int64)
        order = np.argsort(total, kind="stable")
        next_reached[end[order]], next_came[end[order]] = total[order], order  # of several the last, which is the best
        running = np.maximum.accumulate(next_reached)
        latest = np.maximum.accumulate(np.where(next_reached >= running, places, 0))
        reached, came = running, next_came[latest]
        if run == pattern.runs - 1:
            last = int(np.argmax(total))
            found.append((*_traced(chains, last, binned, overrides, pattern.runs), float(total[last])))
    return found


def _lengths(pattern: Pattern, run: int, overrides: Floats, step: float) -> Numbers:
    """Steps from the begin of a run to the soonest begin of the next one."""
    span, after = pattern.times(run)[2], pattern.pause[(run + 1) % pattern.runs]
    lengths: Numbers = np.floor((0.98 * span / overrides + SHORTEST_PAUSE * after) / step).astype(np.int64)
    return np.maximum(lengths, 1)


def _traced(
    chains: Sequence[tuple[Numbers, Numbers]], last: int, binned: _Binned, overrides: Sequence[Floats], runs: int
) -> tuple[Floats, Floats]:
    places = [last]
    for came, _ in reversed(chains[1:]):
        places.append(int(came[places[-1]]))
    order = np.array(places[::-1])
    chosen = np.array([overrides[number % runs][place] for number, place in enumerate(order.tolist())])
    return (binned.origin + binned.step * order).reshape(-1, runs), chosen.reshape(-1, runs)


def _compared(
    time: Floats,
    power: Floats,
    pattern: Pattern,
    expected: Floats,
    run: int,
    begin: float,
    override: float,
    width: float,
) -> tuple[float, float, float]:
    """Correlation of a run at a place with the log there, the power over that expected, and the deviation from it."""
    end = begin + pattern.times(run, override)[2]
    first, last = np.searchsorted(time, (begin - MARGIN, end + MARGIN))
    if last - first < FEWEST:
        return float("nan"), float("nan"), float("nan")
    shape = _template(pattern, expected, run, override, time[first:last] - begin, width)
    y = power[first:last]
    if np.ptp(shape) == 0.0 or np.ptp(y) == 0.0:
        return 0.0, 0.0, float(np.std(y))
    correlation, deviation = float(np.corrcoef(shape, y)[0, 1]), float(np.std(y))
    return correlation, correlation * deviation / float(np.std(shape)), deviation * float(np.sqrt(1.0 - correlation**2))


def _judged(
    begin: Floats, override: Floats, time: Floats, power: Floats, pattern: Pattern, expected: Floats, unit: float
) -> Alignment:
    """Executions that lie in the log at least in part, with their correlations."""
    width = max(float(np.median(np.diff(time))) * 0.1, FINE)
    each = [
        [
            _compared(time, power, pattern, expected, run, b, o, width)
            for run, (b, o) in enumerate(zip(*row, strict=True))
        ]
        for row in zip(begin.tolist(), override.tolist(), strict=True)
    ]
    correlation, gain, rest = np.moveaxis(np.array(each), -1, 0)
    inside = np.isfinite(correlation).any(axis=1)
    return Alignment(begin[inside], override[inside], correlation[inside], gain[inside], rest[inside], unit)


def _of_executions(values: Floats, correlation: Floats, pattern: Pattern, expected: Floats) -> Floats:
    """Mean of each execution, its runs weighted by what they make the power differ."""
    weights = np.array([np.square(expected[pattern.run == run]).sum() for run in range(pattern.runs)])
    weight = np.where(np.isfinite(correlation), weights, 0.0)
    mean: Floats = (np.nan_to_num(values) * weight).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-300)
    return mean


def refined(found: Alignment, log: Log, pattern: Pattern, expected: Floats) -> Alignment:
    """The same with begins and overrides between the steps, of a log in s."""
    time, power = log.time, log.power
    begin, override, correlation, gain, rest = (
        values.copy() for values in (found.begin, found.override, found.correlation, found.gain, found.rest)
    )
    width = max(float(np.median(np.diff(time))) * 0.1, FINE)
    for row, run in np.argwhere(np.isfinite(correlation)).tolist():
        span = pattern.times(run)[2]

        def misses(x: Floats, row: int = row, run: int = run, span: float = span) -> float:
            changed = override[row, run] * np.exp(x[1] * 0.2 / span)
            at = begin[row, run] + 0.1 * x[0]
            value, *_ = _compared(time, power, pattern, expected, run, at, changed, width)
            return 1.0 - (value if np.isfinite(value) else 0.0)

        best = optimize.minimize(
            misses,
            (0.0, 0.0),
            method="Nelder-Mead",
            options={"xatol": 0.02, "fatol": 1e-6, "maxfev": 80, "initial_simplex": SIMPLEX},
        )
        begin[row, run] += 0.1 * best.x[0]
        override[row, run] *= np.exp(best.x[1] * 0.2 / span)
        correlation[row, run], gain[row, run], rest[row, run] = _compared(
            time, power, pattern, expected, run, begin[row, run], override[row, run], width
        )
    return replace(found, begin=begin, override=override, correlation=correlation, gain=gain, rest=rest)


SIMPLEX = ((0.0, 0.0), (2.0, 0.0), (0.0, 1.0))
"""0.2 s later; a feed by which the end of the run comes 0.2 s sooner."""
