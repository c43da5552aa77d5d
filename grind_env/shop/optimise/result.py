"""The outcome of an optimisation, for tables, JSON and reports."""

from collections.abc import Collection
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import NamedTuple

from grind_env.errors import GrindError
from grind_env.files import write_atomically
from grind_env.notebook_loader import html
from grind_env.policies.score_statistics import Interval
from grind_env.shop.search_options import CONFIDENCE


class Verdict(Enum):
    """Verdict on a new program."""

    BETTER = "better"
    NEARER = "nearer to the limits, which it does not keep"
    NOT_BETTER = "no better program found"
    INFEASIBLE = "no program keeps the limits"
    UNTRIED = "too few programs were tried"

    @property
    def is_written(self) -> bool:
        """Return whether the new program replaces the old one."""
        return self in (Verdict.BETTER, Verdict.NEARER)


@dataclass(frozen=True, slots=True, kw_only=True)
class WordChange:
    """Value before and after, as written in the program.

    Attributes:
        name: E, D, J, L, lead, depth, passes or interval.
        place: its block or dress program.
        before: old value, in the units of the program.
        after: new value, in the units of the program.
        unit: unit of both values.
        at_bound: "lowest" or "highest" if at an end of its range; else empty.
    """

    name: str
    place: str
    before: str
    after: str
    unit: str
    at_bound: str

    @property
    def changed(self) -> bool:
        """Return whether the value changed."""
        return self.before != self.after


@dataclass(frozen=True, slots=True, kw_only=True)
class PartMean:
    """Mean over parts, lots and machines, before and after, with intervals for one machine.

    Attributes:
        name: cost, seconds, Ra, power, rise (of the last stage), highest_rise, size_error or scrap.
        unit: unit of all values.
        before: mean with the old words.
        after: mean with the new words.
        difference: after minus before, on the same lots and machines.
        expected: old and new value on the expected lot, as `grind run` shows it, in `unit`.
    """

    name: str
    unit: str
    before: Interval
    after: Interval
    difference: Interval
    expected: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitUse:
    """Margin to a limit, and the cost of the limit.

    Attributes:
        name: power, rise, Ra or size.
        limit: value of the limit, in `unit`; 0 without a limit.
        unit: unit of the limit.
        margin: share of the limit that parts must keep with the required confidence.
        before: share of the limit that parts keep with the old words.
        after: share of the limit that parts keep with the new words.
        price: saving of the best words without this limit, $ a part, or s if time is the objective; None if not
            searched.
        without: share of the limit that parts keep with these words; None if not searched.
        binds: whether the limit binds: `price` is significant and the words without it exceed it; if not searched,
            whether `after` is near the required share.
        stations: limit of each station by its name, in `unit`, if they differ; `limit` is the lowest.
    """

    name: str
    limit: float
    unit: str
    margin: float
    before: float
    after: float
    price: Interval | None
    without: float | None
    binds: bool
    stations: tuple[tuple[str, float], ...] = ()

    @property
    def kept(self) -> bool:
        """Return whether parts keep the limit, with its margin, after the changes."""
        return self.after <= self.margin


class Requirement(NamedTuple):
    """Required maximum of a mean of a part, and its value.

    Attributes:
        name: cost or seconds.
        unit: unit of all values, $ or s.
        most: required maximum, $ or s.
        before: mean with the old words, $ or s.
        after: mean with the new words, $ or s.
    """

    name: str
    unit: str
    most: float
    before: float
    after: float

    @property
    def kept(self) -> bool:
        """Return whether the requirement is kept after the changes."""
        return self.after <= self.most


class Trade(NamedTuple):
    """Time and cost of a part with a tried program, on the lots of the search."""

    cost: float
    """Cost, $."""
    seconds: float
    """Time, s."""
    share: float
    """Highest share of limits and options that the program reaches."""
    beyond: tuple[bool, ...] = ()
    """Whether the program exceeds each of `LIMITS`."""

    @property
    def keeps(self) -> bool:
        """Return whether the program keeps limits and options."""
        return self.share <= 1.0


TIMES = 40
"""Number of classes of time, each with its cheapest program."""


def cheapest_by_time(trades: Collection[Trade]) -> tuple[Trade, ...]:
    """Return the cheapest valid program in each of `TIMES` classes of time, the quickest first."""
    kept = [each for each in trades if each.keeps]
    first = min((each.seconds for each in kept), default=0.0)
    width = (max((each.seconds for each in kept), default=0.0) - first) / TIMES
    found: dict[int, Trade] = {}
    for each in kept:
        time = min(int((each.seconds - first) / width), TIMES - 1) if width > 0.0 else 0
        found[time] = min(each, found.get(time, each))
    return tuple(found[time] for time in sorted(found))


@dataclass(frozen=True, slots=True, kw_only=True)
class Optimised:
    """Result of an optimisation.

    Attributes:
        program: name of the program.
        job: name of the job file; empty for a job in memory.
        verdict: verdict on the new program.
        reason: one sentence on the verdict.
        words: every value that was varied.
        quantities: means of a part.
        limits: power, rise, Ra and size.
        requirements: required maxima of means of a part.
        objective: reduced value, cost or seconds.
        cheapest: cheapest tried program of each class of time, the quickest first.
        chosen: the old and the chosen program, among those tried.
        remarks: sentences on what could not be varied.
        before: text of the program.
        after: text with the new words; the old text if none is better.
        data: file content of `after`.
        parts: runs of the program in a batch.
        counted: unit of a run: "part", or "run" if it grinds several parts.
        lots: number of unseen lots of the judgement; 1 if the job states how each part differs.
        seed: seed of all random numbers.
        evaluations: programs that were tried in the search.
        judged: programs that were judged on unseen lots.
        ended_early: whether the budget ended the search.
        plant: machine of the judgement; empty for the model, which the search used.
        promised: objective promised by the model before the judgement on `plant`; None for the model.
        confidence: share of parts and machines for which limits and each end of an interval hold.
        calibration: source of the calibration; None without one.
    """

    program: str
    job: str
    verdict: Verdict
    reason: str
    words: tuple[WordChange, ...]
    quantities: tuple[PartMean, ...]
    limits: tuple[LimitUse, ...]
    requirements: tuple[Requirement, ...]
    objective: str
    cheapest: tuple[Trade, ...]
    chosen: tuple[Trade, Trade]
    remarks: tuple[str, ...]
    before: str
    after: str
    data: bytes
    parts: int
    counted: str
    lots: int
    seed: int
    evaluations: int
    judged: int
    ended_early: bool
    plant: str = ""
    promised: Interval | None = None
    confidence: float = CONFIDENCE
    calibration: str | None = None

    @property
    def is_as_promised(self) -> bool:
        """Return whether the judging machine confirms the promise."""
        found = self.quantity(self.objective).after
        return self.promised is None or (found.high >= self.promised.low and found.low <= self.promised.high)

    def quantity(self, name: str) -> PartMean:
        """Return a quantity by its name."""
        return next(each for each in self.quantities if each.name == name)

    def write(self, path: str | Path) -> None:
        """Write the new program, as `grind optimise -o`.

        Raises:
            GrindError: no new program replaces the old one.
            FileError: the folder does not exist or cannot be written to.
        """
        if not self.verdict.is_written:
            raise GrindError(f"{self.program} is not written to {path}: {self.reason}")
        write_atomically(Path(path), lambda temporary: temporary.write_bytes(self.data))

    def _repr_html_(self) -> str:
        return html("optimised", self)
