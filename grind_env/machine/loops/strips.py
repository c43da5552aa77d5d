"""One stroke over a part whose surface is kept in strips across its width.

The strips with more than half of the deepest interference under the wheel are cut; the others, ground at this depth
before, only spark. The cut is that of the mean interference over the joint width, and takes the same depth off each.
"""

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import column_reader, column_writer, replacer
from grind_env.machine.loops.cycle import grown_of
from grind_env.process.equations import INITIAL_ROUGHNESS, surface_roughness
from grind_env.process.process import Process, whole_ms
from grind_env.process.state import StrokeParameters, StrokeResult, WheelState

Strips = NDArray[np.float64]
"""One value per strip of the part."""


IDLE = StrokeResult(*[0.0] * len(StrokeResult._fields))
"""A stroke that does not pass over the part."""


class Zone(NamedTuple):
    """Strips side by side that only ever lie under the wheel together: what one of them is, all are."""

    S: float
    """Stock removed, mm."""
    Rs: float
    """Roughness Ra, um."""
    reached: float
    """Depth of the deepest stroke so far, mm."""
    centre: float
    """Cross coordinate of the middle of the first of them, mm."""
    strips: float
    """How many they are; 0 where there is no zone, which is then never under the wheel."""


class Contact(NamedTuple):
    """What a stroke meets, of the zones looked at so far."""

    tip: float
    """Depth of the wheel face, mm."""
    strips: float
    """Of the part."""
    S: float
    """Least stock removed under the wheel, mm; infinite where it is beside the part."""
    Rs: float
    """Roughness of the first zone under it, um."""
    reached: float
    """Least depth reached under it, mm; infinite as for S."""
    engaged: float
    """Strips in the cut."""
    S_offset: float
    """Sum over them of the stock removed beyond the least, mm."""
    Rs_offset: float
    """Sum over them of the roughness beyond that of the first zone, um."""


seen = replacer(Contact, "strips", "S", "Rs", "reached")
cutting = replacer(Contact, "engaged", "S_offset", "Rs_offset")
left_on = replacer(Zone, "S", "Rs", "reached")


@inlined
def contact_at(tip: float) -> Contact:
    """The wheel at a depth, before any zone has been looked at."""
    return Contact(
        tip=tip,
        strips=0.0,
        S=math.inf,
        Rs=INITIAL_ROUGHNESS,
        reached=math.inf,
        engaged=0.0,
        S_offset=0.0,
        Rs_offset=0.0,
    )


@inlined
def beneath(contact: Contact, zone: Zone, under: bool) -> Contact:
    """Look at a zone, which is under the wheel or not, for the deepest interference."""
    first = under & (contact.reached == math.inf)
    Rs = zone.Rs if first else contact.Rs
    S = min(contact.S, zone.S) if under else contact.S
    reached = min(contact.reached, zone.reached) if under else contact.reached
    return seen(contact, (contact.strips + zone.strips, S, Rs, reached))


@inlined
def in_cut(contact: Contact, zone: Zone, under: bool) -> bool:
    """Whether a zone takes part in the cut, once all have been looked at."""
    deepest = contact.tip - contact.S
    return under & ((contact.tip - zone.S > 0.5 * deepest) | (deepest <= 0.0))


@inlined
def joined(contact: Contact, zone: Zone, cut: bool) -> Contact:
    """Add a zone that is in the cut.

    Means are offsets from one strip: exact where all are equal, so that a plunge cut is that of one strip.
    """
    S_more = zone.strips * (zone.S - contact.S) if cut else 0.0
    Rs_more = zone.strips * (zone.Rs - contact.Rs) if cut else 0.0
    more = zone.strips if cut else 0.0
    return cutting(contact, (contact.engaged + more, contact.S_offset + S_more, contact.Rs_offset + Rs_more))


