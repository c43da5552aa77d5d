"""What a shop can do without a model: log P/b = c + e log a + f log v + g log(V' + 10), by least squares on its log.

Depth of cut a, mm, engaged width b, mm, and volume V' since the dress, mm3/mm, are those of the program on the machine
of the catalogue, which is more than a shop knows; v is the programmed table speed, mm/s.
"""

from typing import NamedTuple

import numpy as np

from grind_env.arrays import Array

EARLY, LEAST, WEAK = 10.0, 1e-5, 1e-3
"""mm3/mm; mm, below which nothing is cut; share of a row by which what no row tells is held to what a chip says: that
power goes with the removal rate, to the power .8, and not with the volume."""
TO_A_CHIP = np.array([[0.0, 1.0, -1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]), np.array([0.0, 0.0, 0.8])


class MeanCuts(NamedTuple):
    """Of each stroke, or in the mean of several, shape (n,)."""

    a: Array
    v: Array
    V: Array
    b: Array

    @property
    def terms(self) -> Array:
        """Columns of the regression."""
        depth = np.maximum(self.a, LEAST)
        return np.column_stack([np.ones(len(depth)), np.log(depth), np.log(self.v), np.log(self.V + EARLY)])


def fitted(cuts: MeanCuts, power: Array) -> Array:
    """Its coefficients c, e, f and g, by power in W; a strong stroke counts more than a weak one."""
    usable = (power > 0.0) & (cuts.a > LEAST) & (cuts.b > 0.0)
    some = MeanCuts(*(each[usable] for each in cuts))
    held = WEAK * float(power[usable].sum())
    rows = np.vstack([power[usable, None] * some.terms, held * TO_A_CHIP[0]])
    goal = np.append(power[usable] * np.log(power[usable] / some.b), held * TO_A_CHIP[1])
    return np.asarray(np.linalg.lstsq(rows, goal, rcond=None)[0])


def predicted(coefficients: Array, cuts: MeanCuts) -> Array:
    """Power, W; none where nothing is cut."""
    return np.where(cuts.a > LEAST, cuts.b * np.exp(cuts.terms @ coefficients), 0.0)
