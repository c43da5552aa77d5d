"""The wheel or dresser that a T word selects, and the speed of the wheel (15-11, 15-12, 12-41)."""

import math

from grind_env.control.block_decoding import Command
from grind_env.control.control_settings import WHEEL_RADIUS, Control
from grind_env.control.events import Position
from grind_env.control.modal_state import Modes
from grind_env.control.motion_paths import Missing


class Tooling:
    """The radius table, which the execution may change, and its entry selected by T, None before the first T word."""

    def __init__(self, control: Control) -> None:
        self.control = control
        self.radii = dict(control.radii)
        self.entry: int | None = None

    def radius_of(self, entry: int | None) -> float:
        """Return the radius of an entry, mm; 0 for T0000."""
        return 0.0 if entry == 0 else self.radii.get(entry or 0, self.control.radius)

    @property
    def radius(self) -> float:
        return self.radius_of(self.entry)

    def select(self, command: Command) -> Position | None:
        """Select radius and length by a T word; return the length offset that it activates, mm.

        With `entire_wheel` the radius replaces the X offset (15-11).
        """
        if command.tool is None:
            return None
        self.entry, number = command.tool
        return self.control.length_offset(number)

    @property
    def wheel_radius(self) -> float:
        """Return the radius in entry 33, mm, which dresses keep up to date (15-11)."""
        return self.radius_of(WHEEL_RADIUS)

    @wheel_radius.setter
    def wheel_radius(self, radius: float) -> None:
        self.radii[WHEEL_RADIUS] = radius

    def spindle_speed(self, modes: Modes, missing: Missing) -> float | None:
        """Return the speed of the wheel, revolutions per minute; None before the first S.

        Under G96, S is the surface speed of the wheel, as the part does not turn: ``1000 S / (2 pi r)`` (12-41).
        """
        if modes.spindle is None or not modes.surface_speed:
            return modes.spindle
        if self.wheel_radius <= 0.0:
            raise missing()
        return 1000.0 * modes.spindle / (2.0 * math.pi * self.wheel_radius)
