"""What a planner, a belief or an adviser needs of a problem beside its contract: blocks taken one by one, and prices.

`Episodes` has what is the same in every form: copies, windows of their tapes, and the coming blocks.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np

from grind_env.arrays import Numbers, Table
from grind_env.envs.episodes import Episodes
from grind_env.envs.transition import KIND, MATERIAL, STOCK


class Branches(ABC):
    """The blocks of a problem, which a branch may try one by one."""

    base: Table
    """Nominal stroke parameters, shape (any, fields of `StrokeParameters`): a row for each of the kinds, or for all."""
    nominal: Table
    """Nominal stroke parameters of each kind, shape (kinds, fields of `StrokeParameters`)."""
    kind_of_row: Numbers
    """Number of the kind that each row of `Simulation.kinds` is of."""
    dress_price: float
    """Price of a dress execution, $; 0 without a dress program."""
    usual_dress: tuple[float, float]
    """Traverse feed of the diamond, mm/s, and depth of a pass, mm, with which a new wheel is dressed."""
    change_seconds: float
    """What a wheel change takes, s."""
    second_price: float
    """Of the machine, $/s."""
    own_speeds: Table | None
    """E that a program says in blocks of each kind, mm/min, shape (kinds,); None where nothing is said."""

    materials: int = 1
    """Rows of a kind, one for each material."""

    @abstractmethod
    def seconds(self, rows: Numbers, speeds: Table) -> Table:
        """Nominal time of blocks of these rows at E in mm/min without a dress, s; all of shape (N,)."""

    @abstractmethod
    def coming_rows(self, seen: Mapping[str, Table]) -> Numbers:
        """Row in `Simulation.kinds` of the coming block, from what was read; shape (N,)."""

    @abstractmethod
    def part_from(self, block: int) -> range:
        """A block of the nominal sequence and those after it up to the end of its part."""

    @abstractmethod
    def lengthened(self, episodes: Episodes, blocks: range) -> Episodes:
        """Episodes of one block with the further ones of the nominal sequence, as the number of each block has it."""

    @abstractmethod
    def first_wheels(self, count: int) -> Table:
        """Wheels with which an episode may begin, evenly over what is drawn, shape (count, fields of `WheelState`)."""

    @abstractmethod
    def stocks(self, rows: Numbers, ratios: Table) -> Table:
        """Stock of blocks of these rows, mm, from that over the nominal one; all of shape (N,)."""

    def rows_of(self, tape: Table) -> Numbers:
        """Row in `Simulation.kinds` of the blocks on a tape, shape (..., fields of `TapeRow`)."""
        return np.asarray(tape[..., KIND] * self.materials + tape[..., MATERIAL]).astype(np.int64)

    def load(self, episodes: Episodes, index: Numbers, rows: Numbers, stocks: Table) -> None:
        """Give episodes of one block, at `index`, one of a row in `kinds`, with its stock over the nominal one.

        All three are of shape (M,).
        """
        episodes.block[index] = 0
        episodes.tape[index, 0, KIND], episodes.tape[index, 0, MATERIAL] = np.divmod(rows, self.materials)
        episodes.tape[index, 0, STOCK] = self.stocks(rows, stocks)


def coming_kinds(branches: Branches, seen: Mapping[str, Table]) -> Numbers:
    """Number of the kind of the coming block, from what was read; shape (N,)."""
    return branches.kind_of_row[branches.coming_rows(seen)]
