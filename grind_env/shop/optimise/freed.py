"""What each limit costs: the best words without it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from grind_env.machine.job import Job, Part
from grind_env.policies.statistics import Interval
from grind_env.process.cost import NO_LIMIT
from grind_env.shop.optimise.budget import Budget
from grind_env.shop.optimise.comparing import COMPARED, compared
from grind_env.shop.optimise.judgement import Freed, paired
from grind_env.shop.optimise.leaving import JUDGED, SEARCHED, TO_COMPARE, TO_JUDGE, following, judging
from grind_env.shop.optimise.outcome import Trade
from grind_env.shop.optimise.search import GENERATIONS, Point
from grind_env.shop.optimise.variation import Pace, Progress, Variation
from grind_env.shop.trials import LIMITS, LotUse, Measures, Trials

FEWER = 4
"""Generations of a search without a limit, over those of the whole one."""

FREE = {"temp": ("rise_allowance", 2000.0), "Ra": ("roughness_limit", NO_LIMIT), "size": ("tolerance", NO_LIMIT)}
"""Field of a part that holds a limit, and what it is without."""


def freed_of(
    variation: Variation,
    judged: Trials,
    best: Point,
    new: Measures,
    found: Mapping[Point, Trade],
    pace: Pace,
    budget: Budget,
    progress: Progress,
) -> dict[str, Freed]:
    """The best words without each limit: what they save on unseen lots, and how far they are beyond it.

    A limit that no program of `found` exceeds costs nothing; its share is that of the best words, from `new`. Limits
    for which the time is up are left out.
    """
    less = attrgetter(variation.wishes.quantity)
    words: dict[str, Freed] = {}
    others = []
    for k, name in enumerate(LIMITS):
        if (free := without(variation.job, name)) is None:
            continue
        if any(each.beyond[k] for each in found.values()):
            others.append((k, name, free))
        else:
            words[name] = Freed(Interval(0.0, 0.0, 0.0), float(new.ratios[0, k]))
    needed = pace.seconds * (TO_COMPARE * COMPARED + TO_JUDGE * len(judged.seeds))
    for number, (k, name, free) in enumerate(others):
        seconds = (budget.seconds - budget.spent) / (len(others) - number)
        if seconds < needed:
            break
        if number == 0:
            with_all = less(variation.measure(judged, [best]))[0]
        margins = variation.margins.copy()
        margins[k] = np.inf
        other = variation.with_job(free, margins, Budget(seconds))
        tried: dict[Point, Trade] = {}
        label = f"without the limit of {name}"
        trials = other.trials(LotUse.SEARCH, SEARCHED)
        search = other.search(trials, progress, label, tried, Pace(), partial(following, other, pace))
        search.run(best, variation.seed, GENERATIONS // FEWER)
        points = compared(other, search.ranked, tried, pace, partial(judging, other, pace), progress, label)
        point = _best_of(other, points) or best
        saves = less(other.measure(other.trials(LotUse.JUDGEMENT, JUDGED), [point]))[0]
        share = float(variation.measure(judged, [point]).ratios[0, k])
        words[name] = Freed(paired(with_all - saves), share)
    return words


def _best_of(variation: Variation, points: Sequence[Point]) -> Point | None:
    """The first of some points that keeps on unseen lots what is asked."""
    trials = variation.trials(LotUse.JUDGEMENT, JUDGED)
    old = trials.measure(trials.own[None])
    for point in points:
        if not (variation.shares(trials, variation.measure(trials, [point]), old) > 1.0).any():
            return point
    return None


def without(job: Job, limit: str) -> Job | None:
    """The job without a limit; None if it has none."""
    machine = job.setup.machine
    if limit == "power":
        stronger = replace(machine, power_limit=min(4.0 * machine.power_limit, 500_000.0))
        return replace(job, setup=replace(job.setup, machine=stronger))
    name, free = FREE[limit]
    kinds = [
        job.part,
        *(each.part for each in job.parts if each.part is not None),
        *(each.part for each in job.stations),
    ]
    if free == NO_LIMIT and all(getattr(asked, name) == NO_LIMIT for kind in kinds for asked in (kind, *kind.stages)):
        return None

    def freed(part: Part) -> Part:
        other: dict[str, Any] = {name: free}
        return replace(part, stages=tuple(replace(stage, **other) for stage in part.stages), **other)

    parts = tuple(each if each.part is None else replace(each, part=freed(each.part)) for each in job.parts)
    stations = tuple(replace(each, part=freed(each.part)) for each in job.stations)
    return replace(job, part=freed(job.part), parts=parts, stations=stations, met=())
