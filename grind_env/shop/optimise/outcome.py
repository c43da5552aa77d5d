"""The outcome of an optimisation, for tables, JSON and reports."""

from collections.abc import Collection
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import NamedTuple

from grind_env.errors import GrindError
from grind_env.files import write_atomically
from grind_env.policies.statistics import Interval
from grind_env.presenter import html
from grind_env.shop.search_options import CONFIDENCE


class Verdict(Enum):
    """Whether there is a better program."""

    BETTER = "better"
    NEARER = "nearer to the limits, which it does not keep"
    NOT_BETTER = "no better program found"
    INFEASIBLE = "no program keeps the limits"
    UNTRIED = "too few programs were tried"

    @property
    def is_written(self) -> bool:
        """Whether a program takes the place of the one at hand."""
        return self in (Verdict.BETTER, Verdict.NEARER)


@dataclass(frozen=True, slots=True, kw_only=True)
class WordChange:
    """A value before and after, as the program writes it.

    Attributes:
        name: E, D, J, L, lead, depth, passes or interval.
        place: the block or dress program in which it stands.
        before: in the units of the program.
        after: likewise.
        unit: of both.
        at_bound: "lowest" or "highest" if it is an end of what was tried; else empty.
    """

    name: str
    place: str
    before: str
    after: str
    unit: str
    at_bound: str

    @property
    def changed(self) -> bool:
        """Whether it is another one."""
        return self.before != self.after


@dataclass(frozen=True, slots=True, kw_only=True)
class PartMean:
    """A mean over parts, lots and machines, before and after, each with the interval in which that of one machine lies.

    Attributes:
        name: cost, seconds, Ra, power, rise (of the last stage), highest_rise, size_error or scrap.
        unit: of all values.
        before: with the program as it was.
        after: with other words.
        difference: after minus before, on the same lots and machines.
        expected: of the program as it was and with other words, on the expected lot, as `grind run` shows it,
            in `unit`.
    """

    name: str
    unit: str
    before: Interval
    after: Interval
    difference: Interval
    expected: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitUse:
    """How near a limit is, and what it costs.

    Attributes:
        name: power, rise, Ra or size.
        limit: in `unit`; 0 if there is none.
        unit: of it.
        margin: share of the limit that parts must keep with the confidence asked for.
        before: share that they keep with it, with the program as it was.
        after: the same share with other words.
        price: $ a part, or s if time is to become less, that the best words without this limit save; None if that was
            not sought.
        without: share of the limit that parts keep with those words; None likewise.
        binds: whether the search has felt it: `price` is worth naming, beyond chance, and those words are refused
            because of this limit; where they were not sought, whether `after` is near what is asked.
        stations: that of each station by its name, in `unit`, where they differ; `limit` is then the lowest of them.
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
        """Whether parts keep it so, with its margin, after the changes."""
        return self.after <= self.margin


class Requirement(NamedTuple):
    """What a part may take in the mean, and what it takes.

    Attributes:
        name: cost or seconds.
        unit: of all values, $ or s.
        most: what is asked, $ or s.
        before: with the program as it was, $ or s.
        after: with other words, $ or s.
    """

    name: str
    unit: str
    most: float
    before: float
    after: float

    @property
    def kept(self) -> bool:
        """Whether it is kept after the changes."""
        return self.after <= self.most


class Trade(NamedTuple):
    """What a part takes with a program that was tried, on the lots of the search."""

    cost: float
    """$."""
    seconds: float
    """Time, s."""
    share: float
    """Of what is asked of limits and options, the highest share that it comes to."""
    beyond: tuple[bool, ...] = ()
    """Whether it is beyond each of `LIMITS`."""

    @property
    def keeps(self) -> bool:
        """Whether it keeps limits and options."""
        return self.share <= 1.0


TIMES = 40
"""Classes of time of which each has its cheapest program."""


def cheapest_by_time(trades: Collection[Trade]) -> tuple[Trade, ...]:
    """Of those that keep all, the cheapest of each of `TIMES` classes of time, the quickest first."""
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
    """What an optimisation has come to.

    Attributes:
        program: name of the program.
        job: name of the job file; empty for a job that is held in memory.
        verdict: whether it is better.
        reason: one sentence on the verdict.
        words: every value that was varied.
        quantities: means of a part.
        limits: power, rise, Ra and size.
        requirements: what a part was to take at most.
        objective: what was to become less, cost or seconds.
        cheapest: of the programs tried the cheapest of each class of time, the quickest first.
        chosen: of the programs tried, that as it was and that with the words chosen.
        remarks: sentences on what could not be varied.
        before: text of the program.
        after: text with other words; that of the program where none is better.
        data: the file of that text.
        parts: of a batch.
        lots: unseen ones, on which it was judged; 1 where the job states how each part differs.
        seed: of all that is random.
        evaluations: programs that were tried in the search.
        judged: programs that were judged on unseen lots.
        ended_early: whether the budget was up before the search had ended.
        plant: the machine on which it was judged; empty for the model, on which it was searched.
        promised: of what was to become less, what was promised of it before it was judged on that machine; else None.
        confidence: share of the parts and machines for which limits and each end of an interval hold.
        calibration: where what is known of the machine is from; None if it is not calibrated.
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
        """Whether the machine on which it was judged takes what was promised."""
        found = self.quantity(self.objective).after
        return self.promised is None or (found.high >= self.promised.low and found.low <= self.promised.high)

    def quantity(self, name: str) -> PartMean:
        """One of the quantities."""
        return next(each for each in self.quantities if each.name == name)

    def write(self, path: str | Path) -> None:
        """Write the program that was found, as `grind optimise -o`.

        Raises:
            GrindError: none takes the place of the one at hand.
            FileError: the folder does not exist or cannot be written to.
        """
        if not self.verdict.is_written:
            raise GrindError(f"{self.program} is not written to {path}: {self.reason}")
        write_atomically(Path(path), lambda temporary: temporary.write_bytes(self.data))

    def _repr_html_(self) -> str:
        return html("optimised", self)
