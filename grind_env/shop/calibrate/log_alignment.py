"""The alignment of a program with a log: places of its runs, quality of the match, and runs as programmed."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats
from grind_env.optional_libraries import needing
from grind_env.shop.calibrate.power_logs import Log
from grind_env.shop.calibrate.stroke_schedule import Pattern

with needing("shop", "a calibration needs"):
    from scipy import optimize

SAME_FEED = 1.04  #: feed factor between a machine and its model up to which there is no override
ENOUGH_PARTS, MOST_PARTS = 3, 0.75  #: least number of parts, and share of them, whose common feed factor is no override
MATCHES = 0.5  #: least correlation of a run or an execution that counts as found in the log
ALIKE_RUNS = 4.0  #: greatest factor between the gain (power over expected power) of a run and of the other runs
#: a run is not as programmed if its residual exceeds `ODD` times the others' and its correlation is below `POOR`
ODD, POOR = 3.0, 0.8
FINE = 0.05  #: shortest time of which a sample is taken to be the mean, s
MARGIN = 2.0  #: time before and after a run that is compared, too, s
FEWEST = 5  #: least number of samples for a correlation
LEAST = 1e-9  #: share of a value below which another value counts as 0
PASSES = 4  #: greatest number of passes over all runs; in each pass a run may move by one stroke
#: start of the search: no change; 0.2 s later; a feed with which the run ends 0.2 s earlier
SIMPLEX = ((0.0, 0.0), (2.0, 0.0), (0.0, 1.0))


@dataclass(frozen=True, slots=True)
class Alignment:
    """Places of the runs of a program in a log; arrays have shape (executions, runs)."""

    begin: Floats  #: begin of each run, s of the log
    override: Floats  #: feed override in each run
    correlation: Floats  #: correlation of expected and logged power; NaN if the log has no samples there
    gain: Floats  #: logged power over expected power
    rest: Floats  #: standard deviation of the logged power from the expected power, unit of the log
    time_unit: float = 1.0  #: unit of the log's time, s; 1 unless it was inferred

    @property
    def executions(self) -> int:
        """Return the number of executions of the program."""
        return len(self.begin)

    @property
    def known(self) -> "Alignment":
        """Return the executions with a sure run; other work may look like an execution."""
        names, known = ("begin", "override", "correlation", "gain", "rest"), self.sure.any(axis=1)
        return replace(self, **{name: getattr(self, name)[known] for name in names})

    @property
    def quality(self) -> float:
        """Median of the correlations, from 0 to 1."""
        return float(np.nanmedian(self.correlation)) if np.isfinite(self.correlation).any() else 0.0

    @property
    def sure(self) -> NDArray[np.bool_]:
        """Return which runs are in the log as programmed: as strong and as similar as the others."""
        sure: NDArray[np.bool_] = self.correlation >= MATCHES
        if sure.any():
            sure = sure & between(self.gain, float(np.median(self.gain[sure])), ALIKE_RUNS)
        if sure.any():
            sure = sure & ((self.correlation >= POOR) | (self.rest <= ODD * np.median(self.rest[sure])))
        return sure

    def overrides(self, pattern: Pattern) -> list[float]:
        """Return the feed override of each part; 1 for the programmed feed.

        A feed factor common to all parts belongs to the machine and is no override.
        """
        usual = self.usual_override(pattern)
        found = [value / usual for value in self._medians(pattern)]
        return [1.0 if abs(np.log(value)) < np.log(SAME_FEED) else value for value in found]

    def usual_override(self, pattern: Pattern) -> float:
        """Return the feed factor of most parts if they agree and are enough, else 1."""
        found = np.array(self._medians(pattern))
        usual = float(np.median(found))
        alike = np.mean(np.abs(np.log(found / usual)) < np.log(SAME_FEED)) >= MOST_PARTS
        return usual if found.size >= ENOUGH_PARTS and alike else 1.0

    def _medians(self, pattern: Pattern) -> list[float]:
        part = pattern.part[pattern.firsts]
        each = [(row, part == number) for row in range(self.executions) for number in range(pattern.parts)]
        found = [self.override[row, chosen & self.sure[row]] for row, chosen in each]
        return [float(np.median(values)) if values.size else 1.0 for values in found]


def between(values: Floats, usual: float, factor: float) -> NDArray[np.bool_]:
    """Return which values are within a factor of a usual one."""
    return (values > usual / factor) & (values < usual * factor)


def template(
    pattern: Pattern, expected: Floats, run: int, override: float, at: Floats, width: float, lag: float
) -> Floats:
    """Return the mean power that a meter shows in intervals of `width` s around times `at` after the begin of a run.

    A meter of first order shows y with lag dy/dt = P - y: the integral of y is the integral of P minus lag y.
    """
    on, off, _ = pattern.times(run, override)
    height = expected[pattern.run == run]
    edges = np.ravel(np.column_stack([on, off]))
    level = np.ravel(np.column_stack([height, np.zeros(on.size)]))
    work = np.concatenate([[0.0], np.cumsum(level[:-1] * np.diff(edges))])
    ends = at[:, None] + width * np.array([-0.5, 0.5])
    shown = np.interp(ends, edges, work)
    if lag:
        kept, begun = np.exp(-np.diff(edges) / lag).tolist(), [0.0]
        for left, P in zip(kept, level.tolist(), strict=False):
            begun.append(P + (begun[-1] - P) * left)
        last = np.searchsorted(edges, ends, side="right") - 1
        here = np.maximum(last, 0)
        decayed = np.exp(-np.maximum(ends - edges[here], 0.0) / lag)
        shown -= lag * np.where(last < 0, 0.0, level[here] + (np.array(begun)[here] - level[here]) * decayed)
    return np.asarray((shown[:, 1] - shown[:, 0]) / width, np.float64)


class Around(NamedTuple):
    """Log around a run, without the explained part: idling spindle, other runs, and the time before."""

    time: Floats
    rest: Floats
    beside: Floats  #: orthonormal shapes that explain everything but the run, shape (samples, ...)

    def correlate(self, shape: Floats) -> tuple[float, float, float]:
        """Return correlation, gain and residual of an expected power in this log."""
        rest, x = self.rest, _without(shape, self.beside)
        deviation, spread = float(np.sqrt(np.mean(rest * rest))), float(np.sqrt(np.mean(x * x)))
        if deviation == 0.0 or spread <= LEAST * float(np.abs(shape).max()):
            return 0.0, 0.0, deviation
        correlation = float(np.clip(np.mean(x * rest) / (deviation * spread), -1.0, 1.0))
        return correlation, correlation * deviation / spread, deviation * float(np.sqrt(1.0 - correlation**2))


def _without(values: Floats, beside: Floats) -> Floats:
    return values - beside @ (values @ beside)


def _around(time: Floats, power: Floats, others: Floats, lag: float) -> Around:
    """Return the log around a run; earlier readings decay with the lag of the meter."""
    columns = [np.ones(time.size), others]
    if lag:
        columns.append(np.exp((time[0] - time) / lag))
    beside = np.empty((time.size, 0))
    for column in columns:
        new = _without(column, beside)
        length = float(np.linalg.norm(new))
        if length > LEAST * float(np.linalg.norm(column)):
            beside = np.column_stack([beside, new / length])
    rest = _without(power, beside)
    return Around(time, np.where(np.abs(rest) > LEAST * np.abs(power).max(), rest, 0.0), beside)


class LogMatch:
    """Similarity of a log in s to a program with runs at given places and overrides, arrays (executions, runs)."""

    def __init__(self, log: Log, pattern: Pattern, expected: Floats, begin: Floats, override: Floats) -> None:
        self.log, self.pattern, self.expected = log, pattern, expected
        self.begin, self.override = begin.copy(), override.copy()
        self.width = max(0.1 * log.interval, FINE)
        self.spans = np.array([pattern.times(run)[2] for run in range(pattern.runs)])

    def places(self) -> Iterator[tuple[int, int]]:
        return itertools.product(range(len(self.begin)), range(self.pattern.runs))

    def around(self, row: int, run: int, more: float = 0.0) -> Around | None:
        """Return the log around a run, with `more` s on either side beyond `MARGIN`; None without samples."""
        ends = self.begin + self.spans / self.override
        low, high = self.begin[row, run] - MARGIN - more, ends[row, run] + MARGIN + more
        first, last = np.searchsorted(self.log.time, (low, high))
        if last - first < FEWEST:
            return None
        time, others = self.log.time[first:last], np.zeros(last - first)
        near = (self.begin < high) & (ends > low)
        near[row, run] = False
        for place in np.argwhere(near).tolist():
            others += self._shape(time, *place)
        return _around(time, self.log.power[first:last], others, self.log.lag)

    def _shape(self, time: Floats, row: int, run: int, later: float = 0.0, faster: float = 1.0) -> Floats:
        at = time - self.begin[row, run] - later
        override = faster * self.override[row, run]
        return template(self.pattern, self.expected, run, override, at, self.width, self.log.lag)

    def correlate_run(self, row: int, run: int) -> tuple[float, float, float]:
        """Return correlation, gain and residual of a run; NaN where the log has no samples."""
        around = self.around(row, run)
        return (np.nan,) * 3 if around is None else around.correlate(self._shape(around.time, row, run))

    def settle(self) -> None:
        """Move runs by whole strokes to their most likely places; the search ignores the neighbours of a run."""
        for _ in range(PASSES):
            moved = False
            for row, run in self.places():
                period = self.spans[run] / (self.override[row, run] * (self.pattern.run == run).sum())
                around = self.around(row, run, period)
                if around is None:
                    continue
                tried = (0.0, -period, period)
                correlations = [around.correlate(self._shape(around.time, row, run, later))[0] for later in tried]
                best = int(np.argmax(correlations))
                self.begin[row, run] += tried[best]
                moved = moved or best > 0
            if not moved:
                break

    def refine(self, row: int, run: int) -> None:
        """Move begin and feed of a run to their most likely values, between the steps of the search."""
        around, span = self.around(row, run), float(self.spans[run])
        if around is None:
            return

        def misses(x: Floats) -> float:
            return 1.0 - around.correlate(self._shape(around.time, row, run, 0.1 * x[0], np.exp(0.2 * x[1] / span)))[0]

        best = optimize.minimize(
            misses,
            (0.0, 0.0),
            method="Nelder-Mead",
            options={"xatol": 0.02, "fatol": 1e-6, "maxfev": 80, "initial_simplex": SIMPLEX},
        )
        self.begin[row, run] += 0.1 * best.x[0]
        self.override[row, run] *= np.exp(0.2 * best.x[1] / span)

    def alignment(self, time_unit: float) -> Alignment:
        """Return the executions that lie in the log at least in part."""
        each = np.array([self.correlate_run(*place) for place in self.places()]).reshape(*self.begin.shape, 3)
        inside = np.isfinite(each[..., 0]).any(axis=1)
        correlation, gain, rest = np.moveaxis(each[inside], -1, 0)
        return Alignment(self.begin[inside], self.override[inside], correlation, gain, rest, time_unit)


def refined(found: Alignment, log: Log, pattern: Pattern, expected: Floats) -> Alignment:
    """Return the alignment with begins and overrides refined between the steps of the search, for a log in s."""
    match = LogMatch(log, pattern, expected, found.begin, found.override)
    for row, run in np.argwhere(np.isfinite(found.correlation)).tolist():
        match.refine(row, run)
    return match.alignment(found.time_unit)


def clarity(found: Alignment, log: Log, pattern: Pattern, expected: Floats, most: int) -> float:
    """Return the median correlation of at most `most` runs of the log, each at its most likely place."""
    match = LogMatch(log, pattern, expected, found.begin, found.override)
    places = np.argwhere(np.isfinite(found.correlation)).tolist()
    chosen = [places[k] for k in np.linspace(0, len(places) - 1, min(len(places), most)).round().astype(int)]
    for place in chosen:
        match.refine(*place)
    return float(np.median([match.correlate_run(*place)[0] for place in chosen]))
