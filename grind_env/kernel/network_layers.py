"""Layers of a network: a row gives the same bits on every machine and beside any other rows.

The order of the sums in a BLAS matrix product depends on the processor and on the number of rows. Here every sum runs
over the inputs in their order, in double precision. Tanh and the logistic function use the exp of this package.
"""

import numpy as np
from numpy.typing import NDArray

from grind_env.kernel.exp_log import logistic, tanh
from grind_env.kernel.jit_decorators import entry

Numbers = NDArray[np.float64]


@entry
def linear(values: Numbers, weights: Numbers, bias: Numbers) -> Numbers:
    """Return the outputs of a linear layer for N rows, shape (N, outputs).

    Args:
        values: shape (N, inputs), C-contiguous like the others.
        weights: shape (inputs, outputs).
        bias: shape (outputs,).
    """
    sums = np.empty((len(values), len(bias)))
    for i in range(len(values)):
        # explicit loops, because the product of a number and a row would allocate an array
        for j in range(len(bias)):
            sums[i, j] = bias[j]
        for k in range(len(weights)):
            for j in range(len(bias)):
                sums[i, j] += values[i, k] * weights[k, j]
    return sums


@entry
def tanh_layer(values: Numbers) -> Numbers:
    """Return the hyperbolic tangent of every number, shape (N, units)."""
    result = np.empty_like(values)
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            result[i, j] = tanh(values[i, j])
    return result


@entry
def logistic_layer(values: Numbers) -> Numbers:
    """Return 1 / (1 + e**-x) of every number, shape (N, units)."""
    result = np.empty_like(values)
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            result[i, j] = logistic(values[i, j])
    return result
