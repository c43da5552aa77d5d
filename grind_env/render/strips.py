"""What the strip charts show: the values of the blocks of an episode, with their limits."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from grind_env.render.view import EpisodePicture

HEADROOM = 1.12
"""Upper edge of a strip over the limit that it shows."""


class Strip(NamedTuple):
    """One strip chart."""

    name: str
    unit: str
    form: str
    """Format of a value."""
    values: Sequence[float]
    limits: Sequence[float]
    """Of each value; 0 for none."""
    bottom: float
    """Value of the lower edge; if it is above 0, the scale is logarithmic."""
    top: float
    """Value of the upper edge."""

    def height(self, value: float) -> float:
        """How high a value stands in the strip, from 0 at the lower to 1 at the upper edge."""
        if self.bottom > 0.0:
            return math.log(value / self.bottom) / math.log(self.top / self.bottom)
        return value / self.top

    def beyond(self, k: int) -> bool:
        """Whether value k has passed its limit."""
        return 0.0 < self.limits[k] < self.values[k]

    @property
    def latest(self) -> str:
        """The last value and its limit, without the unit; empty if there is none."""
        if not self.values:
            return ""
        limit = self.limits[-1]
        return self.form.format(self.values[-1]) + (f" of {self.form.format(limit)}" if limit > 0.0 else "")


def strips_of(view: EpisodePicture) -> tuple[Strip, ...]:
    """Power, temperature and Ra of the blocks ground so far, and table speed, that of a running one as well."""
    ground, extent = view.ground, view.extent
    # the E of a block is chosen before it runs, and its caption names it
    speeds = [block.speed for block in ground] + ([view.instant.speed] if view.instant else [])
    low, high = 0.001 * extent.lowest_speed, 0.001 * extent.highest_speed
    return (
        _measured(
            "power",
            "kW",
            "{:.2f}",
            [0.001 * block.power for block in ground],
            [0.001 * block.limits.power for block in ground],
        ),
        _measured(
            "temperature rise", "K", "{:.0f}", [block.rise for block in ground], [block.limits.rise for block in ground]
        ),
        _measured(
            "Ra",
            "µm",
            "{:.2f}",
            [block.roughness for block in ground],
            [block.limits.roughness for block in ground],
        ),
        Strip(
            "table speed E",
            "m/min",
            "{:.1f}",
            [0.001 * speed for speed in speeds],
            [0.0] * len(speeds),
            low if low < high else 0.0,
            high,
        ),
    )


def _measured(name: str, unit: str, form: str, values: Sequence[float], limits: Sequence[float]) -> Strip:
    """A strip from 0 to a little above its highest value or limit."""
    highest = HEADROOM * max((*values, *limits), default=1.0)
    return Strip(name, unit, form, values, limits, 0.0, highest)
