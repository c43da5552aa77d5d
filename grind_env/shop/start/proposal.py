"""A first program for a part: words by rules of thumb, then better ones by the search of `grind optimise`.

Nobody grinds with the words of the rules, so that nothing is a risk beside them, and the rule on risk of `grind
optimise` does not hold. What is promised is that parts keep each limit with `CONFIDENCE`, whatever their lot and
machine, and these machines are all that the catalogue's uncertainty allows, as with `--untried`. Machines that obey
other laws are not among them: for these the search leaves `ROOM`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from functools import partial

import numpy as np

from grind_env.control import read
from grind_env.errors import GrindError
from grind_env.machine.job import Job
from grind_env.policies.statistics import Interval
from grind_env.shop.optimise.editing import text_of
from grind_env.shop.optimise.finding import Searched, searched
from grind_env.shop.optimise.judgement import limits_of, parts_said
from grind_env.shop.optimise.leaving import JUDGED
from grind_env.shop.optimise.outcome import LimitUse
from grind_env.shop.optimise.search import Point
from grind_env.shop.optimise.table import limit_text
from grind_env.shop.optimise.variation import Progress, Variation, variation_of
from grind_env.shop.optimise.wishes import Wishes
from grind_env.shop.start.folder import PROGRAM
from grind_env.shop.start.program import DRESS, FINISH, ROUGH, program_text
from grind_env.shop.start.reasons import TIME, Reason, reasons_of
from grind_env.shop.start.rules import FEED_STEP, LEAD_STEP, Words, bounds_of, first_words
from grind_env.shop.trials import CONFIDENCE, LIMITS, LotUse, Measures, Trials

ROOM = 0.8
"""Share of each limit that the search keeps to."""
BATCH = 10
"""Parts that are ground with a wheel: it is dressed in each of them, so that more tell little more."""
GENERATIONS = 8
"""Of the evolution that the search begins with: on its coarse steps, the descent behind it ends where it does after
40."""
FINALISTS = 8
"""Programs that are judged, at most, beside that of the rules."""
FIELDS = {
    ("E", ROUGH): "rough_feed",
    ("J", ROUGH): "rough_pick",
    ("D", ROUGH): "dresses",
    ("E", FINISH): "finish_feed",
    ("J", FINISH): "finish_pick",
    ("L", FINISH): "spark_outs",
    ("lead", DRESS): "dress_feed",
    ("depth", DRESS): "dress_depth",
}
"""Of `Words`, by name and place of what is varied."""
HELP = {
    "power": "a softer wheel, or a machine with more power",
    "temp": "a wheel that stays sharper, such as one of CBN or of a softer grade",
    "Ra": "a finer wheel, or --Ra {least:g}",
    "size": "a wheel that stays sharper, a stiffer machine, or --tolerance {least:g}",
}
"""What to do where a limit is not kept."""


class NotHeldError(GrindError):
    """A part for which no program was found that keeps its limits."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """A first program.

    Attributes:
        job: what it grinds on which machine.
        words: what it says.
        reasons: why each word is what it is.
        good: share of good parts, with the interval in which one machine lies, like the next ones.
        cost: of a part, $.
        seconds: of a part, s.
        by_rules: share of good parts and cost, $, with the words of the rules alone.
        limits: how near parts come to each with the words of the rules, and with these.
        machines: on which it was judged.
        evaluations: programs that were tried in the search.
        ended_early: whether the time was up before search and comparison had ended.
    """

    job: Job
    words: Words
    reasons: tuple[Reason, ...]
    good: Interval
    cost: Interval
    seconds: Interval
    by_rules: tuple[float, float]
    limits: tuple[LimitUse, ...]
    machines: int
    evaluations: int
    ended_early: bool

    @property
    def text(self) -> str:
        """Of the program, with the reasons as comments."""
        remarks: dict[str, list[str]] = {}
        for each in self.reasons:
            remarks.setdefault(each.word.place, []).append(each.remark)
        return program_text(self.job, self.words, remarks)


def proposal_of(job: Job, *, seconds: float, seed: int, progress: Progress = lambda label, count: None) -> Proposal:
    """Propose a program.

    Args:
        job: what is ground on which machine, with limits of Ra and size.
        seconds: for search and judgement; reasons take somewhat longer.
        seed: of lots and search; the same one finds the same unless the time ends the search.
        progress: called with what is being done and by how many programs it has come on.

    Raises:
        NotHeldError: no program that was tried keeps the limits.
    """
    first = first_words(job)
    variation = _variation(job, first, seconds, seed)
    found = searched(variation, progress, GENERATIONS)
    trials = variation.trials(LotUse.JUDGEMENT, JUDGED)
    progress("judging", 0)
    points = list(dict.fromkeys([*found.points[:FINALISTS], variation.start]))
    measured = measures_of(variation, trials, points)
    best = _best(variation, measured)
    point, old = points[best], measured.of(points.index(variation.start))
    chosen = zip(variation.choices.variables, point, strict=False)
    words = replace(first, **{FIELDS[each.name, each.place]: float(each.levels[number]) for each, number in chosen})
    written = variation.around(read(program_text(job, words), PROGRAM)).trials(LotUse.JUDGEMENT, JUDGED)
    new = written.measure(written.own[None], handover=False)
    limits = limits_of(variation, old, new, {})
    if new.ratios.max() > 1.0:
        raise NotHeldError(_not_held(limits, trials, found))
    reasons = reasons_of(variation, point, new, partial(measures_of, variation, written))
    good, cost, duration = trials.each_of_one(np.concatenate([1.0 - new.scrap, new.cost, new.seconds]))
    return Proposal(
        job=job,
        words=words,
        reasons=reasons,
        good=good,
        cost=cost,
        seconds=duration,
        by_rules=(float(1.0 - old.scrap.mean()), float(old.cost.mean())),
        limits=limits,
        machines=len(trials.simulation.machines.jobs),
        evaluations=len(found.search.costs),
        ended_early=found.search.ended_early or any(TIME in each.why for each in reasons),
    )


def _variation(job: Job, words: Words, seconds: float, seed: int) -> Variation:
    text = program_text(job, words)
    wishes = Wishes(
        words=tuple(dict.fromkeys(name for name, _ in FIELDS)),
        bounds=bounds_of(job),
        steps={"E": Decimal(FEED_STEP), "lead": Decimal(str(LEAD_STEP))},
        margins=dict.fromkeys(LIMITS, ROOM),
        untried=True,
        guess=True,
    )
    return variation_of(read(text, PROGRAM), text_of(text.encode()), job, wishes, BATCH, seed, seconds)


def measures_of(variation: Variation, trials: Trials, points: Sequence[Point]) -> Measures:
    """What programs come to; the wheel that is left is no cost, for the parts go on."""
    settings = variation.settings(trials.own, np.array(points))
    return trials.measure(settings, besides=variation.besides, handover=False)


def _best(variation: Variation, measured: Measures) -> int:
    """The first program that keeps the room, else the one that comes nearest to it, of those first that keep limits."""
    beyond = measured.violation(variation.margins).sum(axis=1)
    return int(np.lexsort((beyond, measured.ratios.max(axis=1) > 1.0))[0]) if beyond.all() else int(beyond.argmin())


def _not_held(limits: Sequence[LimitUse], trials: Trials, found: Searched) -> str:
    worst, machines = max(limits, key=lambda each: each.after), len(trials.simulation.machines.jobs)
    least = math.ceil(102.0 * worst.after * worst.limit) / 100.0
    return (
        f"no program of {len(found.search.costs)} that were tried keeps the limit of {worst.name}, "
        f"{limit_text(worst)}: with the nearest one {parts_said(CONFIDENCE)} on {machines} machines that this may be "
        f"come to {100.0 * worst.after:.0f} % of it or less; what would help is "
        f"{HELP[worst.name].format(least=least)}"
        f"{', or more time by --budget' if found.search.ended_early else ''}"
    )
