"""Wheel speed and coolant flow, from the words of a program or from the job.

Decisions (spindle-D1 to spindle-D4 of `grind facts`): a wheel that stands still grinds nothing, so the run is refused.
A speed other than the job's and a coolant that is off give a warning, and the process uses them. S is a whole number:
an S within half of one, or within a share of `TOLERANCE`, of the job's speed counts as equal.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

from grind_env.control import Spindle, Switch
from grind_env.machine.job import Job, Setup
from grind_env.process.catalogue import load_catalogue
from grind_env.process.entries import Fluid

TOLERANCE = 1e-3  #: largest relative difference of two speeds that count as equal

SPEEDS = (5.0, 150.0)  #: least and highest surface speed of a set-up, m/s

ALWAYS_ON, DRY = "always on", "dry"


@dataclass(frozen=True, slots=True)
class Speed:
    """The commanded surface speed of a new wheel, m/s, and whether G96 holds it as the wheel shrinks."""

    surface: float
    constant: bool

    def at(self, diameter: float, new: float) -> float:
        """Return the surface speed, m/s, of a wheel with this diameter, mm, and the diameter `new`, mm, when new."""
        return self.surface if self.constant else self.surface * diameter / new

    def word(self, new: float) -> str:
        """Return the S word that commands this speed for a new wheel of diameter `new`, mm."""
        return f"S{60.0 * self.surface:.0f} under G96" if self.constant else f"S{rotation(self.surface, new):.0f}"

    def word_instead_of(self, other: "Speed", new: float) -> str:
        return self.word(new) + " under G97" * (other.constant and not self.constant)


@cache
def dry_fluid() -> Fluid:
    """Return the fluid entry for dry grinding."""
    return load_catalogue().fluid(DRY)


def rotation(surface: float, diameter: float) -> float:
    """Return the revolutions per minute of a wheel with a surface speed, m/s, and a diameter, mm."""
    return 60_000.0 * surface / (math.pi * diameter)


class Running:
    """State of wheel and coolant after the words of a program so far, and the job's set-up in this state."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.setup = job.setup
        self._known: dict[tuple[Speed, bool], Setup] = {}
        self.commanded: Speed | None = None
        self._turning, self._flowing = 0, False
        self._put_in_force()

    @property
    def own(self) -> Speed:
        return Speed(self.job.setup.wheel_speed, self.job.setup.constant_surface_speed)

    @property
    def said_by_job(self) -> str:
        speed = self.speed
        said = f"wheel_speed = {speed.surface:.4g}"
        if speed.constant != self.own.constant:
            said += f" and constant_surface_speed = {str(speed.constant).lower()}"
        return f"{said} in [setup] of the job"

    @property
    def by_hand(self) -> bool:
        return self.job.setup.spindle == ALWAYS_ON

    @property
    def speed(self) -> Speed:
        return self.own if self.by_hand or self.commanded is None else self.commanded

    @property
    def is_turning(self) -> bool:
        return self.by_hand or (self._turning != 0 and self.speed.surface > 0.0)

    @property
    def is_reversed(self) -> bool:
        return not self.by_hand and self._turning < 0

    @property
    def is_dry(self) -> bool:
        flows = self._flowing or self.job.setup.coolant == ALWAYS_ON
        return not flows and self.job.setup.fluid.name != DRY

    def set_speed(self, event: Spindle) -> None:
        own, new = self.own, self.job.setup.wheel.diameter
        if event.surface > 0.0:
            found = Speed(event.surface / 60.0, constant=True)
        else:
            found = Speed(math.pi * new * event.speed / 60_000.0, constant=False)
        half = 0.5 / 60.0 if own.constant else 0.5 * math.pi * new / 60_000.0  # half a step of S, m/s
        same = abs(found.surface - own.surface) <= max(half, TOLERANCE * own.surface)
        self.commanded = own if found.constant == own.constant and same else found
        self._put_in_force()

    def switch(self, event: Switch) -> None:
        self._turning, self._flowing = event.turning, event.coolant
        self._put_in_force()

    @property
    def fault(self) -> str | None:
        low, high = SPEEDS
        speed, setup = self.speed, self.job.setup
        if not self.is_turning:
            return (
                f"the wheel does not turn at this stroke; program {self.own.word(setup.wheel.diameter)} M03 before it, "
                'or say spindle = "always on" in [setup] of the job'
            )
        if not low <= speed.surface <= high:
            unit = ", and S is m/min or, under G70, feet/min under G96" if speed.constant else ""
            return (
                f"S turns the wheel at {speed.surface:.3g} m/s, but the process model holds from {low:g} to {high:g} "
                f"m/s{unit}; the job says {self.own.word_instead_of(speed, setup.wheel.diameter)}"
            )
        return None

    def _put_in_force(self) -> None:
        speed, dry = self.speed, self.is_dry
        if not SPEEDS[0] <= speed.surface <= SPEEDS[1]:
            return  # a stroke with it will be refused
        if (speed, dry) not in self._known:
            setup = self.job.setup
            if speed != self.own:
                setup = replace(setup, wheel_speed=speed.surface, constant_surface_speed=speed.constant)
            self._known[speed, dry] = replace(setup, fluid=dry_fluid()) if dry else setup
        self.setup = self._known[speed, dry]


