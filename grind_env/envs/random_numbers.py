"""Random numbers of an episode, drawn for many blocks at once in vector registers.

Each number is a function of the key of the episode, of its purpose, and of a counter.
"""

from typing import Any, NamedTuple

import numpy as np

from grind_env.belief.filter_quantities import CUT
from grind_env.envs.distribution_splits import RANGES
from grind_env.kernel import entry, exp, inlined
from grind_env.kernel.random import Words, normal, philox, uniform
from grind_env.kernel.row_accessors import lane_reader, lane_writer

#: purposes of random numbers, each with four words for a counter: episode (wheel; coolant and start; spare wheel),
#: order by its first block, due date, part by its first block, block (pre-gauge, roughness of the part, mean and first
#: power), block again (peak power, size, roughness and wheel), and taper of a part by its block
EPISODE, ORDER, DATE, PART, GAUGES, READINGS, _, TAPER = range(8)


WORDS = 2.0**32  #: number of possible words


@inlined
def unless(fixed: float, drawn: float) -> float:
    """Return the fixed number, or the drawn number if none is fixed (NaN)."""
    return drawn if np.isnan(fixed) else fixed


@inlined
def key_of(u_0: float, u_1: float) -> tuple[float, float]:
    """Return the key that is made from two uniform numbers."""
    return np.floor(u_0 * WORDS), np.floor(u_1 * WORDS)


@inlined
def words_of(key_0: float, key_1: float, what: int, number: int) -> Words:
    """Return four random words of the episode with this key, for a purpose `what` and its counter `number`."""
    return philox(int(key_0), int(key_1), int(number), what, 0, 0)


@inlined
def within(u: float, ranges: float) -> float:
    """Return a uniform number mapped to the ranges of a split, in their order; `ranges` as `bits` in `Draws`."""
    bits = int(ranges)
    if bits == 0:
        return u
    count = 0
    for k in range(RANGES):
        count += bits >> k & 1
    left = u * count
    for k in range(RANGES):
        if bits >> k & 1:
            if left < 1.0:
                return (k + left) / RANGES
            left -= 1.0
    return u


@inlined
def log_normal(sigma: float, z: float) -> float:
    """Return the log-normal factor of a standard normal number, which is cut at `CUT`."""
    return exp(sigma * min(max(z, -CUT), CUT)) if sigma != 0.0 else 1.0


@inlined
def factor(sigma: float, word: float, ranges: float) -> float:
    """Return a log-normal factor from the ranges of a split; its standard normal number is cut at `CUT`."""
    return log_normal(sigma, normal(within(uniform(word), ranges)))


@inlined
def spread(sigma: float, z: float) -> float:
    """Return a normal number with standard deviation `sigma`, from a standard normal number."""
    return sigma * z if sigma > 0.0 else 0.0


class Drawn(NamedTuple):
    """Random numbers of a block: three random words, and from `stock` on standard normal numbers."""

    lot: float  #: word that decides whether a part begins a lot
    kA: float  #: word for a factor of the lot, like `pm`
    pm: float
    stock: float
    gauge: float
    part_ra: float
    mean: float
    first: float
    peak: float
    size: float
    roughness: float
    wheel: float


class Block(NamedTuple):
    """A block that is drawn: episode, key of the episode, number, and number by which its part is drawn."""

    episode: float
    key_0: float
    key_1: float
    number: float
    part: float


LANES = 8  #: number of blocks that are drawn side by side
read_block, write_block = lane_reader(Block, 0, LANES), lane_writer(Block, 0, LANES)
DRAWN_FROM = len(Block._fields)
read_drawn, write_drawn = lane_reader(Drawn, DRAWN_FROM, LANES), lane_writer(Drawn, DRAWN_FROM, LANES)
FIRST_NORMAL = (DRAWN_FROM + Drawn._fields.index("stock")) * LANES
LANES_SIZE = (DRAWN_FROM + len(Drawn._fields)) * LANES


@entry
def draw_lanes(lanes: Any) -> None:
    """Draw the random numbers of `LANES` blocks.

    Args:
        lanes: shape (LANES_SIZE,): the fields of `Block`, each for all lanes, followed by the fields of `Drawn`, which
            are written.
    """
    for lane in range(LANES):
        _, key_0, key_1, number, part = read_block(lanes, lane)
        lot, kA, pm, stock = words_of(key_0, key_1, PART, part)
        gauge, part_ra, mean, first = words_of(key_0, key_1, GAUGES, number)
        if part != number:
            gauge, part_ra, _, _ = words_of(key_0, key_1, GAUGES, part)
        peak, size, roughness, wheel = words_of(key_0, key_1, READINGS, number)
        drawn = Drawn(lot, kA, pm, stock, gauge, part_ra, mean, first, peak, size, roughness, wheel)
        write_drawn(lanes, lane, drawn)
    for k in range(FIRST_NORMAL, LANES_SIZE):
        lanes[k] = normal(uniform(lanes[k]))
