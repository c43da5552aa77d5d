"""What a set-up asks beyond what the catalogue says that its wheel and its machine are made for."""

import math
from typing import NamedTuple

from grind_env.process.entries import Machine, Wheel

SLACK = 1e-9
"""By which a number that a limit allows may lie beyond it: numbers are converted."""


class Beyond(NamedTuple):
    """A number of a set-up and the limit of an entry that it lies beyond, both in `unit`."""

    what: str
    value: float
    unit: str
    entry: str
    limit: float

    @property
    def excess(self) -> float:
        """How far beyond: above 1."""
        return max(self.value / self.limit, self.limit / self.value)

    def __str__(self) -> str:
        """As in `wheel speed 80 m/s (sg60j: at most 35)`."""
        end = "at most" if self.value > self.limit else "at least"
        return f"{self.what} {self.value:.4g} {self.unit} ({self.entry}: {end} {self.limit:g})"


def beyond(
    wheel: Wheel,
    machine: Machine,
    *,
    wheel_speed: float,
    constant_surface_speed: bool,
    diameter: float,
    table_speed: float,
    width: float,
) -> list[Beyond]:
    """What lies beyond the limits of wheel and machine; numbers as of `rig.SetUp`."""
    turning = diameter if constant_surface_speed else wheel.diameter
    spindle_speed = 60_000.0 * wheel_speed / (math.pi * turning)
    most = (
        Beyond("wheel speed", wheel_speed * diameter / turning, "m/s", wheel.name, wheel.maximum_speed),
        Beyond("wheel diameter", diameter, "mm", wheel.name, wheel.diameter),
        Beyond("width", width, "mm", wheel.name, wheel.width),
        Beyond("spindle speed", spindle_speed, "1/min", machine.name, machine.maximum_spindle_speed),
        Beyond("table speed", 0.06 * table_speed, "m/min", machine.name, machine.maximum_table_speed / 1000.0),
    )
    least = Beyond("wheel diameter", diameter, "mm", wheel.name, wheel.minimum_diameter)
    found = [each for each in most if each.value > each.limit * (1.0 + SLACK)]
    return found + [least] * (least.value < least.limit * (1.0 - SLACK))
