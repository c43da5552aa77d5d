"""Random numbers that are functions of a key and a counter, with the same bits on every machine.

Philox4x32-10 (Salmon et al. 2011, Parallel random numbers: as easy as 1, 2, 3): any number of any episode can be drawn
at any time, in any order, and alone. A word of 32 bits gives a uniform number. The inverse of the normal distribution,
AS241 (Wichura 1988), turns a uniform number into a normal one.
"""

import math
from typing import TypeAlias

from grind_env.kernel.exp_log import log
from grind_env.kernel.jit_decorators import inlined

Words: TypeAlias = tuple[int, int, int, int]  #: four words of 32 bits each

WORD = 0xFFFFFFFF
ROUNDS = 10
MULTIPLIER_0, MULTIPLIER_2 = 0xD2511F53, 0xCD9E8D57
WEYL_0, WEYL_1 = 0x9E3779B9, 0xBB67AE85
CENTRE = 0.425  #: largest distance from probability 1/2 at which the first rational function is used


@inlined
def philox(key_0: int, key_1: int, counter_0: int, counter_1: int, counter_2: int, counter_3: int) -> Words:
    """Return four random words (Philox4x32-10) from a key of two words and a counter of four words."""
    for _ in range(ROUNDS):
        # in compiled code the products overflow (signed), but their 64 bits are the same
        product_0, product_2 = MULTIPLIER_0 * counter_0, MULTIPLIER_2 * counter_2
        counter_0 = (product_2 >> 32) & WORD ^ counter_1 ^ key_0
        counter_2 = (product_0 >> 32) & WORD ^ counter_3 ^ key_1
        counter_1, counter_3 = product_2 & WORD, product_0 & WORD
        key_0, key_1 = (key_0 + WEYL_0) & WORD, (key_1 + WEYL_1) & WORD
    return counter_0, counter_1, counter_2, counter_3


@inlined
def uniform(word: float) -> float:
    """Return a number above 0 and below 1, one of a grid of step 2**-32."""
    return (word + 0.5) * 2.0**-32


@inlined
def normal(u: float) -> float:
    """Return the quantile of the standard normal distribution at `u`; within 6.4 of 0 for the numbers of `uniform`."""
    q = u - 0.5
    if abs(q) <= CENTRE:
        r = CENTRE * CENTRE - q * q
        above = 2509.0809287301226727 * r + 33430.575583588128105
        below = 5226.495278852854561 * r + 28729.085735721942674
        above, below = above * r + 67265.770927008700853, below * r + 39307.89580009271061
        above, below = above * r + 45921.953931549871457, below * r + 21213.794301586595867
        above, below = above * r + 13731.693765509461125, below * r + 5394.1960214247511077
        above, below = above * r + 1971.5909503065514427, below * r + 687.1870074920579083
        above, below = above * r + 133.14166789178437745, below * r + 42.313330701600911252
        above = q * (above * r + 3.387132872796366608)
    else:
        r = math.sqrt(-log(min(u, 1.0 - u))) - 1.6
        above = 7.7454501427834140764e-4 * r + 0.0227238449892691845833
        below = 1.05075007164441684324e-9 * r + 5.475938084995344946e-4
        above, below = above * r + 0.24178072517745061177, below * r + 0.0151986665636164571966
        above, below = above * r + 1.27045825245236838258, below * r + 0.14810397642748007459
        above, below = above * r + 3.64784832476320460504, below * r + 0.68976733498510000455
        above, below = above * r + 5.7694972214606914055, below * r + 1.6763848301838038494
        above, below = above * r + 4.6303378461565452959, below * r + 2.05319162663775882187
        above = above * r + 1.42343711074968357734
        above = above if q > 0.0 else -above
    return above / (below * r + 1.0)
