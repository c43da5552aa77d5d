"""The wheel or dresser that a T word selects, and the speed of the wheel (15-11, 15-12, 12-41)."""

import math

from grind_env.control.control import WHEEL_RADIUS, Control
from grind_env.control.decode import Command
from grind_env.control.modal_state import Modes
from grind_env.control.motions import Position
from grind_env.control.paths import Missing

MILLIMETRES_PER_METRE = 1000.0


class Tooling:
    """The tables that T selects from, as the execution changes them; no entry is selected before the first T word."""

    def __init__(self, control: Control) -> None:
        self.control = control
        self.radii = dict(control.radii)
        self.entry: int | None = None

    def radius_of(self, entry: int | None) -> float:
        """Radius of an entry, mm; 0 for T0000."""
        return 0.0 if entry == 0 else self.radii.get(entry or 0, self.control.radius)

    @property
    def radius(self) -> float:
        """The active radius, mm."""
        return self.radius_of(self.entry)

    def select(self, command: Command) -> Position | None:
        """Let a T word choose radius and length; returns the length offset that it activates, mm.

        Under the scheme of the entire wheel the radius takes care of X (15-11).
        """
        if command.tool is None:
            return None
        self.entry, number = command.tool
        return self.control.length_offset(number)

    def dressed_off(self, amount: float) -> None:
        """Keep entry 33 up to date after a dress that takes `amount` mm off the radius (15-11)."""
        self.radii[WHEEL_RADIUS] = self.radius_of(WHEEL_RADIUS) - amount

    @property
    def worn_out(self) -> bool:
        return self.radius_of(WHEEL_RADIUS) < self.control.minimum_radius

    def spindle_speed(self, modes: Modes, missing: Missing) -> float | None:
        """Revolutions per minute of the wheel; None before the first S.

        Under G96 the part does not turn, so that S is the surface speed itself: ``1000 S / (2 pi r)`` (12-41).
        """
        if modes.spindle is None or not modes.surface_speed:
            return modes.spindle
        radius = self.radius_of(WHEEL_RADIUS)
        if radius <= 0.0:
            raise missing()
        return MILLIMETRES_PER_METRE * modes.spindle / (2.0 * math.pi * radius)
