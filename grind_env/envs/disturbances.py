"""Random disturbances: the noise tape of each episode, drawn from its key, for tasks and part programs."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Table
from grind_env.envs.distribution_splits import Draws, draws_of
from grind_env.envs.episode_state import Episodes
from grind_env.envs.noise_tape import (
    DrawnKind,
    Origin,
    Sigmas,
    draw_rows,
    origin_of,
    read_origin,
    read_sigmas,
    write_origin,
)
from grind_env.envs.random_numbers import ORDER, words_of
from grind_env.envs.reset_options import Fixed, Given, distinct
from grind_env.envs.tasks.unseen_entries import OtherWheel
from grind_env.kernel import entry, inlined
from grind_env.kernel.random import uniform
from grind_env.kernel.row_accessors import column_reader

DEALT = -1  #: number in place of a kind for a block whose kind the random orders decide

read_fixed, read_draws = column_reader(Fixed), column_reader(Draws)


@inlined
def write_schedule(schedule: Any, i: int, sequence: Any, count: int, most_parts: int, origin: Origin) -> None:
    """Write the kinds of the blocks of episode i: those of a sequence, or orders with 1 to `most_parts` parts each."""
    before, left = DEALT, 0
    for k in range(sequence.size):
        kind = int(sequence[k])
        begins = k == 0 or (most_parts > 0 and kind != before)
        if kind == DEALT:
            begins = left == 0
            kind = before
            if begins:
                kind_word, size_word, _, _ = words_of(origin.key_0, origin.key_1, ORDER, k)
                kind, left = int(uniform(kind_word) * count), 1 + int(uniform(size_word) * most_parts)
            left -= 1
        schedule[i, k] = 2 * kind + (1 if begins else 0)
        before = kind


@entry
def begin_episodes(
    tape: Any,
    block: Any,
    source: Any,
    schedule: Any,
    index: Any,
    keys: Any,
    which: Any,
    fixed: Any,
    splits: Any,
    sequences: Any,
    kinds: Any,
    spreads: Any,
    materials: Any,
    other_wheels: Any,
    most_parts: int,
) -> None:
    """Write the origins and first rows of M episodes into the rows `index`; arguments not named are as for `draw_rows`.

    `keys` has two uniform numbers for each episode, shape (M, 2). `which`, shape (M,), is the row of each episode in
    three tables: `fixed` with the numbers of the context, `splits` with the `Draws` of the split, and `sequences` with
    the kinds of the blocks, shape (any, blocks), `DEALT` where random orders decide. `materials` and `other_wheels` are
    as for `origin_of`; an order has at most `most_parts` parts, 0 without orders.
    """
    sigmas = read_sigmas(spreads, 0)
    for j in range(index.size):
        i, given, split = index[j], read_fixed(fixed, which[j]), read_draws(splits, which[j])
        u_0, u_1, blocks = keys[j, 0], keys[j, 1], schedule.shape[1]
        write_origin(source, i, origin_of(u_0, u_1, blocks, given, split, sigmas, materials, other_wheels))
        write_schedule(schedule, i, sequences[which[j]], kinds.shape[0], most_parts, read_origin(source, i))
        block[i] = 0
    draw_rows(tape, block, source, schedule, kinds, spreads, index)


class Disturbances(ABC):
    """Generator of the random numbers of episodes."""

    most_parts = 0  # most parts of an order; 0 without orders
    # for a foreign split: index of each material, shape (any,); wheels, shape (any, fields of `OtherWheel`)
    materials, wheels = np.empty(0), np.empty((0, len(OtherWheel._fields)))

    def __init__(self, kinds: Sequence[DrawnKind], spreads: Sigmas, sequence: Sequence[int]) -> None:
        # shape (kinds, fields of `DrawnKind`); (1, fields of `Sigmas`); kind of each block, `DEALT` if orders decide
        self.kinds, self.spreads, self.sequence = np.array(kinds), np.array([spreads]), sequence

    def begin(
        self, episodes: Episodes, index: NDArray[np.int64], rngs: Sequence[np.random.Generator], given: Sequence[Given]
    ) -> None:
        """Begin an episode with a key from each of M generators; each generator always draws two numbers.

        Args:
            episodes: tape, source, schedule and first wheel are written in the rows `index`.
            index: rows of the new episodes, shape (M,).
            rngs: generator of each episode.
            given: fixed part of each episode.
        """
        each, which = distinct(given)
        fixed, splits = np.array([one.fixed for one in each]), np.array([self.draws(one) for one in each])
        begin_episodes(
            episodes.tape,
            episodes.block,
            episodes.source,
            episodes.schedule,
            index,
            np.array([(rng.random(), rng.random()) for rng in rngs]),
            which,
            fixed,
            splits,
            np.array([self.sequence if one.kinds is None else one.kinds for one in each]),
            self.kinds,
            self.spreads,
            self.materials,
            self.wheels,
            self.most_parts,
        )
        self.mount(episodes, index, which, fixed)

    def draws(self, given: Given) -> Draws:
        """Return the distributions that a split draws from."""
        return draws_of(given.split)

    @abstractmethod
    def mount(self, episodes: Episodes, index: NDArray[np.int64], which: NDArray[np.int64], fixed: Table) -> None:
        """Write the first wheels of the episodes at `index`; the other arguments are as for `begin_episodes`."""

    def draw(self, episodes: Episodes) -> None:
        """Draw the rows that the tapes have room for."""
        everyone = np.arange(len(episodes.block))
        drawn_from = episodes.source, episodes.schedule, self.kinds, self.spreads
        draw_rows(episodes.tape, episodes.block, *drawn_from, everyone)
