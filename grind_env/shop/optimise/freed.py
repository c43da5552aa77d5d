"""What each limit costs: the best words without it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from grind_env.machine.job import Job, Part
from grind_env.policies.statistics import Interval
from grind_env.process.cost import NO_LIMIT
from grind_env.shop.optimise.budget import Budget
from grind_env.shop.optimise.comparing import front
from grind_env.shop.optimise.judgement import Freed, ProgramJudge, paired
from grind_env.shop.optimise.outcome import Trade
from grind_env.shop.optimise.search import GENERATIONS, Point
from grind_env.shop.optimise.variation import Progress, Variation
from grind_env.shop.trials import LotUse
from grind_env.shop.wishes import LIMITS

FEWER = 4
"""Generations, or programs, of a search without a limit, over those of the whole one."""
OVER = 1.2
"""Times the budget up to which words without each limit are searched."""

FREE = {"temp": ("rise_allowance", 2000.0), "Ra": ("roughness_limit", NO_LIMIT), "size": ("tolerance", NO_LIMIT)}
"""Field of a part that holds a limit, and what it is without."""


def freed_of(
    variation: Variation, judgement: ProgramJudge, best: Point, found: Mapping[Point, Trade], progress: Progress
) -> dict[str, Freed]:
    """The best words without each limit: what they save on unseen lots, and how far they are beyond it.

    A limit that no program of `found` exceeds costs nothing; its share is that of the best words. Limits for which the
    time is up are left out.
    """
    quantity, budget = variation.wishes.quantity, variation.budget
    new = judgement.measured(best)
    words: dict[str, Freed] = {}
    others = []
    for k, name in enumerate(LIMITS):
        if (free := without(variation.job, name)) is None:
            continue
        if any(each.beyond[k] for each in found.values()):
            others.append((k, name, free))
        else:
            words[name] = Freed(Interval(0.0, 0.0, 0.0), float(new.ratios[0, k]))
    for number, (k, name, free) in enumerate(others):
        seconds = (OVER * budget.seconds - budget.spent) / (len(others) - number)
        if seconds < 2.0 * budget.judging:
            break
        margins = variation.margins.copy()
        margins[k] = np.inf
        other = variation.with_job(free, margins, Budget(seconds, budget.programs / FEWER, budget.judging))
        tried: dict[Point, Trade] = {}
        search = other.search(other.trials(LotUse.SEARCH), f"without the limit of {name}", progress, tried)
        search.run(best, variation.seed, GENERATIONS // FEWER)
        judged = ProgramJudge(other)
        point = next((each for each in front(tried, quantity) if judged.keeps_all(each)), best)
        saves = getattr(new, quantity)[0] - getattr(judged.measured(point), quantity)[0]
        words[name] = Freed(paired(saves), float(judgement.measured(point).ratios[0, k]))
    return words


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
