"""Splits: changes of the distributions from which the factors of episodes are drawn.

A split is one row of `SPLITS`, from which all draws read it. A seed draws the same random numbers in every split; each
split turns them into other factors.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

RANGES = 10  #: ranges of equal probability, into which the distribution of a factor is cut


@dataclass(frozen=True, slots=True)
class Split:
    """Changes of the random draws by a split."""

    #: ranges of every log-normal factor to draw from, counted from the lowest; empty for all
    ranges: tuple[int, ...] = ()
    reach: float = 1.0  #: factor on the logarithmic standard deviations of wear and pressure
    stock: float = 1.0  #: factor on the stock of every part that a task draws
    noise: float = 1.0  #: factor on the noise of all readings and of the pre-gauged stock
    foreign: bool = False  #: whether wheel and material come from outside the task

    @property
    def leaves_task(self) -> bool:
        """Return whether its episodes lie outside the task, so that scores of the task do not apply."""
        return replace(self, ranges=()) != Split()


EVERY = "all"  #: the split that holds nothing out; the default for episodes without a named split
SPLITS: Mapping[str, Split] = {
    EVERY: Split(),
    "inner": Split(ranges=(0, 3, 4, 5, 6, 9)),
    "interpolation": Split(ranges=(1, 8)),
    "extrapolation": Split(ranges=(0, 9), reach=1.5, stock=1.5, noise=3.0, foreign=True),
}
"""Splits by name. Ranges are symmetric, so that the median factor is 1. Ranges 2 and 7 are in no split but `all`.

Factors are cut at 1.8 standard deviations, and the outermost ranges begin at 1.28 of them: with a reach of 1.5 wear and
pressure lie beyond all that a task draws.
"""
RENAMED = {"train": "inner", "test": "interpolation"}  #: former names of splits, each with the present name


class Draws(NamedTuple):
    """A split as the compiled code reads it; `reach`, `stock` and `noise` are the factors of `Split`."""

    bits: float  #: ranges as bits of a number: bit k for the range of index k; 0 for all ranges
    reach: float
    stock: float
    noise: float
    foreign: float  #: 1 if wheel and material come from outside the task


def draws_of(split: Split) -> Draws:
    """Return the numbers of a split."""
    bits = float(sum(1 << k for k in split.ranges))
    return Draws(bits, split.reach, split.stock, split.noise, float(split.foreign))
