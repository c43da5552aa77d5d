"""Exponential and logarithm that vectorise and give the same bits on every machine.

`math.exp` calls the C library, whose last digit differs between systems and which LLVM cannot vectorise.
The functions here are polynomials after a range reduction, without branches. The polynomials interpolate at Chebyshev
nodes, with an error below 2e-17. Compared with mpmath the relative error is below 4e-16 (tests/test_elementary.py).
"""

import math
import struct
from typing import Any

from numba import types
from numba.extending import intrinsic, overload

from grind_env.kernel.jit_decorators import inlined

LN2_HIGH = 6.93147180369123816490e-01  # ln 2 in two parts: the first has 21 trailing zero bits,
LN2_LOW = 1.90821492927058770002e-10  # so that its product with an exponent is exact
LOG2_E = 1.0 / math.log(2.0)
ROUND = 1.5 * 2.0**52  # adding it rounds to an integer, which then stands in the low bits
ROUND_BITS = struct.unpack("<q", struct.pack("<d", ROUND))[0]
SQRT_HALF_BITS = struct.unpack("<q", struct.pack("<d", math.sqrt(0.5)))[0]
EXP_0, EXP_1, EXP_2, EXP_3, EXP_4 = (
    0.5,
    0.16666666666666669,
    0.041666666666624164,
    0.008333333333330065,
    0.00138888889171967,
)
EXP_5, EXP_6, EXP_7 = 0.00019841269863040545, 2.4801521322368692e-05, 2.7557268480310024e-06
#: coefficients of (e^r - 1 - r)/r^2 in powers of r, for |r| up to ln 2/2
EXP_8, EXP_9 = 2.7620075879983367e-07, 2.5100375832561234e-08
LOG_0, LOG_1, LOG_2, LOG_3 = 0.666666666666667, 0.39999999999899505, 0.28571428625975487, 0.2222221113479508
#: coefficients of (2 atanh(s)/s - 2)/s^2 in powers of s^2, for 1/sqrt(2) <= (1 + s)/(1 - s) < sqrt(2)
LOG_4, LOG_5, LOG_6 = 0.18182889125261723, 0.15331721600556042, 0.14616449685043406


def bits_of(x: float) -> int:
    """Return the 64 bits of a float as a signed integer."""
    return int(struct.unpack("<q", struct.pack("<d", x))[0])


def float_of(bits: int) -> float:
    """Return the float whose 64 bits are `bits`."""
    return float(struct.unpack("<d", struct.pack("<q", bits))[0])


def _bitcast(source: Any, target: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], context.get_value_type(signature.return_type))

    return intrinsic(lambda typingctx, value: (target(source), codegen))


_bits_of = _bitcast(types.float64, types.int64)
_float_of = _bitcast(types.int64, types.float64)

# numba requires that overload and implementation have the same signature, so both are lambdas
overload(bits_of, inline="always")(lambda x: lambda x: _bits_of(x))
overload(float_of, inline="always")(lambda bits: lambda bits: _float_of(bits))


@inlined
def exp(x: float) -> float:
    """Return e**x; x is limited to -700 to 700, so that the result is a normal number."""
    x = min(max(x, -700.0), 700.0)
    shifted = x * LOG2_E + ROUND
    k = shifted - ROUND
    r = (x - k * LN2_HIGH) - k * LN2_LOW
    # paired (Estrin) so that the terms are computed side by side
    r2 = r * r
    r4 = r2 * r2
    low = (1.0 + r) + r2 * (EXP_0 + r * EXP_1)
    middle = (EXP_2 + r * EXP_3) + r2 * (EXP_4 + r * EXP_5)
    high = (EXP_6 + r * EXP_7) + r2 * (EXP_8 + r * EXP_9)
    series = (low + r4 * middle) + (r4 * r4) * high
    power_of_two = float_of((bits_of(shifted) - ROUND_BITS + 1023) << 52)
    return series * power_of_two


@inlined
def log(x: float) -> float:
    """Return the natural logarithm of a positive, normal number."""
    bits = bits_of(x)
    exponent = (bits - SQRT_HALF_BITS) >> 52
    m = float_of(bits - (exponent << 52))  # in [sqrt(1/2), sqrt(2))
    # an integer below 2^51 added to the bits of ROUND is that integer added to the float ROUND
    k = float_of(ROUND_BITS + exponent) - ROUND
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    # 2 atanh(s) = 2 s (1 + z/3 + z^2/5 + ...), written as f - s (f - R) to keep the low digits of f
    z2 = z * z
    low = (LOG_0 + z * LOG_1) + z2 * (LOG_2 + z * LOG_3)
    high = (LOG_4 + z * LOG_5) + z2 * LOG_6
    series = z * (low + (z2 * z2) * high)
    return k * LN2_HIGH + (f - (s * (f - series) - k * LN2_LOW))


@inlined
def power(x: float, exponent: float) -> float:
    """Return x**exponent for positive x."""
    return exp(exponent * log(x))


@inlined
def logistic(x: float) -> float:
    """Return 1 / (1 + e**-x)."""
    return 1.0 / (1.0 + exp(-x))


@inlined
def tanh(x: float) -> float:
    """Return the hyperbolic tangent; the absolute error is below 4e-16, which is much of a result near 0."""
    return 2.0 * logistic(2.0 * x) - 1.0
