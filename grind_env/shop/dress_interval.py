"""The dress interval of a program: in every n-th part, run, or dressing block."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LONGEST = 20  #: longest interval of a search by default, parts


@dataclass(frozen=True, slots=True)
class DressInterval:
    """Dress interval: the wheel is dressed in run n, 2 n, 3 n, … of a program, or at every n-th dressing block."""

    every: int  #: n
    # unit of the interval: "part" or "run" for runs that grind one or several parts, "block" for dressing blocks
    of: str = "part"

    def due(self, dressing: NDArray[np.bool_], run: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return which `dressing` blocks dress; `run` is the run of each, from 0; shape (blocks,)."""
        number = dressing.cumsum() if self.of == "block" else run + 1
        return np.asarray(dressing & (number % self.every == 0))

    @staticmethod
    def counting(parts: int) -> str:
        """Return the unit of an interval of runs that grind this number of parts each: "part" or "run"."""
        return "part" if parts == 1 else "run"

    def __str__(self) -> str:
        return f"every {self.of}" if self.every == 1 else f"every {self.every} {self.of}s"


def intervals_between(low: int, high: int, *, blocks: int = 1, parts: int = 1) -> tuple[DressInterval, ...]:
    """Return the intervals from `low` to `high` runs, and the intervals in blocks between them; most dresses first."""
    runs = [DressInterval(every, DressInterval.counting(parts)) for every in range(low, high + 1)]
    some = {*range(2, LONGEST + 1), *range(blocks, high * blocks + 1, blocks)} if blocks > 1 else ()
    least = 1 if low == 1 else low * blocks
    counted = [DressInterval(every, "block") for every in some if least <= every <= high * blocks]
    # first the interval of the unchanged program: every dressing block dresses in every run
    return tuple(
        sorted([*runs, *counted], key=lambda each: (each.every > 1, each.every / (blocks if each.of == "block" else 1)))
    )
