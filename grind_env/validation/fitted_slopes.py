"""Fitted exponents, and least and greatest steps, of series of numbers."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """Return the m of y ~ x^m, by least squares of the logarithms."""
    return float(exponents([x], y)[0])


def exponents(factors: Sequence[ArrayLike], y: ArrayLike) -> NDArray[np.float64]:
    """Return the exponents of y ~ product of the factors, each to a power, by least squares of the logarithms."""
    columns = [np.log(np.asarray(each, float)) for each in factors]
    matrix = np.column_stack([*columns, np.ones(len(columns[0]))])
    return np.asarray(np.linalg.lstsq(matrix, np.log(np.asarray(y, float)), rcond=None)[0][:-1])


def largest_step(values: Sequence[float]) -> float:
    """Return the largest ratio of a value to the one before it: below 1 if and only if the values fall throughout."""
    return max(second / first for first, second in pairwise(values))


def smallest_step(values: Sequence[float]) -> float:
    """Return the smallest ratio of a value to the one before it: above 1 if and only if the values rise throughout."""
    return min(second / first for first, second in pairwise(values))
