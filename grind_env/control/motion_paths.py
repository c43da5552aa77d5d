"""The path, speed and duration that a motion block asks for (14-4, 14-5, 12-53)."""

from collections.abc import Callable
from typing import TypeAlias

from grind_env.control import numbers
from grind_env.control.block_decoding import Command
from grind_env.control.control_settings import Control
from grind_env.control.errors import ControlError
from grind_env.control.events import Position
from grind_env.control.modal_state import Modes
from grind_env.control.modes import PLANES
from grind_env.control.path_geometry import Circular, ImpossibleArc, arc_about, arc_with_radius

Missing: TypeAlias = Callable[[], ControlError]  #: function that makes the error of a block without a necessary word

AXES = "XYZ"
INTEGRANDS = "IJK"

COORDINATE_DECIMALS = 7  #: decimals of a coordinate in mm, more than the 0.00254 mm of the last inch decimal needs


def coordinate(command: Command, letter: str, start: float, origin: float = 0.0) -> float:
    """Return the coordinate of an axis word, mm: from `start` under G91 at the word, else from `origin` (PD-4)."""
    value = command.lengths[letter]
    return displaced(start if value.incremental else origin, value.mm)


def displaced(start: float, way: float) -> float:
    """Return the end of `way` from `start`, mm, without binary residue: increments of 0.1, 0.1 and 0.1 end at 0.3."""
    return round(start + way, COORDINATE_DECIMALS) + 0.0


def moved_by(position: Position, way: Position, sign: float) -> Position:
    """Return the position after a way in each axis, mm, along it if `sign` is 1 and back if it is -1."""
    x, y, z = (displaced(coordinate, sign * part) for coordinate, part in zip(position, way, strict=True))
    return x, y, z


def target(command: Command, position: Position, origin: Position, without: int | None = None) -> Position:
    """Return the target of the axis words, mm on the machine; the reciprocating axis `without` stays (PD-7)."""
    x, y, z = (
        coordinate(command, letter, position[axis], origin[axis])
        if letter in command.lengths and axis != without
        else position[axis]
        for axis, letter in enumerate(AXES)
    )
    return x, y, z


def arc_path(command: Command, position: Position, origin: Position) -> Circular | None:
    """Return the arc of a G02 or G03 block; None without length words."""
    action, plane = command.action, command.modes.plane
    first, second = PLANES[plane]
    centre_letters = INTEGRANDS[first], INTEGRANDS[second]
    command.allow_only("".join(("XYZR", *centre_letters)), f"a {action} block in {plane}")
    if not command.lengths:
        return None
    by_centre = any(letter in command.lengths for letter in centre_letters)
    by_radius = "R" in command.lengths
    if by_centre == by_radius:
        name, found = ("block-format", "both") if by_centre else ("missing-parameter", "neither")
        needed = f"R or a centre by {' and '.join(centre_letters)}"
        raise command.error(name, f"{action} takes either {needed} in {plane}; it has {found}", "R")
    end = target(command, position, origin)
    rotation = 1 if action == "G03" else -1
    try:
        if by_radius:
            return arc_with_radius(position, end, command.lengths["R"].mm, rotation, plane)
        u, v = (command.lengths[letter].mm if letter in command.lengths else 0.0 for letter in centre_letters)
        return arc_about(position, end, (u, v), rotation, plane)
    except ImpossibleArc as reason:
        raise command.error("arc-geometry", f"{action} describes no arc: {reason}", "R") from None


def feed_rate(modes: Modes, speed: float | None, control: Control, missing: Missing) -> float:
    """Return F in mm/min, clamped to the maximum (12-60); under G95 the spindle speed converts it (12-56).

    `missing` makes the error to raise without F, or under G95 without spindle speed.
    """
    if modes.feed is None or (modes.per_revolution and not speed):
        raise missing()
    return min(modes.feed * (speed or 0.0 if modes.per_revolution else 1.0), control.maximum_feed)


def no_feed_rate(command: Command) -> ControlError:
    """Return the error of a motion without F, or under G95 without S."""
    needed = "F" if command.modes.feed is None else "S"
    return command.error("no-feedrate", f"{command.action} is commanded without {needed}; program it here or before")


def dwell_seconds(command: Command, speed: float | None) -> float:
    """Return the time of a G04, s, from P or X in s, under G95 in revolutions; `speed` is revolutions per minute."""
    command.allow_only("PX", "a G04 block")
    words = [command.words[letter] for letter in "PX" if letter in command.words]
    if len(words) != 1:
        name, found = ("block-format", "both P and X") if words else ("missing-parameter", "neither P nor X")
        raise command.error(name, f"G04 has {found}; it takes its time in one of them", "P")
    amount = numbers.plain(command.block, words[0], command.number_format)
    if not command.modes.per_revolution:
        return amount
    if not speed:
        raise command.error("no-feedrate", "G04 counts revolutions under G95; S is needed before")
    return 60.0 * amount / speed
