"""Data of the strip charts: the values of the blocks of an episode, with limits."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from grind_env.render.picture_data import EpisodePicture

HEADROOM = 1.12  #: ratio of the upper edge of a strip to its highest value or limit
#: name, unit, format and scale of each measured quantity, by its field of `GroundBlock` and of `Limits`
MEASURED = {
    "power": ("power", "kW", "{:.2f}", 0.001),
    "rise": ("temperature rise", "K", "{:.0f}", 1.0),
    "roughness": ("Ra", "µm", "{:.2f}", 1.0),
}


class Strip(NamedTuple):
    """One strip chart."""

    name: str
    unit: str
    form: str  #: format of a value
    values: Sequence[float]
    limits: Sequence[float]  #: limits of each value; 0 for none
    bottom: float  #: value of the lower edge; if it is above 0, the scale is logarithmic
    top: float  #: value of the upper edge

    def height(self, value: float) -> float:
        """Return the height of a value in the strip, from 0 at the lower to 1 at the upper edge."""
        if self.bottom > 0.0:
            return math.log(value / self.bottom) / math.log(self.top / self.bottom)
        return value / self.top

    def exceeds_limit(self, k: int) -> bool:
        """Return whether value k exceeds its limit."""
        return 0.0 < self.limits[k] < self.values[k]

    @property
    def latest(self) -> str:
        """Last value and its limit as text, without the unit; empty if there is no value."""
        if not self.values:
            return ""
        limit = self.limits[-1]
        return self.form.format(self.values[-1]) + (f" of {self.form.format(limit)}" if limit > 0.0 else "")


def strips_of(view: EpisodePicture) -> tuple[Strip, ...]:
    """Return strips of power, temperature and Ra of the blocks ground so far, and of E, also of a running block."""
    ground, extent = view.ground, view.extent
    # the E of a block is chosen before it runs, and its caption names it
    speeds = [block.speed for block in ground] + ([view.instant.speed] if view.instant else [])
    low, high = extent.lowest_speed, extent.highest_speed
    limits = [block.limits for block in ground]
    measured = [
        _measured(name, unit, form, *([scale * getattr(of, field) for of in each] for each in (ground, limits)))
        for field, (name, unit, form, scale) in MEASURED.items()
    ]
    bottom = low if low < high else 0.0
    unlimited = [0.0] * len(speeds)
    speed = Strip("table speed E", "mm/min", "{:.0f}", speeds, unlimited, bottom, high)
    return *measured, speed


def _measured(name: str, unit: str, form: str, values: Sequence[float], limits: Sequence[float]) -> Strip:
    """Return a strip from 0 to a little above its highest value or limit."""
    highest = HEADROOM * max((*values, *limits), default=1.0)
    return Strip(name, unit, form, values, limits, 0.0, highest)
