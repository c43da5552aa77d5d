"""Grinding of G76 and G77 grooves: one cut of the process model per infeed.

The grooving cycles are for a turning part (lathe manual, chapter 23). An infeed by `a` at the feed `vf` over a ground
length `Lw`, the circumference of the part, removes `vf Lw` mm3/s per mm of width: the specific removal rate `pi dw vf`
of cylindrical plunge grinding (Malkin, Grinding Technology). A stroke of the model removes `ae vw`; with the
interference `a` and the work speed `vw = Lw vf / a` the part makes one turn per infeed, and volume, removal rate and
duration equal the infeed's. If the part turns faster, the cut of a turn is thinner than computed; the curvature of the
part is ignored.

The wheel engages with its whole width, less the width of a groove beside. Without a dwell at the bottom there is no
spark-out: a groove stays shallower by the deflection of wheel and machine.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import numpy as np

from grind_env.control import Infeed
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.machine.dress.mounted_wheel import Mount
from grind_env.machine.loops.strip_stroke import IDLE, strips_of
from grind_env.machine.loops.table_speed import steady
from grind_env.machine.loops.zone_layout import strip_zones
from grind_env.process.stroke_types import StrokeParameters, StrokeResult

PLACE_DECIMALS = 6  #: decimals, mm, to which the coordinates of two infeeds of one groove agree

Direction: TypeAlias = tuple[int, float]  #: axis of the infeeds, 0 = X, 1 = Y, 2 = Z, and their sign on it

Place: TypeAlias = tuple[float, ...]  #: coordinates along the two other axes, mm


class GrooveCut(NamedTuple):
    """Result of an infeed on the part."""

    stroke: StrokeResult
    b: float = 0.0  #: engaged width, mm
    grown: float = 0.0  #: thermal growth of the part, mm
    Lw: float = 0.0  #: ground length, mm
    plunged: bool = False  #: whether it has cut


NO_CUT = GrooveCut(IDLE)


class Groove:
    """A groove as one strip of the process model."""

    def __init__(self) -> None:
        self.strip = strip_zones(np.zeros(1))  # shape (1, fields of `Zone`)
        self.S, self.Rs, self.reached = self.strip.T[:3]  # depth cut, mm; roughness, um; deepest programmed depth, mm
        self.plunges: list[tuple[float, float]] = []  # depth in mm and temperature rise in K of every infeed


class Grooves:
    """The grooves of one part; a further infeed at the place of a groove deepens this groove."""

    def __init__(self, surface: float, length: float, width: float) -> None:
        self.surface, self.length, self.width = surface, length, width
        self._grooves: dict[tuple[Direction, Place], Groove] = {}

    def __iter__(self) -> Iterator[Groove]:
        return iter(self._grooves.values())

    def grind(self, mount: Mount, event: Infeed, p: StrokeParameters) -> GrooveCut:
        """Make one infeed, which cuts if it goes deeper than before."""
        Z, direction = infeed_depth(event, self.surface), _direction(event)
        place = tuple(round(x, PLACE_DECIMALS) for axis, x in enumerate(event.end) if axis != event.axis)
        groove = self._grooves.get((direction, place), Groove())
        deeper = Z - groove.reached[0]
        if deeper <= DEPTH_TOLERANCE:
            return NO_CUT
        self._grooves[direction, place] = groove
        vw = self.length * event.feed / 60.0 / deeper
        width = self._engaged(direction, place, Z)
        lies = groove.strip, 0, 1, Z, steady(vw), width, self.length, p, Z, mount.own, event.seconds
        wheel, stroke, b, _, grown = strips_of(mount.job.process)(mount.present(p), *lies)
        mount.set_wheel(wheel, mount.memory_time + event.seconds)
        groove.plunges.append((Z, stroke.T))
        return GrooveCut(stroke, b, grown, self.length, plunged=True)

    def _engaged(self, direction: Direction, place: Place, Z: float) -> float:
        """Return the width that the wheel cuts at depth `Z`, mm: without the width of the nearest groove as deep."""
        beside = (
            math.dist(other, place)
            for (way, other), groove in self._grooves.items()
            if way == direction and groove.reached[0] >= Z - DEPTH_TOLERANCE  # this groove is not so deep yet
        )
        return min((self.width, *beside))


def infeed_depth(event: Infeed, surface: float) -> float:
    """Return the depth that an infeed reaches below the surface, mm; negative if it ends before it."""
    axis, sign = _direction(event)
    return sign * (event.end[axis] - surface)


def _direction(event: Infeed) -> Direction:
    return event.axis, math.copysign(1.0, event.end[event.axis] - event.start[event.axis])
