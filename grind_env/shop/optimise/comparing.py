"""The best programs that a search has found, searched on and ranked on more machines than it had."""

from collections.abc import Mapping, Sequence

import numpy as np

from grind_env.shop.optimise.budget import TimeUp
from grind_env.shop.optimise.outcome import Trade
from grind_env.shop.optimise.search import Point, Search
from grind_env.shop.optimise.variation import SURE, Progress, Variation
from grind_env.shop.trials import LotUse

FINALISTS, BEYOND = 8, (1.12, 1.3, 1.7, 2.5)
"""Programs that are compared, besides steps towards the best one: the cheapest of those that come to no more than some
shares of what is asked. So many of these lie evenly from that of the best one down to the least that any has come to,
since much that the search finds within what is asked is beyond it on other lots and machines; and some beyond 1, since
it is the other way round, too."""
STEP_BY_STEP = 3, 8
"""Finalists, and lots on which they are compared, of a program that the control executes, a thousand times slower."""


def compared(
    variation: Variation, search: Search, tried: Mapping[Point, Trade], progress: Progress, label: str = "comparing"
) -> list[Point]:
    """Return programs in the order in which they are to be judged, at least one.

    A search on few machines hardly meets those on which a program is bad. Its cheapest ones for what they come to of
    what is asked, and steps towards the best of them, are ground on many more; from the best one there it goes on as
    long as a step is better. What is cheapest is judged first, then what is cheapest among those that come to less of
    what is asked, and then what the search had found, if there was no time to grind it on so many.
    """
    if not variation.base.simulation.compiled:
        return _step_by_step(variation, search.ranked)
    known: dict[Point, Trade] = {}
    quantity, start = variation.wishes.quantity, variation.start
    more = variation.search(variation.trials(LotUse.COMPARISON), label, progress, known, comparing=True)
    some = dict.fromkeys([*variation.steps_to(search.ranked[0]), *front(tried, quantity, BEYOND)])
    more.refine(start, list(some))
    others = [point for point in more.ranked if point in some]
    kept = [point for point in others if known[point].keeps]
    best = front(known, quantity) if any(each.keeps for each in known.values()) else []
    untold = [point for point in some if point not in known]  # for which there was no time
    found = dict.fromkeys([*best, *kept, *untold, *others])
    return [point for point in found if point != start] or [start]


def front(tried: Mapping[Point, Trade], quantity: str, beyond: Sequence[float] = ()) -> list[Point]:
    """The cheapest program that keeps all, the cheapest ones that keep more and more than that, then ones beyond."""
    cheap = sorted(tried, key=lambda point: (getattr(tried[point], quantity), point))
    shares = [tried[point].share for point in cheap]
    least = min(shares)
    best = next((share for share in shares if share <= 1.0), least)
    levels = (*np.linspace(best, least, FINALISTS).tolist(), *(max(level, least) for level in beyond))
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
