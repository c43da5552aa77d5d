"""Why each word of a proposed program is what it is: what a part would come to with a lower and a higher value."""

from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import NamedTuple

from grind_env.shop.optimise.judgement import WORTH_NAMING, limits_of, words_of
from grind_env.shop.optimise.outcome import LimitUse, WordChange
from grind_env.shop.optimise.search import Point
from grind_env.shop.optimise.table import limit_text
from grind_env.shop.optimise.variation import Variation
from grind_env.shop.trials import Measures

STEP = Decimal("1.25")
"""By which factor a value is lowered and raised; by one where that is more."""
LOWER, HIGHER = -1, 1
TIME = "the time of the search"
"""What sets a word of which a better value was not tried."""
ENDS = {
    ("E", HIGHER): "the table comes to no more before it meets the wheel",
    ("D", LOWER): "the wheel is to be dressed",
    ("lead", LOWER): "slower, the diamond glazes the wheel",
    ("lead", HIGHER): "faster, the diamond cuts a thread",
}
"""Why a value may not be lower or higher, where that is more than the range of the search."""
BOUNDS = {LOWER: "it is the lowest of its range", HIGHER: "it is the highest of its range"}


class Reason(NamedTuple):
    """A word, and why it is what it is."""

    word: WordChange
    """As it is proposed, `before` by the rules."""
    why: str
    """What sets it: a limit, cost, the rules, or the time of the search; and what it would come to otherwise."""

    @property
    def remark(self) -> str:
        """The same in a comment."""
        return f"{self.word.name} {self.why}"


class _Side(NamedTuple):
    """What a part would come to with one word lower or higher."""

    said: str
    change: float
    """$."""
    limit: str
    """Which one it comes too near to; empty if none."""


def reasons_of(
    variation: Variation, point: Point, chosen: Measures, measure: Callable[[Sequence[Point]], Measures]
) -> tuple[Reason, ...]:
    """Why the words of a point are what they are.

    Args:
        variation: what was searched.
        point: the words.
        chosen: what they come to.
        measure: says what other points come to, on the same lots and machines.
    """
    words = words_of(variation.choices, point)
    places = [(k, way) for k in range(len(words)) for way in (LOWER, HIGHER)]
    moved = {place: other for place in places if (other := _moved(variation, point, *place)) is not None}
    measured = measure(list(moved.values()))
    sides = {
        (k, way): _side(variation, words_of(variation.choices, other)[k].after, chosen, measured.of(number))
        for number, ((k, way), other) in enumerate(moved.items())
    }
    least = -WORTH_NAMING * float(chosen.cost.mean())
    return tuple(
        Reason(word, _why(word, least, {way: sides.get((k, way)) for way in BOUNDS})) for k, word in enumerate(words)
    )


def _moved(variation: Variation, point: Point, k: int, way: int) -> Point | None:
    """The point with one value lower or higher; None where there is none."""
    values = variation.choices.variables[k].levels
    goal = values[point[k]] * STEP**way
    number = min(range(len(values)), key=lambda each: abs(values[each] - goal))
    number = number if (number - point[k]) * way > 0 else point[k] + way
    return (*point[:k], number, *point[k + 1 :]) if 0 <= number < len(values) else None


def _side(variation: Variation, value: str, chosen: Measures, new: Measures) -> _Side:
    change, scrap = (
        float((after - before).mean()) for after, before in ((new.cost, chosen.cost), (new.scrap, chosen.scrap))
    )
    limits = limits_of(variation, chosen, new, {})
    worst = max(limits, key=lambda each: each.after / each.margin)
    said = f"{change:+.2f} $ at {value}"
    if not worst.kept:
        return _Side(f"{said} and {_said(worst)}", change, worst.name)
    spoilt = scrap * variation.job.part.scrap_cost
    if 0.0 < change < 2.0 * spoilt:
        grown = max(limits, key=lambda each: each.after - each.before)
        return _Side(f"{said} by scrap, {_said(grown)}", change, grown.name)
    return _Side(said, change, "")


def _said(limit: LimitUse) -> str:
    return f"{limit.name} at {100.0 * limit.after:.0f} % of {limit_text(limit)}"


def _why(word: WordChange, least: float, sides: dict[int, _Side | None]) -> str:
    """What sets a word; a change that is no lower than `least`, $, is hardly one."""
    there = [side for side in sides.values() if side is not None]
    limits = list(dict.fromkeys(side.limit for side in there if side.limit))
    ends = [ENDS.get((word.name, way), bound) for way, bound in BOUNDS.items() if sides[way] is None]
    if any(side.change < least and not side.limit for side in there):
        set_by = TIME
    else:
        set_by = " and ".join(limits) or ("the rules" if ends else "cost")
    return f"by {set_by}: {', '.join([*(side.said for side in there), *ends])}"
