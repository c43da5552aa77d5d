"""The verdict on the best words found: better or not, by how much, and which limits bind."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.machine.script.block_settings import D
from grind_env.policies.score_statistics import Interval, percentile_interval, resampled_means
from grind_env.process.cost import NO_LIMIT, Limits
from grind_env.shop.dress_interval import DressInterval
from grind_env.shop.optimise.result import LimitUse, PartMean, Requirement, Verdict, WordChange
from grind_env.shop.optimise.search import Point
from grind_env.shop.optimise.search_problem import Variation
from grind_env.shop.optimise.variables import SearchSpace, SearchVariable
from grind_env.shop.optimise.word_editing import Spot
from grind_env.shop.possible_machines import Fleet
from grind_env.shop.search_options import INTERVAL, LIMITS
from grind_env.shop.trials import LotUse, Measures, Trials, most_risk

WORTH_NAMING = 0.01  #: least cost of a limit that binds, as a share of the cost or time of a part
NEAR = 0.95  #: share of the permitted value from which on a limit is near

QUANTITIES = {
    "cost": "$",
    "seconds": "s",
    "Ra": "um",
    "power": "kW",
    "rise": "K",
    "highest_rise": "K",
    "size_error": "um",
    "scrap": "%",
}
UNITS = {"power": "kW", "rise": "K", "Ra": "um", "size": "um"}


class JudgedProgram(NamedTuple):
    """Result of a program with new words on the lots of the judgement."""

    point: Point
    new: Measures
    requirements: tuple[Requirement, ...]
    change: "CostChange"

    def keeps(self, variation: Variation) -> bool:
        """Return whether it keeps limits and options, and is better or meets a constraint that the old one misses."""
        asked = all(each.kept for each in self.requirements) and not self.new.violation(variation.margins).any()
        return asked and (self.change.is_better or any(each.before > each.most for each in self.requirements))


class ProgramJudge:
    """Judge of programs on lots that the search has not seen, compared with the unchanged program."""

    def __init__(self, variation: Variation, lots: int | None = None) -> None:
        budget = variation.budget
        self.variation, self.trials = variation, variation.trials(LotUse.JUDGEMENT, lots)
        began = budget.spent
        self.old = self.trials.measure(self.trials.own[None], between=budget.require_first)
        self.seconds = budget.spent - began
        """Time to judge one program, s."""
        self.judged: list[JudgedProgram] = []

    def measured(self, point: Point) -> Measures:
        return self.variation.measure(self.trials, [point])

    def keeps_all(self, point: Point) -> bool:
        """Return whether a program keeps all limits and options."""
        return not (self.variation.shares(self.trials, self.measured(point), self.old) > 1.0).any()

    def judge(self, point: Point) -> JudgedProgram:
        """Return the result of new words, compared with the unchanged program."""
        variation, new = self.variation, self.measured(point)
        quantity = variation.options.quantity
        difference = getattr(new, quantity)[0] - getattr(self.old, quantity)[0]
        risk = float(variation.risk(self.trials, new, self.old)[0])
        change = CostChange(self.trials.of_one(difference), paired(difference), risk, most_risk(variation.job))
        requirements = tuple(
            Requirement(name, QUANTITIES[name], most, *(float(getattr(each, name).mean()) for each in (self.old, new)))
            for name, most in variation.options.constraint.items()
        )
        self.judged.append(JudgedProgram(point, new, requirements, change))
        return self.judged[-1]

    def best_of(self, points: Sequence[Point]) -> JudgedProgram:
        """Return the first program that keeps limits and options and is better, else the first of all.

        The first program is always judged, because time is reserved for it; the others only while there is time.
        """
        budget, longest = self.variation.budget, 0.0
        for point in points:
            began = budget.spent
            if self.judged and began + longest > budget.seconds:
                break
            if self.judge(point).keeps(self.variation):
                return self.judged[-1]
            longest = max(longest, budget.spent - began)
        return self.judged[0]


class CostChange(NamedTuple):
    """Change of the objective of a part with other words."""

    one: Interval  #: change on one machine
    mean: Interval  #: mean change, with the confidence interval of the mean
    risk: float  #: ratio of new to old cost on a bad machine, as in `Variation.risk`
    most_risk: float  #: greatest permitted `risk`

    @property
    def is_better(self) -> bool:
        """Return whether the objective falls significantly, and rises little on machines where the words are bad."""
        return self.mean.high < 0.0 and self.risk <= self.most_risk


def verdict_of(
    feasible: bool, chosen: JudgedProgram, limits: tuple[LimitUse, ...], variation: Variation, on: str
) -> tuple[Verdict, str]:
    """Return whether the best words are better, and why; `on` names the lots of the judgement."""
    _, new, requirements, change = chosen
    beyond, confidence = new.violation(variation.margins)[0], variation.options.confidence
    unit = QUANTITIES[variation.options.quantity]
    stay = f"{confidence_text(confidence)} stay below"
    worst = limits[int(beyond.argmax())]
    missed = max(
        (each for each in requirements if not each.kept), key=lambda each: each.after / each.most, default=None
    )
    one = change.one
    said = f"{one.value:+.3f} {unit} a part ({one.low:+.3f} to {one.high:+.3f}) against the program as it is"
    if beyond.max() > 0.0 and missed is None and change.is_better and _nearer(limits):
        return Verdict.NEARER, (
            f"{said}, on {on}; {stay} {100.0 * worst.after:.0f} % of the limit of {worst.name}, before "
            f"{100.0 * worst.before:.0f} %"
        )
    if not feasible and (beyond.max() > 0.0 or missed is None):
        return Verdict.INFEASIBLE, (
            f"the limit of {worst.name} forbids all programs tried: with the nearest one {stay} "
            f"{100.0 * worst.after:.0f} % of it, {100.0 * worst.margin:.0f} % is allowed"
        )
    if not feasible and missed is not None:
        return Verdict.INFEASIBLE, (
            f"no program tried keeps the limits within {missed.most:g} {missed.unit} a part; the nearest one takes "
            f"{missed.after:.4g} {missed.unit}"
        )
    if beyond.max() > 0.0:
        return Verdict.NOT_BETTER, (
            f"the best program exceeds the limit of {worst.name} on {on}: {stay} "
            f"{100.0 * worst.after:.1f} % of it, {100.0 * worst.margin:.0f} % is allowed"
        )
    if missed is not None:
        return Verdict.NOT_BETTER, (
            f"the best program takes {missed.after:.4g} {missed.unit} a part on {on}, at most {missed.most:g} was asked"
        )
    gained = [each for each in requirements if each.before > each.most]
    if gained:
        reached = ", ".join(f"{each.before:.4g} to {each.after:.4g} {each.unit} a part" for each in gained)
        return Verdict.BETTER, f"{reached}, as asked; {said}, on {on}"
    if change.mean.high >= 0.0:
        return Verdict.NOT_BETTER, f"the best one: {said}, which may be chance"
    if change.risk > change.most_risk:
        return Verdict.NOT_BETTER, (
            f"the best one: {said}, but on {100.0 * (1.0 - confidence):.3g} of 100 "
            f"machines it takes at least {100.0 * change.risk - 100.0:.0f} % more"
        )
    return Verdict.BETTER, f"{said}, on {on}"


def _nearer(limits: Sequence[LimitUse]) -> bool:
    """Return whether the old words exceed a limit and the new words exceed none further."""
    return any(each.before > 1.0 for each in limits) and all(
        each.after <= max(each.margin, each.before) for each in limits
    )


def confidence_text(confidence: float) -> str:
    """Return a confidence as words, such as "95 of 100 parts"."""
    return f"{100.0 * confidence:g} of 100 parts"


def paired(difference: Array) -> Interval:
    """Return the mean over lots, with the interval of the mean and not of one machine."""
    return percentile_interval(float(difference.mean()), resampled_means(difference[None])[:, 0])


def quantities_of(
    judged: Trials, once: Trials, once_after: Trials, old: Measures, new: Measures
) -> tuple[PartMean, ...]:
    """Return means of a part before and after, on the judged lots and in one run on the expected lot."""
    scales = {name: 100.0 if unit == "%" else 1.0 for name, unit in QUANTITIES.items()}
    expected = [each.measure(each.own[None], handover=False) for each in (once, once_after)]
    before, after, one_run, one_run_after = (
        np.array([scale * getattr(each, name)[0] for name, scale in scales.items()]) for each in (old, new, *expected)
    )
    shown = [judged.each_of_one(each) for each in (before, after, after - before)]
    return tuple(
        PartMean(
            name=name,
            unit=unit,
            before=shown[0][k],
            after=shown[1][k],
            difference=shown[2][k],
            expected=(float(one_run[k, 0]), float(one_run_after[k, 0])),
        )
        for k, (name, unit) in enumerate(QUANTITIES.items())
    )


class LimitCost(NamedTuple):
    """Result of the best words without a limit."""

    price: Interval  #: saving of the objective, a part
    share: float  #: share of the limit that parts stay below with these words


def limits_of(variation: Variation, old: Measures, new: Measures, costs: dict[str, LimitCost]) -> tuple[LimitUse, ...]:
    """Return the use of each limit; `costs` has the result without a limit by name, if searched."""
    worth = WORTH_NAMING * float(getattr(new, variation.options.quantity).mean())
    job, found = variation.job, []
    every = {each.name: _by_name(job.at_station(k, 0).limits) for k, each in enumerate(job.stations)}
    every = every or {"": _by_name(job.limits)}
    for k, name in enumerate(LIMITS):
        margin, after, cost = float(variation.margins[k]), float(new.ratios[0, k]), costs.get(name)
        values = {station: limits[name] for station, limits in every.items()}
        found.append(
            LimitUse(
                name=name,
                limit=min((value for value in values.values() if value > NO_LIMIT), default=NO_LIMIT),
                unit=UNITS[name],
                margin=margin,
                before=float(old.ratios[0, k]),
                after=after,
                price=None if cost is None else cost.price,
                without=None if cost is None else cost.share,
                binds=cost.price.low > worth and cost.share > margin if cost is not None else after > NEAR * margin,
                stations=tuple(values.items()) if len({*values.values()}) > 1 else (),
            )
        )
    return tuple(found)


def _by_name(limits: Limits) -> dict[str, float]:
    """Return the limits in `UNITS`, by the names that users give them."""
    return {"power": limits.power / 1000.0, "rise": limits.rise, "Ra": limits.roughness, "size": limits.size}


def machine_remarks(fleet: Fleet | None) -> list[str]:
    """Return a remark on the machines on which programs were tried."""
    if fleet is None:
        return [
            "this program is executed step by step, which is slow, so it was tried on the machine of the catalogue "
            "alone: calibrate, or keep a distance from the limits by --margin"
        ]
    if not fleet.drawn:
        return []
    these = "these" if fleet.agree == len(fleet.numbers) else f"the {len(fleet.numbers)} that come nearest to it"
    alike = f", if parts differ {fleet.spread:g} times as much as the job says" if fleet.spread < 1.0 else ""
    return [
        f"{fleet.agree} of {fleet.drawn} possible machines grind good parts with the program as it is{alike}; programs "
        f"were tried on {these}. If the program as it is has never run on your machine, use --untried"
    ]


def ranking_remarks(judged: int, kept: bool, unjudged: int) -> list[str]:
    """Return remarks on first-ranked programs that failed on unseen lots, and on programs that were not judged."""
    ranked, too = ("before it", "") if kept else ("next", ", too")
    which = f"the {judged - 1} programs ranked {ranked} on lots of the search"
    said = [f"{which} failed on unseen lots{too}: a limit, a constraint or the permitted risk"] if judged > 1 else []
    if unjudged and not kept:
        said.append(f"the budget ended before {unjudged} more programs were judged: raise --budget")
    return said


def dress_remarks(before: Trials, after: Trials, runs: int) -> list[str]:
    """Return a warning if the wheel is no longer dressed."""
    before_cycles = any(block.plan.pre_dress for block in after.simulation.blocks)
    if before.own[:, D].any() and not after.own[:, D].any() and not before_cycles:
        return [
            f"no block dresses the wheel any more: that holds for batches of {runs} runs, after which it is dressed; "
            "let --parts be how many you grind with a wheel, or see with `grind sweep` how often to dress it"
        ]
    return []


def _bound(variable: SearchVariable, number: int) -> str:
    """Return at which end of its range a value is; empty for neither, and for an absolute minimum."""
    if number == len(variable.levels) - 1:
        return "highest"
    return "lowest" if number == 0 and variable.levels[0] > (1 if variable.name == "passes" else 0) else ""


def words_of(choices: SearchSpace, point: Point) -> tuple[WordChange, ...]:
    """Return a point of the search as changes of words, and of the dress interval where it was searched."""
    words = [_word_of(each, number) for each, number in zip(choices.variables, point, strict=False)]
    intervals, number = choices.intervals, point[-1]
    if intervals[-1].every > 1:
        words.append(
            WordChange(
                name=INTERVAL,
                place="dresses",
                before=str(DressInterval(1, intervals[0].of)),
                after=str(intervals[number]),
                unit="",
                at_bound="highest" if number == len(intervals) - 1 else "",
            )
        )
    return tuple(words)


def _word_of(variable: SearchVariable, number: int) -> WordChange:
    inch = variable.unit != 1
    units = {"E": ("mm/min", "in/min"), "J": ("mm", "in"), "lead": ("mm/min", "in/min"), "depth": ("mm", "in")}
    return WordChange(
        name=variable.at.letter if variable.name == "E" and isinstance(variable.at, Spot) else variable.name,
        place=variable.places,
        before=f"{variable.own.normalize():f}",
        after=f"{variable.levels[number].normalize():f}",
        unit=units[variable.name][inch] if variable.name in units else "",
        at_bound=_bound(variable, number),
    )
