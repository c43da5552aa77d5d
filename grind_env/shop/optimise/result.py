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
    """Value before and after, as written in the program."""

    name: str  #: E, D, J, L, lead, depth, passes or interval
    place: str  #: its block or dress program
    before: str  #: old value, in the units of the program
    after: str  #: new value, in the units of the program
    unit: str  #: unit of both values
    at_bound: str  #: "lowest" or "highest" if at an end of its range; else empty

    @property
    def changed(self) -> bool:
        """Return whether the value changed."""
        return self.before != self.after


@dataclass(frozen=True, slots=True, kw_only=True)
class PartMean:
    """Mean over parts, lots and machines, before and after, with intervals for one machine."""

    name: str  #: cost, seconds, Ra, power, rise (of the last stage), highest_rise, size_error or scrap
    unit: str  #: unit of all values
    before: Interval  #: mean with the old words
    after: Interval  #: mean with the new words
    difference: Interval  #: after minus before, on the same lots and machines
    expected: tuple[float, float]  #: old and new value on the expected lot, as `grind run` shows it, in `unit`


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitUse:
    """Margin to a limit, and the cost of the limit."""

    name: str  #: power, rise, Ra or size
    limit: float  #: value of the limit, in `unit`; 0 without a limit
    unit: str  #: unit of the limit
    margin: float  #: share of the limit that parts must keep with the required confidence
    before: float  #: share of the limit that parts keep with the old words
    after: float  #: share of the limit that parts keep with the new words
    #: saving of the best words without this limit, $ a part, or s if time is the objective; None if not searched
    price: Interval | None
    without: float | None  #: share of the limit that parts keep with these words; None if not searched
    #: whether the limit binds: `price` is significant and the words without it exceed it; if not searched, whether
    #: `after` is near the required share
    binds: bool
    #: limit of each station by its name, in `unit`, if they differ; `limit` is the lowest
    stations: tuple[tuple[str, float], ...] = ()

    @property
    def kept(self) -> bool:
        """Return whether parts keep the limit, with its margin, after the changes."""
        return self.after <= self.margin


class Requirement(NamedTuple):
    """Required maximum of a mean of a part, and its value."""

    name: str  #: cost or seconds
    unit: str  #: unit of all values, $ or s
    most: float  #: required maximum, $ or s
    before: float  #: mean with the old words, $ or s
    after: float  #: mean with the new words, $ or s

    @property
    def kept(self) -> bool:
        """Return whether the requirement is kept after the changes."""
        return self.after <= self.most


class Trade(NamedTuple):
    """Time and cost of a part with a tried program, on the lots of the search."""

    cost: float  #: cost, $
    seconds: float  #: time, s
    share: float  #: highest share of limits and options that the program reaches
    beyond: tuple[bool, ...] = ()  #: whether the program exceeds each of `LIMITS`

    @property
    def keeps(self) -> bool:
        """Return whether the program keeps limits and options."""
        return self.share <= 1.0


TIMES = 40  #: number of classes of time, each with its cheapest program


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
    """Result of an optimisation."""

    program: str  #: name of the program
    job: str  #: name of the job file; empty for a job in memory
    verdict: Verdict  #: verdict on the new program
    reason: str  #: one sentence on the verdict
    words: tuple[WordChange, ...]  #: every value that was varied
    quantities: tuple[PartMean, ...]  #: means of a part
    limits: tuple[LimitUse, ...]  #: power, rise, Ra and size
    requirements: tuple[Requirement, ...]  #: required maxima of means of a part
    objective: str  #: reduced value, cost or seconds
    cheapest: tuple[Trade, ...]  #: cheapest tried program of each class of time, the quickest first
    chosen: tuple[Trade, Trade]  #: the old and the chosen program, among those tried
    remarks: tuple[str, ...]  #: sentences on what could not be varied
    before: str  #: text of the program
    after: str  #: text with the new words; the old text if none is better
    data: bytes  #: file content of `after`
    parts: int  #: runs of the program in a batch
    counted: str  #: unit of a run: "part", or "run" if it grinds several parts
    lots: int  #: number of unseen lots of the judgement; 1 if the job states how each part differs
    seed: int  #: seed of all random numbers
    evaluations: int  #: programs that were tried in the search
    judged: int  #: programs that were judged on unseen lots
    ended_early: bool  #: whether the budget ended the search
    plant: str = ""  #: machine of the judgement; empty for the model, which the search used
    promised: Interval | None = None  #: objective promised by the model before judgement on `plant`; None for the model
    confidence: float = CONFIDENCE  #: share of parts and machines for which limits and each end of an interval hold
    calibration: str | None = None  #: source of the calibration; None without one

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
