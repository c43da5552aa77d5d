"""How much of its time a search leaves for what follows it: the comparison of its best, and the judgement of one."""

from grind_env.shop.machines import other_laws
from grind_env.shop.optimise.comparing import COMPARED
from grind_env.shop.optimise.variation import Pace, Variation
from grind_env.shop.trials import LotUse

SEARCHED, JUDGED = 20, 256
"""Lots on which programs are searched, and on which the best one is judged; more of short batches, and fewer of a
program that the control executes, if there is no time for them."""
TO_COMPARE, TO_JUDGE = 100, 4
"""Programs for which the search leaves time."""
OTHER_LAWS = 1.5
"""Times the pace of a search that a program takes on machines that obey other laws."""
MOST_COMPARING, MOST_JUDGING = 0.2, 0.12
"""Shares of the budget that it leaves for comparison and judgement, at most."""


def judging(variation: Variation, pace: Pace) -> float:
    """Time that is left for the judgement of what a search has found, s.

    It is no more than `MOST_JUDGING` of the budget, for a pace that is known badly must not end a search at once.
    """
    lots = variation.lots(LotUse.JUDGEMENT, TO_JUDGE * JUDGED)
    seconds, budget = _pace(variation, pace) * lots + variation.reading, variation.budget.seconds
    return min(seconds, MOST_JUDGING * budget)


def following(variation: Variation, pace: Pace) -> float:
    """Time that is left for all that follows a search, s: comparison and judgement."""
    comparing = min(_pace(variation, pace) * TO_COMPARE * COMPARED, MOST_COMPARING * variation.budget.seconds)
    return comparing + judging(variation, pace)


def _pace(variation: Variation, pace: Pace) -> float:
    """Time that a program takes on a lot of what follows a search, s."""
    return pace.seconds * (OTHER_LAWS if other_laws(variation.job) else 1.0)
