"""The dress interval of a program: in every n-th part, run, or dressing block."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LONGEST = 20
"""Parts from dress to dress up to which is looked where the user does not say it."""


@dataclass(frozen=True, slots=True)
class DressInterval:
    """The wheel is dressed in the n-th run of a program, in the 2 n-th, and so on; or so by blocks instead of runs."""

    every: int  # n
    # what is counted: "part" or "run" for runs of the program, as one of them grinds one part or several, or "block"
    # for the blocks that dress
    of: str = "part"

    def due(self, dressing: NDArray[np.bool_], run: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which `dressing` blocks dress; `run` is the run of each, from 0; shape (blocks,)."""
        number = dressing.cumsum() if self.of == "block" else run + 1
        return np.asarray(dressing & (number % self.every == 0))

    @staticmethod
    def counting(parts: int) -> str:
        """Return the word for runs that grind so many parts each."""
        return "part" if parts == 1 else "run"

    def __str__(self) -> str:
        return f"every {self.of}" if self.every == 1 else f"every {self.every} {self.of}s"


def intervals_between(low: int, high: int, *, blocks: int = 1, parts: int = 1) -> tuple[DressInterval, ...]:
    """Return intervals from `low` to `high` runs, and what blocks can be counted in between, densest first."""
    runs = [DressInterval(every, DressInterval.counting(parts)) for every in range(low, high + 1)]
    some = {*range(2, LONGEST + 1), *range(blocks, high * blocks + 1, blocks)} if blocks > 1 else ()
    counted = [DressInterval(every, "block") for every in sorted(some) if low == 1 or low * blocks <= every]
    within = [each for each in counted if each.every <= high * blocks]
    # first that of the program as it is, in which every block that dresses does so in every run
    return tuple(
        sorted([*runs, *within], key=lambda each: (each.every > 1, each.every / (blocks if each.of == "block" else 1)))
    )
