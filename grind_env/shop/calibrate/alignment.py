"""Where the runs of a program lie in a log, and which of them are there as they are programmed."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grind_env.shop.calibrate.pattern import Pattern
from grind_env.shop.measurements.sheet import Floats

SAME_FEED = 1.04
"""An override by which a machine may differ from its model without one."""
ENOUGH_PARTS, MOST_PARTS = 3, 0.75
"""From which on, and share of them, a feed that they have in common is no override."""
MATCHES = 0.5
"""Correlation from which on a run or a part is taken to be in the log."""
ALIKE_RUNS = 4.0
"""Factor by which the power of a run over that expected may differ from that of the others."""
ODD, POOR = 3.0, 0.8
"""Times what the others miss by, and correlation, from and up to which a run is not as it is programmed."""


@dataclass(frozen=True, slots=True)
class Alignment:
    """Where the runs of a program lie in a log; arrays have shape (executions, runs)."""

    begin: Floats  # of each run, s of the log
    override: Floats  # of the feed in it
    correlation: Floats  # of the power expected in it with that of the log; NaN if the log has no samples there
    gain: Floats  # of the power in the log over that expected
    rest: Floats  # standard deviation of the power in the log from what is expected, in its unit
    time_unit: float = 1.0  # s of a unit of the log's time; 1 unless it was found out

    @property
    def executions(self) -> int:
        """How often the program was run."""
        return len(self.begin)

    @property
    def known(self) -> "Alignment":
        """That of the executions of which a run is sure; other work may look like one from afar."""
        names, known = ("begin", "override", "correlation", "gain", "rest"), self.sure.any(axis=1)
        return replace(self, **{name: getattr(self, name)[known] for name in names})

    @property
    def quality(self) -> float:
        """Median of the correlations, from 0 to 1."""
        return float(np.nanmedian(self.correlation)) if np.isfinite(self.correlation).any() else 0.0

    @property
    def sure(self) -> NDArray[np.bool_]:
        """Which runs are in the log as they are programmed: as strong as the others, and no worse than they."""
        sure: NDArray[np.bool_] = self.correlation >= MATCHES
        if sure.any():
            sure = sure & between(self.gain, float(np.median(self.gain[sure])), ALIKE_RUNS)
        if sure.any():
            sure = sure & ((self.correlation >= POOR) | (self.rest <= ODD * np.median(self.rest[sure])))
        return sure

    def overrides(self, pattern: Pattern) -> list[float]:
        """Of each part; 1 where the feed is as programmed but for what the machine differs from its model.

        What all parts are ground with is how the machine runs this program, and no override.
        """
        usual = self.usual_override(pattern)
        found = [value / usual for value in self._medians(pattern)]
        return [1.0 if abs(np.log(value)) < np.log(SAME_FEED) else value for value in found]

    def usual_override(self, pattern: Pattern) -> float:
        """The one of most parts, where there are enough, else 1."""
        found = np.array(self._medians(pattern))
        usual = float(np.median(found))
        alike = np.mean(np.abs(np.log(found / usual)) < np.log(SAME_FEED)) >= MOST_PARTS
        return usual if found.size >= ENOUGH_PARTS and alike else 1.0

    def _medians(self, pattern: Pattern) -> list[float]:
        part = pattern.part[pattern.firsts]
        each = [(row, part == number) for row in range(self.executions) for number in range(pattern.parts)]
        found = [self.override[row, chosen & self.sure[row]] for row, chosen in each]
        return [float(np.median(values)) if values.size else 1.0 for values in found]


def between(values: Floats, usual: float, factor: float) -> NDArray[np.bool_]:
    """Which values are within a factor of a usual one."""
    return (values > usual / factor) & (values < usual * factor)
