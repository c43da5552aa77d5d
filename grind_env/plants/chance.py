"""Random events of a shift, from its seed and the number of the block."""

from grind_env.kernel import inlined
from grind_env.kernel.random import Words, normal, philox, uniform
from grind_env.process.process import Moment


@inlined
def words_of(seed: float, moment: Moment) -> Words:
    """Random words of 32 bits before a block."""
    return philox(int(seed), 0, int(moment.number), 0, 0, 0)


@inlined
def deviate(word: int) -> float:
    """Standard normal number."""
    return normal(uniform(word))
