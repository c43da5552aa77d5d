"""The best programs that a search has found, searched on and ranked on more machines than it had."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from grind_env.shop.optimise.budget import TimeUp
from grind_env.shop.optimise.outcome import Trade
from grind_env.shop.optimise.search import Point
from grind_env.shop.optimise.variation import Pace, Progress, Variation
from grind_env.shop.trials import LotUse

COMPARED = 256
"""Lots on which programs are compared, each on a machine of its own: few tell badly how bad one machine of 20 is."""
FINALISTS, BEYOND = 8, (1.12, 1.3, 1.7, 2.5)
"""Programs that are compared, besides steps towards the best one: the cheapest of those that come to no more than some
shares of what is asked. So many of these lie evenly from that of the best one down to the least that any has come to,
since much that the search finds within what is asked is beyond it on other lots and machines; and some beyond 1, since
it is the other way round, too."""
SURE = 0.96
"""Share of what is asked that programs keep where they are compared, so that they keep it on others, too."""
STEP_BY_STEP = 3, 8
"""Finalists, and lots on which they are compared, of a program that the control executes, a thousand times slower."""


def compared(
    variation: Variation,
    ranked: Sequence[Point],
    tried: Mapping[Point, Trade],
    pace: Pace,
    following: Callable[[], float],
    progress: Progress,
    label: str = "comparing",
) -> list[Point]:
    """Programs in the order in which they are to be judged, the first one whatever the time.

    A search on few machines hardly meets those on which a program is bad. Its cheapest ones for what they come to of
    what is asked, and steps towards the best of them, are ground on many more; from the best one there it goes on as
    long as a step is better. What is cheapest is judged first, then what is cheapest among those that come to less of
    what is asked, and then what the search had found, if there was no time to grind it on so many.

    Args:
        variation: what was searched.
        ranked: what the search has tried, the best first.
        tried: what each came to.
        pace: of these trials.
        following: time that is left for what follows, s, as the pace is known.
        progress: as of the search.
        label: of what is being done.
    """
    if not variation.base.simulation.compiled:
        return _step_by_step(variation, list(ranked))
    trials, quantity = variation.trials(LotUse.COMPARISON, COMPARED), variation.wishes.quantity
    known: dict[Point, Trade] = {}
    search = variation.search(trials, progress, label, known, pace, following, sure=SURE)
    some = dict.fromkeys([*front(tried, quantity, BEYOND), *variation.steps_to(ranked[0])])
    search.refine(variation.start, list(some))
    others = [point for point in search.ranked if point in some]
    kept = [point for point in others if known[point].keeps]
    best = front(known, quantity) if any(each.keeps for each in known.values()) else []
    untold = [point for point in some if point not in known]  # for which there was no time
    found = dict.fromkeys([*best, *kept, *untold, *others])
    return [point for point in found if point != variation.start] or [variation.start]


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
    trials, finalists, budget = variation.trials(LotUse.COMPARISON, lots), ranked[:most], variation.budget
    if len(finalists) == 1:
        return finalists
    try:
        old = trials.measure(trials.own[None], between=budget.require_comparison)
        found = variation.measure(trials, finalists, budget.require_comparison)
    except TimeUp:
        return finalists
    worth = variation.worth(variation.shares(trials, found, old) / SURE, found)
    return [finalists[k] for k in worth.argsort(kind="stable")]