@inlined
def cut_surface(contact: Contact, width: float) -> tuple[float, float, float]:
    """Engaged width in mm of a part so wide, and the means of stock removed in mm and roughness in um over it.

    A wheel beside the part has no interference, over whatever width: such a stroke changes nothing.
    """
    beside = contact.engaged <= 0.0
    engaged = contact.strips if beside else contact.engaged
    S = contact.tip if beside else contact.S + contact.S_offset / engaged
    return width * (engaged / contact.strips), S, contact.Rs + contact.Rs_offset / engaged


@inlined
def ground(zone: Zone, under: bool, cut: bool, tip: float, Z: float, ae: float, Rg: float) -> Zone:
    """A zone after a stroke programmed at depth `Z`, mm.

    It took `ae`, mm, off what was in the cut, and left `Rg`, um; `tip` is the depth of the wheel face, mm.
    """
    S = zone.S + ae if cut else zone.S
    Rs = surface_roughness(zone.Rs, Rg, ae if cut else 0.0, tip - zone.S if cut else 0.0)
    reached = max(zone.reached, Z) if under else zone.reached
    return left_on(zone, (S, Rs, reached))


@inlined
def _strip(S: Strips, Rs: Strips, reached: Strips, i: int) -> Zone:
    return Zone(S=S[i], Rs=Rs[i], reached=reached[i], centre=0.0, strips=1.0)


@functools.cache
def strips_of(process: Process) -> Callable[..., tuple[WheelState, StrokeResult, float, bool, float]]:
    """The compiled stroke of a process over strips, `grind_strips`."""
    grind, constants, grown = process.stroke, process.constants, grown_of(process)
    read_own, write_own = column_reader(process.own), column_writer(process.own)

    @entry
    def grind_strips(
        wheel: WheelState,
        S: Strips,
        Rs: Strips,
        reached: Strips,
        first: int,
        last: int,
        Z: float,
        vw: float,
        width: float,
        Lw: float,
        p: StrokeParameters,
        depth: float,
        own: NDArray[Any],
        seconds: float,
    ) -> tuple[WheelState, StrokeResult, float, bool, float]:
        """One stroke over the strips `first` to `last - 1` of a part, which the wheel covers.

        Args:
            wheel: state before the stroke.
            S: stock removed, mm; updated.
            Rs: roughness, um; updated.
            reached: deepest Z of a stroke so far, mm; updated.
            first: first strip under the wheel.
            last: the strip after the last one, greater than `first`.
            Z: programmed downfeed position, mm.
            vw: table speed, mm/s.
            width: of the part, all strips together, mm.
            Lw: ground length, mm.
            p: parameters.
            depth: downfeed position of the wheel, mm; `Z` unless it is retracted.
            own: what the process remembers besides, shape (1, fields of its `own`); updated.
            seconds: up to the next stroke, s.

        Returns:
            The wheel after the stroke, the stroke, the engaged width in mm, whether the wheel went deeper into a strip
            than before, and by how much the part stood higher than when it was cold, mm.
        """
        before, held = read_own(own, 0), constants(p, vw, Lw)
        higher = grown(before, held)
        depth += higher
        contact = contact_at(depth - wheel.W)
        for i in range(S.size):
            contact = beneath(contact, _strip(S, Rs, reached, i), (first <= i) & (i < last))
        for i in range(first, last):
            zone = _strip(S, Rs, reached, i)
            contact = joined(contact, zone, in_cut(contact, zone, True))
        b, S_mean, Rs_mean = cut_surface(contact, width)
        after, left, stroke = grind(wheel, before, S_mean, Rs_mean, depth, b, held, whole_ms(seconds))
        write_own(own, 0, left)
        for i in range(first, last):
            zone = _strip(S, Rs, reached, i)
            zone = ground(zone, True, in_cut(contact, zone, True), contact.tip, Z, stroke.ae, stroke.Rg)
            S[i], Rs[i], reached[i] = zone.S, zone.Rs, zone.reached
        return after, stroke, b, contact.reached + DEPTH_TOLERANCE < Z, higher

    return grind_strips
