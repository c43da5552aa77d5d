"""Rank the best programs of a search on more machines, and find the cost of each limit."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from grind_env.machine.job import Job, Part
from grind_env.policies.score_statistics import Interval
from grind_env.process.cost import NO_LIMIT
from grind_env.shop.optimise.judgement import LimitCost, ProgramJudge, paired
from grind_env.shop.optimise.result import Trade
from grind_env.shop.optimise.search import GENERATIONS, Budget, Point, Search, TimeUp
from grind_env.shop.optimise.search_problem import SURE, Progress, Variation
from grind_env.shop.search_options import LIMITS
from grind_env.shop.trials import LotUse

#: number of finalists, besides steps towards the best program, and levels above 1. A finalist is the cheapest program
#: with at most a certain share of the limits. These shares lie evenly from that of the best program down to the least,
#: because many programs that keep the limits in the search exceed them on other lots and machines. The levels above 1
#: exist because the opposite happens, too
FINALISTS, LEVELS_ABOVE_LIMIT = 8, (1.12, 1.3, 1.7, 2.5)
#: number of finalists and of lots in the comparison of a program that the control executes, a thousand times slower
STEP_BY_STEP = 3, 8
FEWER = 4  #: divisor of the generations, or programs, of a search without a limit
BUDGET_OVERRUN = 1.2  #: multiple of the budget up to which words without each limit are searched

#: field of a part that has each limit, and its value without the limit
UNLIMITED = {"rise": ("rise_allowance", 2000.0), "Ra": ("roughness_limit", NO_LIMIT), "size": ("tolerance", NO_LIMIT)}


def rank_finalists(
    variation: Variation, search: Search, tried: Mapping[Point, Trade], progress: Progress
) -> list[Point]:
    """Return programs in the order of judgement, at least one.

    A search on few machines rarely meets the machines on which a program is bad. Many more machines therefore grind its
    cheapest programs at several levels of the limits, and steps towards the best of them; steps continue from the best
    one while they improve. The cheapest program is judged first, then the cheapest at lower levels of the limits. If
    time was too short for more machines, the result of the search follows.
    """
    if not variation.base.simulation.compiled:
        return _step_by_step(variation, search.ranked)
    known: dict[Point, Trade] = {}
    quantity, start = variation.options.quantity, variation.start
    more = variation.search(variation.trials(LotUse.COMPARISON), "comparing", progress, known, comparing=True)
    some = dict.fromkeys([*variation.steps_to(search.ranked[0]), *front(tried, quantity, LEVELS_ABOVE_LIMIT)])
    more.run(start, variation.seed, 0, list(some))
    others = [point for point in more.ranked if point in some]
    kept = [point for point in others if known[point].keeps]
    best = front(known, quantity) if any(each.keeps for each in known.values()) else []
    unmeasured = [point for point in some if point not in known]  # for which there was no time
    found = dict.fromkeys([*best, *kept, *unmeasured, *others])
    return [point for point in found if point != start] or [start]


def front(tried: Mapping[Point, Trade], quantity: str, more_levels: Sequence[float] = ()) -> list[Point]:
    """Return the cheapest program within all limits, then the cheapest at stricter levels, then at `more_levels`."""
    cheap = sorted(tried, key=lambda point: (getattr(tried[point], quantity), point))
    shares = [tried[point].share for point in cheap]
    least = min(shares)
    best = next((share for share in shares if share <= 1.0), least)
    levels = (*np.linspace(best, least, FINALISTS).tolist(), *(max(level, least) for level in more_levels))
    return list(dict.fromkeys(next(point for point in cheap if tried[point].share <= level) for level in levels))


def _step_by_step(variation: Variation, ranked: list[Point]) -> list[Point]:
    most, lots = STEP_BY_STEP
    trials, finalists = variation.trials(LotUse.COMPARISON, lots), ranked[:most]
    between = variation.budget.require_search
    try:
        old = trials.measure(trials.own[None], between=between)
        found = variation.measure(trials, finalists, between)
    except TimeUp:
        return finalists
    worth = variation.worth(variation.shares(trials, found, old) / SURE, found)
    return [finalists[k] for k in worth.argsort(kind="stable")]


def costs_of_limits(
    variation: Variation, judgement: ProgramJudge, best: Point, found: Mapping[Point, Trade], progress: Progress
) -> dict[str, LimitCost]:
    """Return the best words without each limit: their saving on unseen lots, and their excess over the limit.

    A limit that no program of `found` exceeds costs nothing; its share is of the best words. Limits are left out when
    the time is up.
    """
    quantity, budget = variation.options.quantity, variation.budget
    new = judgement.measured(best)
    words: dict[str, LimitCost] = {}
    others = []
    for k, name in enumerate(LIMITS):
        if (free := job_without(variation.job, name)) is None:
            continue
        if any(each.beyond[k] for each in found.values()):
            others.append((k, name, free))
        else:
            words[name] = LimitCost(Interval(0.0, 0.0, 0.0), float(new.ratios[0, k]))
    for number, (k, name, free) in enumerate(others):
        seconds = (BUDGET_OVERRUN * budget.seconds - budget.spent) / (len(others) - number)
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
        words[name] = LimitCost(paired(saves), float(judgement.measured(point).ratios[0, k]))
    return words


def job_without(job: Job, limit: str) -> Job | None:
    """Return the job without a limit; None if it has none."""
    machine = job.setup.machine
    if limit == "power":
        stronger = replace(machine, power_limit=min(4.0 * machine.power_limit, 500_000.0))
        return replace(job, setup=replace(job.setup, machine=stronger))
    name, free = UNLIMITED[limit]
    kinds = [
        job.part,
        *(each.part for each in job.parts if each.part is not None),
        *(each.part for each in job.stations),
    ]
    if free == NO_LIMIT and all(getattr(asked, name) == NO_LIMIT for kind in kinds for asked in (kind, *kind.stages)):
        return None

    def unlimited(part: Part) -> Part:
        other: dict[str, Any] = {name: free}
        return replace(part, stages=tuple(replace(stage, **other) for stage in part.stages), **other)

    parts = tuple(each if each.part is None else replace(each, part=unlimited(each.part)) for each in job.parts)
    stations = tuple(replace(each, part=unlimited(each.part)) for each in job.stations)
    return replace(job, part=unlimited(job.part), parts=parts, stations=stations, part_stations=())
