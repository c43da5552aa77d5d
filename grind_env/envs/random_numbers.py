"""Random numbers of an episode, drawn for many blocks at once in vector registers.

Each number is a function of the key of the episode, of its purpose, and of a counter.
"""

from typing import Any, NamedTuple

import numpy as np

from grind_env.belief.hidden import CUT
from grind_env.envs.splits import RANGES
from grind_env.kernel import entry, exp, inlined
from grind_env.kernel.columns import lane_reader, lane_writer
from grind_env.kernel.random import Words, normal, philox, uniform

EPISODE, ORDER, DATE, PART, GAUGES, READINGS, _, TAPER = range(8)
"""What is drawn, four words a number: of the episode (the wheel; coolant and start; the spare wheel), of an order by
its first block, of a due date, of a part by its first block, of a block (the pre-gauge, the part's roughness, mean and
first power; then peak power, size, roughness and wheel), and of a part by its number."""


WORDS = 2.0**32
"""How many words there are."""


@inlined
def unless(fixed: float, drawn: float) -> float:
    """The fixed number, or the drawn one where none is fixed (NaN)."""
    return drawn if np.isnan(fixed) else fixed


@inlined
def key_of(u_0: float, u_1: float) -> tuple[float, float]:
    """The key that two uniform numbers make."""
    return np.floor(u_0 * WORDS), np.floor(u_1 * WORDS)


@inlined
def words_of(key_0: float, key_1: float, what: int, number: int) -> Words:
    """The random words of the episode with this key for what is drawn, and for its number."""
    return philox(int(key_0), int(key_1), int(number), what, 0, 0)


@inlined
def within(u: float, ranges: float) -> float:
    """A uniform number moved into the ranges of a split, in their order, by probability; `ranges` as in `Draws`."""
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
    """Log-normal factor of a standard normal number, which is cut at `CUT`."""
    return exp(sigma * min(max(z, -CUT), CUT)) if sigma != 0.0 else 1.0


@inlined
def factor(sigma: float, word: float, ranges: float) -> float:
    """Log-normal factor, from the ranges of a split, whose standard normal number is cut at `CUT`."""
    return log_normal(sigma, normal(within(uniform(word), ranges)))


@inlined
def deviation(sigma: float, word: float) -> float:
    """Normal number of that standard deviation."""
    return spread(sigma, normal(uniform(word)))


@inlined
def spread(sigma: float, z: float) -> float:
    """Normal number of that standard deviation, of a standard normal one."""
    return sigma * z if sigma > 0.0 else 0.0


class Drawn(NamedTuple):
    """Random numbers of a block: raw words unless stated otherwise, or standard normal numbers."""

    lot: float
    """Word that says whether a part begins a lot."""
    kA: float
    """Word of the lot, like the next one."""
    pm: float
    stock: float
    """Standard normal, as all behind it."""
    gauge: float
    part_ra: float
    mean: float
    first: float
    peak: float
    size: float
    roughness: float
    wheel: float


class Block(NamedTuple):
    """A block that is drawn: its episode, the key of that, its number, and that by which its part is drawn."""

    episode: float
    key_0: float
    key_1: float
    number: float
    part: float


LANES = 8
"""Blocks that are drawn side by side."""
read_block, write_block = lane_reader(Block, 0, LANES), lane_writer(Block, 0, LANES)
DRAWN_FROM = len(Block._fields)
read_drawn, write_drawn = lane_reader(Drawn, DRAWN_FROM, LANES), lane_writer(Drawn, DRAWN_FROM, LANES)
FIRST_NORMAL = (DRAWN_FROM + Drawn._fields.index("stock")) * LANES
LANES_SIZE = (DRAWN_FROM + len(Drawn._fields)) * LANES


@entry
def draw_lanes(lanes: Any) -> None:
    """Draw what there is of `LANES` blocks.

    Args:
        lanes: shape (LANES_SIZE,): the fields of `Block`, each of all lanes, and behind them those of `Drawn`, which
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
