"""How often a program dresses: in every n-th of its runs, or in every n-th of the blocks that dress."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LONGEST = 20
"""Parts from dress to dress up to which is looked where the user does not say it."""


@dataclass(frozen=True, slots=True)
class DressInterval:
    """The wheel is dressed in the n-th run of a program, in the 2 n-th, and so on; or so by blocks instead of runs.

    Attributes:
        every: n.
        of_blocks: whether blocks are counted, those that dress alone.
    """

    every: int
    of_blocks: bool = False

    def due(self, dressing: NDArray[np.bool_], runs: int) -> NDArray[np.bool_]:
        """Blocks in which dresses are executed.

        Args:
            dressing: which blocks of one run have dresses, shape (blocks,).
            runs: how often the program is run.

        Returns:
            Shape (runs, blocks).
        """
        every_run = np.tile(dressing, (runs, 1))
        number = every_run.cumsum().reshape(every_run.shape) if self.of_blocks else np.arange(1, runs + 1)[:, None]
        return np.asarray(every_run & (number % self.every == 0))

    def __str__(self) -> str:
        what = "block" if self.of_blocks else "part"
        return f"every {what}" if self.every == 1 else f"every {self.every} {what}s"


EVERY_PART = DressInterval(1)


def intervals_between(low: int, high: int, blocks: int = 1) -> tuple[DressInterval, ...]:
    """Intervals from one number of parts to another, the densest first.

    Args:
        low: parts.
        high: parts.
        blocks: that dress in one run; where there are several, their intervals of up to two parts are among them.
    """
    parts = [DressInterval(every) for every in range(low, high + 1)]
    counted = [DressInterval(every, of_blocks=True) for every in range(2, 2 * blocks) if every != blocks]
    within = [each for each in counted if low <= each.every / blocks <= high or (low == 1 and each.every < blocks)]
    return tuple(sorted([*parts, *within], key=lambda each: each.every / (blocks if each.of_blocks else 1)))
