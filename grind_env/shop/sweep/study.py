"""A dress study of a user's own part: table speed and dress interval, then lead and depth of the dress."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.control import read_file
from grind_env.control.program_scanner import SourceText
from grind_env.envs.job.program_outline import INCH
from grind_env.errors import GrindError
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import job_of
from grind_env.machine.script.block_settings import DRESS_DEPTH, DRESS_FEED, DRESS_PASSES, D, E
from grind_env.notebook_loader import html, presenter
from grind_env.policies.score_statistics import Interval
from grind_env.shop.dress_interval import LONGEST, DressInterval
from grind_env.shop.possible_machines import Fleet, fleet_of, require_good
from grind_env.shop.search_options import LIMITS
from grind_env.shop.trials import LotUse, Measures, Trials, lots_of, most_risk, risk, trials_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOTS, JUDGED_LOTS = 96, 256  #: lots of every point, and new lots on which the cheapest point must keep the limits, too
RISK = "risk"  #: name of the risk among the limits
POINTS = 9  #: number of values of a range of E, lead or depth; with more dress intervals some are left out
AT_ONCE = 16  #: number of points that are simulated side by side
VALLEY = 0.02  #: greatest extra cost of the dress intervals in the valley, as a share of the best cost
#: means of `Measures` that a point shows without an interval
MEANS = "seconds", "Ra", "power", "rise", "highest_rise", "size_error", "scrap"


class SweepError(GrindError):
    """Sweep over a value that the program does not have."""


class SweepRanges(NamedTuple):
    """Ranges of a sweep, lowest to highest value; without a range the program's value stays."""

    #: E of the first cycle block, mm/min; E of the other blocks keeps its ratio to it
    E: tuple[float, float] | None = None
    every: tuple[int, int] | None = None  #: dress interval, in parts
    lead: tuple[float, float] | None = None  #: lead of the dress, mm a revolution of the wheel
    depth: tuple[float, float] | None = None  #: mean infeed of a pass, mm


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepPoint:
    """Cost of a part with some settings."""

    E: float  #: E of the first cycle block, mm/min
    every: int  #: dress interval in runs of the program; 0 for the D words of the program, in every part
    lead: float  #: lead of the dress, mm a revolution; 0 without a dress program
    depth: float  #: depth of the dress, mm a pass; 0 without a dress program
    #: cost of a part, $, with a 90 % interval for one machine; if judged on new lots: cost of the unchanged program
    #: less the saving on the new lots
    cost: Interval
    seconds: float  #: time of a part, s
    Ra: float  #: roughness, um
    power: float  #: highest power, kW
    rise: float  #: highest temperature rise of the last stage, K
    highest_rise: float  #: highest temperature rise of all stages, K
    size_error: float  #: absolute size error, um
    scrap: float  #: share of scrapped parts
    shares: tuple[float, ...]  #: shares of the limits power, rise, Ra and size that 95 of 100 parts keep on any machine
    #: risk as in `trials.risk`, as a share of the permitted risk. Both are the higher ones of all lots and of new lots
    #: where a point was judged on those.
    risk: float
    luck: float = 0.0  #: cost of a judged point less its cost on the lots of the sweep, $

    @property
    def keeps_limits(self) -> bool:
        """Return whether 95 of 100 parts keep each limit within the permitted risk."""
        return max(self.of_limits.values()) <= 1.0

    @property
    def worst_limit(self) -> str:
        """Return the limit with the highest share used, `risk` among them."""
        shares = self.of_limits
        return max(shares, key=shares.__getitem__)

    @property
    def of_limits(self) -> dict[str, float]:
        """`shares` and `risk` by their names."""
        return dict(zip((*LIMITS, RISK), (*self.shares, self.risk), strict=True))


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """Result of a sweep."""

    program: str  #: name of the program
    parts: int  #: runs of the program in a batch
    lots: int  #: number of lots of every point
    counted: str  #: unit of a run: "part", or "run" if it grinds several parts
    own: SweepPoint  #: point of the unchanged program
    most_risk: float  #: permitted risk, as a share of the cost of the unchanged program
    speeds: tuple[SweepPoint, ...]  #: points over E and dress interval
    dresses: tuple[SweepPoint, ...]  #: points over lead and depth, with the best E and interval
    remarks: tuple[str, ...] = ()  #: sentences on given variables that nothing reads
    calibration: str | None = None  #: source of the calibration; None without one
    plant: str = ""  #: name of the machine, if not the model

    @property
    def best(self) -> SweepPoint:
        """The cheapest point that keeps the limits, or the cheapest of all if none does."""
        return cheapest([self.own, *self.speeds, *self.dresses])

    @property
    def refused(self) -> dict[str, SweepPoint]:
        """Return for each limit (or risk) the cheapest point that exceeds it and is cheaper than the best point."""
        best, found = self.best, {}
        points = [point for point in (*self.speeds, *self.dresses) if point.cost.value < best.cost.value]
        for name in (*LIMITS, RISK):
            beyond = [point for point in points if point.of_limits[name] > 1.0]
            if beyond and best.keeps_limits:
                found[name] = min(beyond, key=_cost)
        return found

    @property
    def intervals(self) -> tuple[SweepPoint, ...]:
        """The best point of each dress interval, ascending."""
        return best_of_each(self.speeds, "every")

    @property
    def valley(self) -> tuple[int, int]:
        """Return the first and the last interval around the best one that cost little more."""
        points = self.intervals
        best = cheapest(points)
        most, first, last = (1.0 + VALLEY) * best.cost.value, points.index(best), points.index(best)

        def near(point: SweepPoint) -> bool:
            return point.cost.value <= most and (point.keeps_limits or not best.keeps_limits)

        while first > 0 and near(points[first - 1]):
            first -= 1
        while last + 1 < len(points) and near(points[last + 1]):
            last += 1
        return points[first].every, points[last].every

    def plot(self) -> "Figure":
        """Return a figure of cost and limits over dress interval, E, lead and depth, as `grind sweep --plot`.

        Raises:
            MissingExtra: matplotlib is not installed.
        """
        figure: Figure = presenter("sweeps").figure(self)
        return figure

    def _repr_html_(self) -> str:
        return html("sweeps", self)


