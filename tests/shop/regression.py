"""What a shop does without a model: log P/b = c + e log a + f log v + g log(V + 10), by least squares on its log.

Depth of cut a, mm, engaged width b, mm, and volume V since the dress, mm3/mm, are those of the program on the machine
of the catalogue, which is more than a shop knows; v is the programmed table speed. What the rows do not tell is taken
from what a chip says: the power goes with the removal rate a v.
"""

from typing import Any

import numpy as np

EARLY = 10.0  # mm3/mm
LEAST = 1e-5  # mm
WEAK = 1e-3  # of a row: how much is held to f = e and g = 0 where no row says otherwise


def terms(a: Any, v: Any, V: Any) -> np.ndarray:
    """Columns of the regression."""
    return np.column_stack([np.ones(len(a)), np.log(np.maximum(a, LEAST)), np.log(v), np.log(V + EARLY)])


def fitted(a: Any, v: Any, V: Any, b: Any, P: Any, weight: Any) -> np.ndarray:
    """Its coefficients."""
    usable = (P > 0.0) & (a > LEAST) & (b > 0.0)
    rows, goal, weight = terms(a, v, V)[usable], np.log(P[usable] / b[usable]), np.sqrt(weight[usable])
    weak = WEAK * np.array([[0.0, 1.0, -1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]])
    held = np.vstack([weight[:, None] * rows, np.sqrt(len(goal)) * weak])
    return np.linalg.lstsq(
        held, np.append(weight * goal, np.sqrt(len(goal)) * WEAK * np.array([0.0, 0.0, 0.8])), rcond=None
    )[0]


def predicted(coefficients: np.ndarray, a: Any, v: Any, V: Any, b: Any) -> np.ndarray:
    """Power, W; none where nothing is cut."""
    return np.where(np.asarray(a) > LEAST, b * np.exp(terms(a, v, V) @ coefficients), 0.0)
