"""Depth reached at every place of a part that strokes do not pass in full length."""

import math

import numpy as np

from grind_env.machine.loops.strip_stroke import Strips

#: largest length of a cell, mm. A stroke reaches the cells whose middle it passes, so that a table may turn at the very
#: edge of the part
CELL = 1.0


class Coverage:
    """The deepest stroke over each cell of each strip of a part.

    The process model has one depth along the length of a strip. A place where no stroke was so deep is not ground to
    that depth.
    """

    def __init__(self, start: float, length: float, strips: int) -> None:
        self._cells = math.ceil(length / CELL)
        self._start, self._cell = start, length / self._cells
        self._whole = np.zeros(strips)  # depth by strokes over the whole length, mm
        self._short: dict[tuple[int, int, int, int], float] = {}
        self._known: Strips | None = None

    def is_full_length(self, ends: tuple[float, float]) -> bool:
        low, high = self._passed(ends)
        return high - low == self._cells

    def written(self) -> Strips:
        self._known = None
        return self._whole

    def add(self, first: int, last: int, ends: tuple[float, float], Z: float) -> None:
        """Add a stroke at depth `Z`, mm, over strips `first` to `last - 1` between reversal points within the part."""
        low, high = self._passed(ends)
        if low < high:
            place = first, last, low, high
            self._known = None
            self._short[place] = max(self._short.get(place, 0.0), Z)

    def least(self) -> Strips:
        """Return the least depth reached in each strip, mm; infinite for a strip with one depth everywhere."""
        depths = self._depths()
        least: Strips = np.where(np.ptp(depths, axis=1) > 0.0, depths.min(axis=1), np.inf)
        return least

    def least_between(self, first: int, last: int, ends: tuple[float, float]) -> float:
        """Return the least depth reached in the strips `first` to `last - 1` between two coordinates along them, mm.

        Between the middles of two cells the deeper cell counts, because a stroke may have turned there.
        """
        depths = self._depths()[first:last]
        if not self._short:
            return float(depths.min())
        low, high = self._passed(ends)
        if low < high:
            return float(depths[:, low:high].min())
        return float(depths[:, max(low - 1, 0) : low + 1].max(axis=1).min())

    @property
    def unground(self) -> float:
        """Return the share of the surface that no stroke has reached, from 0 to 1."""
        depths = self._depths()
        return float(np.count_nonzero(depths <= 0.0) / depths.size)

    def _passed(self, ends: tuple[float, float]) -> tuple[int, int]:
        low = max(math.ceil((min(ends) - self._start) / self._cell - 0.5), 0)
        return low, min(math.floor((max(ends) - self._start) / self._cell + 0.5), self._cells)

    def _depths(self) -> Strips:
        """Return the depths of the cells, mm, shape (strips, cells); one cell if all strokes pass the whole length."""
        if not self._short:
            return self._whole[:, None]
        if self._known is None:
            self._known = np.repeat(self._whole[:, None], self._cells, axis=1)
            for (first, last, low, high), Z in self._short.items():
                np.maximum(self._known[first:last, low:high], Z, out=self._known[first:last, low:high])
        return self._known