class RunningWarnings:
    """Warnings about wheel and coolant: one for each commanded speed, for reversed rotation and for dry grinding."""

    def __init__(self) -> None:
        self._told: set[Speed | str | None] = set()

    def of(self, running: Running, diameter: float) -> Iterator[tuple[str, str]]:
        """Yield subject and text of new warnings at a stroke with a wheel of this diameter, mm."""
        if running.is_reversed and self._is_new("reversed"):
            yield (
                "wheel sense",
                "M04 turns the wheel the other way than M03, for which its flange, guard and nozzle are made; write "
                'M03, or say spindle = "always on" in [setup] of the job if it is to turn so',
            )
        text = _of_speed(running, diameter) if self._is_new(running.commanded) else None
        if text is not None:
            yield "wheel speed", text
        if running.is_dry and self._is_new(DRY):
            yield (
                "coolant",
                "the coolant is off, and the part is ground dry; program M08 before this cycle, or say "
                'coolant = "always on" in [setup] of the job',
            )

    def _is_new(self, state: Speed | str | None) -> bool:
        known = state in self._told
        self._told.add(state)
        return not known


def _of_speed(running: Running, diameter: float) -> str | None:
    setup, own, commanded, speed = running.job.setup, running.own, running.commanded, running.speed
    new = setup.wheel.diameter
    surface, word = speed.at(diameter, new), own.word(new)
    turns, most = rotation(surface, diameter), setup.machine.maximum_spindle_speed
    if surface > (1.0 + TOLERANCE) * setup.wheel.maximum_speed:
        allowed = setup.wheel.maximum_speed
        lower = f"say wheel_speed = {allowed:g}" if speed == own else f"write {word}"
        return (
            f"the wheel turns at {surface:.3g} m/s, above the {allowed:g} m/s that {setup.wheel} bears; "
            f"{lower}, or put on a wheel that bears it"
        )
    if turns > (1.0 + TOLERANCE) * most:
        return f"the spindle turns at {turns:.0f} rpm, but {setup.machine} makes {most:g} at most; lower S"
    if running.by_hand:
        if commanded is None or abs(commanded.at(diameter, new) - own.at(diameter, new)) <= TOLERANCE * own.surface:
            return None
        return (
            f"{commanded.word(new)} has no effect, for the job says that the spindle is always on, with {word}; write "
            'that, or say spindle = "by program" in [setup] of the job'
        )
    if commanded is None:
        return f"no S says how fast the wheel is to turn, so that it turns as the job says; write {word}"
    if abs(surface - own.at(diameter, new)) > TOLERANCE * own.surface:
        return (
            f"the wheel turns at {surface:.4g} m/s and not at the {own.at(diameter, new):.4g} m/s of the job; write "
            f"{own.word_instead_of(speed, new)}, or say {running.said_by_job}"
        )
    return None
