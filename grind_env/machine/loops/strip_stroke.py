"""One stroke over a part whose surface is stored in strips across its width.

Strips with more than half of the deepest interference under the wheel are cut; the others, ground before, only spark.
The cut has the mean interference over the joint width, and removes the same depth from each strip.
"""

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.kernel import entry, inlined
from grind_env.kernel.row_accessors import column_reader, column_writer, replacer
from grind_env.machine.loops.cycle import PartState, Zone, grown_of
from grind_env.machine.loops.row_io import read_zone, write_zone
from grind_env.machine.loops.table_speed import Pace, at_nodes, paced_of
from grind_env.process.equations import INITIAL_ROUGHNESS, surface_roughness
from grind_env.process.process_interface import Process, whole_ms
from grind_env.process.stroke_types import StrokeParameters, StrokeResult, WheelState

Strips = NDArray[np.float64]  #: one value per strip of the part


IDLE = StrokeResult(*[0.0] * len(StrokeResult._fields))  #: a stroke that does not pass over the part


class Contact(NamedTuple):
    """Contact of a stroke with the zones checked so far."""

    tip: float  #: depth of the wheel face, mm
    strips: float  #: number of strips of the part
    S: float  #: least stock removed under the wheel, mm; infinite for a wheel beside the part
    Rs: float  #: roughness of the first zone under the wheel, um; the next two fields belong to this zone, too
    S_step: float
    Rs_step: float
    reached: float  #: least depth reached under the wheel, mm; infinite for a wheel beside the part
    engaged: float  #: number of strips in the cut
    S_offset: float  #: sum over the strips in the cut of the stock removed beyond `S`, mm
    #: sum over the strips in the cut of the roughness beyond `Rs`, um; the next two fields are sums in the same way
    Rs_offset: float
    S_step_offset: float
    Rs_step_offset: float


class Removal(NamedTuple):
    """Depths that both nodes remove from the zones in the cut; `ae` and `slow_ae` are mm, the others um."""

    slow_ae: float
    ae: float
    slow_Rg: float
    Rg: float


with_zone = replacer(Contact, "strips", "S", "Rs", "S_step", "Rs_step", "reached")
with_cut = replacer(Contact, "engaged", "S_offset", "Rs_offset", "S_step_offset", "Rs_step_offset")
with_surface = replacer(Zone, "S", "Rs", "S_step", "Rs_step", "reached")


@inlined
def contact_at(tip: float) -> Contact:
    """Return the contact of the wheel at a depth before zones are added."""
    return Contact(
        tip=tip,
        strips=0.0,
        S=math.inf,
        Rs=INITIAL_ROUGHNESS,
        S_step=0.0,
        Rs_step=0.0,
        reached=math.inf,
        engaged=0.0,
        S_offset=0.0,
        Rs_offset=0.0,
        S_step_offset=0.0,
        Rs_step_offset=0.0,
    )


@inlined
def add_zone(contact: Contact, zone: Zone, under: bool) -> Contact:
    """Return the contact with a zone added; a zone `under` the wheel may have the least stock removed."""
    first = under & (contact.reached == math.inf)
    Rs = zone.Rs if first else contact.Rs
    S_step, Rs_step = zone.S_step if first else contact.S_step, zone.Rs_step if first else contact.Rs_step
    S = min(contact.S, zone.S) if under else contact.S
    reached = min(contact.reached, zone.reached) if under else contact.reached
    return with_zone(contact, (contact.strips + zone.strips, S, Rs, S_step, Rs_step, reached))


@inlined
def is_cut(contact: Contact, zone: Zone, under: bool) -> bool:
    """Return whether a zone takes part in the cut, after all zones were added."""
    deepest = contact.tip - contact.S
    return under & ((contact.tip - zone.S > 0.5 * deepest) | (deepest <= 0.0))


@inlined
def add_to_cut(contact: Contact, zone: Zone, cut: bool) -> Contact:
    """Return the contact with a zone added to the cut, if `cut`.

    Means are sums of offsets from one strip: exact for equal strips, so that a plunge cut equals that of one strip.
    """
    S = contact.S_offset + (zone.strips * (zone.S - contact.S) if cut else 0.0)
    Rs = contact.Rs_offset + (zone.strips * (zone.Rs - contact.Rs) if cut else 0.0)
    S_step = contact.S_step_offset + (zone.strips * (zone.S_step - contact.S_step) if cut else 0.0)
    Rs_step = contact.Rs_step_offset + (zone.strips * (zone.Rs_step - contact.Rs_step) if cut else 0.0)
    return with_cut(contact, (contact.engaged + (zone.strips if cut else 0.0), S, Rs, S_step, Rs_step))