def _cost(point: SweepPoint) -> float:
    return point.cost.value


def cheapest(points: Sequence[SweepPoint]) -> SweepPoint:
    """Return the cheapest point that keeps the limits, or the cheapest of all if none does."""
    return min([point for point in points if point.keeps_limits] or points, key=_cost)


def best_of_each(points: Sequence[SweepPoint], name: str) -> tuple[SweepPoint, ...]:
    """Return the cheapest point for each value of a setting, in ascending order of the values."""
    known = sorted({getattr(point, name) for point in points})
    return tuple(cheapest([point for point in points if getattr(point, name) == value]) for value in known)


def sweep(
    program: str | Path,
    job: str | Path | Job | None = None,
    ranges: SweepRanges | None = None,
    *,
    parts: int = 50,
    seed: int = 1,
    variables: Mapping[int, float] = {},
    untried: bool = False,
    progress: Callable[[str, int], object] = lambda label, count: None,
) -> Sweep:
    """Return the costs of a program on a grid of settings, all on the same lots and machines, as `grind_env.sweep`.

    Raises:
        CondemnedError: the model scraps the unchanged program.
        GrindError: the program cannot be run with these settings.
    """
    program = Path(program)
    held = replace(job_of(program, job), variables=variables)
    trials, fleet = sweep_trials(trials_of(read_file(program), held, parts, ()), seed, untried=untried)
    study = _Study(trials, progress)
    require_good(fleet, study.as_it_is, untried=untried)
    if ranges is None or not any(ranges):
        own_E, most = float(study.own[0, E]), study.trials.simulation.task.action.speed_ends[1]
        every = (1, min(LONGEST, parts)) if study.executions.any() else None
        ranges = SweepRanges(E=(0.5 * own_E, min(2.0 * own_E, most)), every=every)
    study.refuse(ranges)
    (own,) = study.points("the program as it is", [_Setting()])
    judge = _Study(judgement_trials(trials, fleet, seed), progress)
    speeds, dresses = list[SweepPoint](), list[SweepPoint]()
    if ranges.E is not None or ranges.every is not None:
        grid = [_Setting(E=value, every=every) for every in _intervals(ranges.every) for value in _values(ranges.E)]
        speeds = judge.best_of(study.points("speeds and intervals", grid), grid, [own])
    if ranges.lead is not None or ranges.depth is not None:
        best = cheapest([own, *speeds])
        at = _Setting(E=best.E, every=best.every or None)
        pairs = [(lead, depth) for lead in _values(ranges.lead) for depth in _values(ranges.depth)]
        grid = [at._replace(lead=lead, depth=depth) for lead, depth in pairs]
        dresses = judge.best_of(study.points("leads and depths", grid), grid, [own, *speeds])
    simulation = study.trials.simulation
    return Sweep(
        program=program.name,
        parts=parts,
        lots=study.trials.lots,
        counted=DressInterval.counting(simulation.parts // parts),
        own=own,
        most_risk=most_risk(held),
        speeds=tuple(speeds),
        dresses=tuple(dresses),
        remarks=simulation.unread,
        calibration=None if held.uncertainty is None else held.uncertainty.source,
        plant=held.plant,
    )


def sweep_trials(trials: Trials, seed: int, *, untried: bool) -> tuple[Trials, Fleet | None]:
    """Return trials of the unchanged program on the lots and machines of a sweep; errors as in `fleet_of`."""
    lots = lots_of(seed, LotUse.SWEEP, LOTS)
    fleet = fleet_of(trials, seed, untried=untried)
    return trials.with_lots(lots) if fleet is None else fleet.trials_for(trials, LotUse.SWEEP, lots), fleet


def judgement_trials(trials: Trials, fleet: Fleet | None, seed: int) -> Trials:
    """Return trials on lots and machines on which no point was chosen."""
    lots = lots_of(seed, LotUse.JUDGEMENT, JUDGED_LOTS)
    return trials.with_lots(lots) if fleet is None else fleet.trials_for(trials, LotUse.JUDGEMENT, lots)


class _Setting(NamedTuple):
    """Settings of a point; None for the program's value."""

    E: float | None = None  #: mm/min
    every: int | None = None
    lead: float | None = None  #: mm a revolution
    depth: float | None = None  #: mm a pass


class _Study:
    """Study of a program in a batch of parts, with any settings of its blocks."""

    def __init__(self, trials: Trials, progress: Callable[[str, int], object]) -> None:
        self.trials, self.progress = trials, progress
        self.turns = trials.simulation.task.wheel_revolutions
        self.own = trials.own
        self.dressed = self.own[:, DRESS_PASSES] > 0.0
        self.executions = _executions(trials)
        self.as_it_is = trials.measure(self.own[None])

    def best_of(
        self, points: list[SweepPoint], settings: Sequence[_Setting], rivals: Sequence[SweepPoint]
    ) -> list[SweepPoint]:
        """Return the points, the cheapest ones judged here: their cost is that of `rivals[0]` less the saving here."""
        judged, (as_it_is,) = set[int](), self.trials.each_of_one(self.as_it_is.cost)
        while (best := cheapest([*rivals, *points])) in points and (k := points.index(best)) not in judged:
            (again,) = self.points("new lots", [settings[k]])
            dearer = rivals[0].cost.value + again.cost.value - as_it_is.value - best.cost.value
            cost, shares = Interval(*(each + dearer for each in best.cost)), tuple(map(max, best.shares, again.shares))
            points[k] = replace(best, cost=cost, luck=dearer, shares=shares, risk=max(best.risk, again.risk))
            judged.add(k)
        return points

    def refuse(self, ranges: SweepRanges) -> None:
        """Refuse illegal ranges, and ranges of values that the program does not have."""
        simulation = self.trials.simulation
        name, most = simulation.programs.name, simulation.job.setup.machine.maximum_table_speed
        for option, ends in {"E": ranges.E, "lead": ranges.lead, "depth": ranges.depth}.items():
            if ends is not None and not ends[0] > 0.0:
                raise SweepError(f"--{option} begins at {ends[0]:g}; begin above 0, for its values are swept by ratio")
        if ranges.every is not None:
            if not self.executions.any():
                raise SweepError(f"{name} has no block that takes a D word: --dress-every has nothing to place")
            if not 1 <= ranges.every[0] <= ranges.every[1] <= self.trials.runs:
                raise SweepError(f"--dress-every goes from 1 to --parts at most, which is {self.trials.runs}")
        if (ranges.lead or ranges.depth) and not self.dressed.any():
            raise SweepError(f"{name} has no dress program whose lead or depth could be swept")
        if ranges.E is None:
            return
        low, high = ranges.E
        if high > most:
            raise SweepError(f"--E goes up to {high:g} mm/min, but the table makes {most:g}")
        programmed = float(self.own[0, E])
        # compared by ratio, the whole range is nearer to the programmed E in inch/min
        if self.trials.all_blocks[0].inch and high < programmed / math.sqrt(INCH):
            raise SweepError(
                f"--E is in mm/min: {low:g}..{high:g} does not come near the {programmed:.0f} mm/min "
                f"({programmed / INCH:.0f} inch/min) of {name}; for inch/min write "
                f"--E {INCH * low:.0f}..{INCH * high:.0f}"
            )

    def points(self, label: str, settings: Sequence[_Setting]) -> list[SweepPoint]:
        """Return the cost of a part at each point."""
        found = list[SweepPoint]()
        for begin in range(0, len(settings), AT_ONCE):
            chunk = settings[begin : begin + AT_ONCE]
            other_settings = any(setting.lead is not None or setting.depth is not None for setting in chunk)
            tables = np.array([self._table(setting) for setting in chunk])
            found += self._points(tables, chunk, self.trials.measure(tables, other_settings=other_settings))
            self.progress(label, len(chunk))
        return found

    def _table(self, setting: _Setting) -> Array:
        """Return the settings of all blocks of a batch, shape (runs x blocks, fields of `BlockSettings`)."""
        table = self.own.copy()
        if setting.E is not None:
            table[:, E] *= setting.E / table[0, E]
        if setting.every is not None:
            due = DressInterval(setting.every).due(self.executions > 0.0, self.trials.run_of_block)
            table[:, D] = due * self.executions
        if setting.lead is not None:
            table[self.dressed, DRESS_FEED] = setting.lead * self.turns
        if setting.depth is not None:
            table[self.dressed, DRESS_DEPTH] = setting.depth
        return table

    def _points(self, tables: Array, settings: Sequence[_Setting], found: Measures) -> list[SweepPoint]:
        first, costs = int(self.dressed.argmax()), self.trials.each_of_one(found.cost)
        risked = risk(self.trials, found, self.as_it_is) / most_risk(self.trials.simulation.job)
        return [
            SweepPoint(
                E=float(table[0, E]),
                every=setting.every or 0,
                lead=float(table[first, DRESS_FEED]) / self.turns,
                depth=float(table[first, DRESS_DEPTH]),
                cost=costs[k],
                shares=tuple(found.ratios[k].tolist()),
                risk=float(risked[k]),
                **{name: float(getattr(found, name)[k].mean()) for name in MEANS},
            )
            for k, (table, setting) in enumerate(zip(tables, settings, strict=True))
        ]


def _executions(trials: Trials) -> Array:
    """Return D of each block of all runs if a dress is due: its greatest D; if all are 0, 1 in a run's first block."""
    takes = np.array([block.takes_dresses for block in trials.all_blocks], bool)
    most: dict[SourceText, float] = {}
    for block, executions in zip(trials.all_blocks, trials.own[:, D].tolist(), strict=True):
        most[block.block.source] = max(most.get(block.block.source, 0.0), executions)
    found = np.array([most[block.block.source] for block in trials.all_blocks]) * takes
    if not found.any() and takes.any():
        runs = trials.run_of_block
        found[[np.flatnonzero(takes & (runs == run))[0] for run in np.unique(runs[takes])]] = 1.0
    return np.asarray(found)


def _values(ends: tuple[float, float] | None) -> Sequence[float | None]:
    """Return the values of a range, evenly by ratio; None alone for a value that is not swept."""
    return [None] if ends is None else np.geomspace(*ends, POINTS if ends[0] < ends[1] else 1).tolist()


def _intervals(ends: tuple[int, int] | None) -> Sequence[int | None]:
    """Return the dress intervals of a range; of many, some evenly by ratio."""
    if ends is None:
        return [None]
    count = ends[1] - ends[0] + 1
    return sorted(
        {round(each) for each in np.geomspace(*ends, POINTS + 2)} if count > POINTS else range(ends[0], ends[1] + 1)
    )
