"""Random numbers for events in a shift, from its seed and the block number."""

from grind_env.kernel import inlined
from grind_env.kernel.random import Words, normal, philox, uniform
from grind_env.process.process_interface import Moment


@inlined
def words_of(seed: float, moment: Moment) -> Words:
    """Return four random 32-bit words for the block that is about to begin."""
    return philox(int(seed), 0, int(moment.number), 0, 0, 0)


@inlined
def deviate(word: int) -> float:
    """Return a standard normal number from a random 32-bit word."""
    return normal(uniform(word))