@inlined
def cut_surface(contact: Contact, width: float, Z: float) -> tuple[float, PartState]:
    """Return the engaged width of a part `width` wide, mm, and the mean surface over it, with deepest stroke `Z`, mm.

    A wheel beside the part has no interference, over any width: its stroke changes nothing.
    """
    beside = contact.engaged <= 0.0
    engaged = contact.strips if beside else contact.engaged
    S = contact.tip if beside else contact.S + contact.S_offset / engaged
    part = PartState(
        Z=Z,
        S=S,
        Rs=contact.Rs + contact.Rs_offset / engaged,
        S_step=contact.S_step + contact.S_step_offset / engaged,
        Rs_step=contact.Rs_step + contact.Rs_step_offset / engaged,
    )
    return width * (engaged / contact.strips), part


@inlined
def zone_after_stroke(zone: Zone, under: bool, cut: bool, tip: float, Z: float, removal: Removal, share: float) -> Zone:
    """Return a zone after a stroke programmed at depth `Z`, mm.

    `tip` is the depth of the wheel face, mm; `share` is the share of the slow node.
    """
    slow_S, fast_S = at_nodes(zone.S, zone.S_step, share)
    slow_Rs, fast_Rs = at_nodes(zone.Rs, zone.Rs_step, share)
    slow_Ra = surface_roughness(slow_Rs, removal.slow_Rg, removal.slow_ae, tip - slow_S)
    fast_Ra = surface_roughness(fast_Rs, removal.Rg, removal.ae, tip - fast_S)
    S = zone.S + (removal.ae + share * (removal.slow_ae - removal.ae)) if cut else zone.S
    Rs = fast_Ra + share * (slow_Ra - fast_Ra) if cut else zone.Rs
    S_step = zone.S_step + (removal.ae - removal.slow_ae) if cut else zone.S_step
    Rs_step = fast_Ra - slow_Ra if cut else zone.Rs_step
    reached = max(zone.reached, Z) if under else zone.reached
    return with_surface(zone, (S, Rs, S_step, Rs_step, reached))


@functools.cache
def strips_of(process: Process) -> Callable[..., tuple[WheelState, StrokeResult, float, bool, float]]:
    """Return the compiled stroke of a process over strips, `grind_strips`."""
    grind, constants, grown = paced_of(process), process.constants, grown_of(process)
    read_own, write_own = column_reader(process.own), column_writer(process.own)

    @entry
    def grind_strips(
        wheel: WheelState,
        strips: Array,
        first: int,
        last: int,
        Z: float,
        pace: Pace,
        width: float,
        Lw: float,
        p: StrokeParameters,
        depth: float,
        own: NDArray[Any],
        seconds: float,
    ) -> tuple[WheelState, StrokeResult, float, bool, float]:
        """Make one stroke over the strips `first` to `last - 1` of a part, which the wheel covers.

        Args:
            wheel: state before the stroke.
            strips: shape (strips, fields of `Zone`); updated.
            first: first strip under the wheel.
            last: the strip after the last one, greater than `first`.
            Z: programmed downfeed position, mm.
            pace: speeds of the table.
            width: width of the part, all strips together, mm.
            Lw: ground length, mm.
            p: parameters.
            depth: downfeed position of the wheel, mm; `Z` unless it is retracted.
            own: memory of the process, shape (1, fields of its `own`); updated.
            seconds: time up to the next stroke, s.

        Returns:
            The wheel after the stroke, the stroke, the engaged width in mm, whether the wheel went deeper into a strip
            than before, and the thermal growth of the part, mm.
        """
        before, slow_held, held = read_own(own, 0), constants(p, pace.slow, Lw), constants(p, pace.speed, Lw)
        higher = grown(before, held)
        depth += higher
        contact = contact_at(depth - wheel.W)
        for i in range(len(strips)):
            contact = add_zone(contact, read_zone(strips, i), (first <= i) & (i < last))
        for i in range(first, last):
            zone = read_zone(strips, i)
            contact = add_to_cut(contact, zone, is_cut(contact, zone, True))
        b, part = cut_surface(contact, width, Z)
        after, left, stroke, slow, fast = grind(wheel, before, part, depth, b, pace, slow_held, held, whole_ms(seconds))
        write_own(own, 0, left)
        removal = Removal(slow_ae=slow.ae, ae=fast.ae, slow_Rg=slow.Rg, Rg=fast.Rg)
        for i in range(first, last):
            zone = read_zone(strips, i)
            cut = is_cut(contact, zone, True)
            write_zone(strips, i, zone_after_stroke(zone, True, cut, contact.tip, Z, removal, pace.slow_share))
        return after, stroke, b, contact.reached + DEPTH_TOLERANCE < Z, higher

    return grind_strips
