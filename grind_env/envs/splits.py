"""Splits: changes of the distributions from which the factors of episodes are drawn.

A split is one row of `SPLITS`, and everything that draws an episode reads it from there: a seed draws the same numbers
in every split, of which each split makes other factors.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

RANGES = 10
"""Of equal probability, into which the distribution of a factor is cut."""


@dataclass(frozen=True, slots=True)
class Split:
    """What a split changes.

    Attributes:
        ranges: of every log-normal factor, counted from the lowest one, from which it is drawn; empty for all.
        reach: factor on the logarithmic standard deviations of wear and pressure.
        stock: factor on the stock of every part that a task draws.
        noise: factor on the noise of all readings and of the pre-gauged stock.
        foreign: whether an episode has a wheel and a material that the task does not have.
    """

    ranges: tuple[int, ...] = ()
    reach: float = 1.0
    stock: float = 1.0
    noise: float = 1.0
    foreign: bool = False

    @property
    def leaves_task(self) -> bool:
        """Whether its episodes are none that the task itself could draw: scores of the task say nothing of them."""
        return replace(self, ranges=()) != Split()


EVERY = "all"
"""The split that holds nothing out, from which is drawn what no split is named for."""
SPLITS: Mapping[str, Split] = {
    EVERY: Split(),
    "inner": Split(ranges=(0, 3, 4, 5, 6, 9)),
    "interpolation": Split(ranges=(1, 8)),
    "extrapolation": Split(ranges=(0, 9), reach=1.5, stock=1.5, noise=3.0, foreign=True),
}
"""Ranges are symmetric, so that the middle factor is 1 in each. 2 and 7 are in neither `inner` nor `interpolation`.

Factors are cut at 1.8 standard deviations, and the outermost ranges begin at 1.28 of them: with a reach of 1.5 wear and
pressure lie beyond all that a task draws.
"""
RENAMED = {"train": "inner", "test": "interpolation"}
"""Splits that had another name."""


class Draws(NamedTuple):
    """A split as the compiled code reads it; `reach`, `stock` and `noise` are factors, those of `Split`."""

    bits: float
    """Ranges as the bits of a number: bit k for the one of index k; 0 for all."""
    reach: float
    stock: float
    noise: float
    foreign: float
    """1 if so."""


def draws_of(split: Split) -> Draws:
    """The numbers of a split."""
    bits = float(sum(1 << k for k in split.ranges))
    return Draws(bits, split.reach, split.stock, split.noise, float(split.foreign))
