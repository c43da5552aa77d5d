"""Surfaces of parts in the compiled loops: one value if the wheel covers the part, else zones across."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.array_types import Array
from grind_env.kernel import entry, inlined
from grind_env.kernel.row_accessors import lane_reader, lane_writer
from grind_env.machine.loops.cycle import PartState, Zone
from grind_env.machine.loops.row_io import read_part, read_zone, write_part, write_zone
from grind_env.machine.loops.strip_stroke import (
    Contact,
    Removal,
    add_to_cut,
    add_zone,
    contact_at,
    cut_surface,
    is_cut,
    zone_after_stroke,
)


class Place(NamedTuple):
    """Place of a stroke. Lengths are mm."""

    Z: float  #: programmed depth of the stroke
    depth: float  #: depth of the wheel, thermal growth of the part included
    edge: float  #: cross coordinate of the wheel's edge on the minus side
    end: float  #: cross coordinate of the wheel's edge on the plus side


class Buffer(NamedTuple):
    """The buffer of the lanes without the surfaces, and compiled functions of the buffer."""

    lanes: int
    rows: int  #: number of rows without those of the surface
    stroking: Callable[..., Any]  #: `stroking(rows, lane)`: numbers of the strokes of the cycle
    wheel: Callable[..., Any]  #: `wheel(rows, lane)`: the wheel before the coming stroke
    part: Callable[..., Any]  #: `part(rows, lane)`: the part before the coming stroke
    place: Callable[..., Any]  #: `place(rows, lane)`: place of the coming stroke
    #: `stroke(rows, lane, b, reached, part)`: make the coming stroke; arguments as of `CycleFunctions.advance`
    stroke: Callable[..., Any]


class SurfaceLanes(NamedTuple):
    """Compiled functions for one kind of surfaces; `surfaces` is their table, with an entry for each machine."""

    size: Callable[..., Any]  #: `size(surfaces)`: size of the buffer
    begin: Callable[..., Any]  #: `begin(surfaces, i)`: the part on machine i before its cycle
    #: `load(rows, lane, surfaces, i)`: load into a lane the zones of machine i, which are not in its `PartState`
    load: Callable[..., Any]
    store: Callable[..., Any]  #: `store(rows, lane, surfaces, i)`: write the surface of a lane to machine i
    #: `advance_lanes(rows)`: make a stroke in every lane. This is a separate function, because it vectorises only with
    #: `rows` as its only argument
    advance_lanes: Callable[..., Any]


def covered_surface(buffer: Buffer) -> SurfaceLanes:
    """Return the functions for surfaces that the wheel covers; their table has shape (N, fields of `PartState`)."""
    lanes, buffer_size = buffer.lanes, buffer.rows * buffer.lanes
    stroking_in, part_in, stroke_in = buffer.stroking, buffer.part, buffer.stroke

    @inlined
    def size(surfaces: Array) -> int:
        return buffer_size

    @inlined
    def load(rows: Array, lane: int, surfaces: Array, i: int) -> None:
        pass

    @inlined
    def store(rows: Array, lane: int, surfaces: Array, i: int) -> None:
        write_part(surfaces, i, part_in(rows, lane))

    @entry
    def advance_lanes(rows: Array) -> None:
        for lane in range(lanes):
            part = part_in(rows, lane)
            stroke_in(rows, lane, stroking_in(rows, lane).width, part.Z, part)

    return SurfaceLanes(size=size, begin=read_part, load=load, store=store, advance_lanes=advance_lanes)


#: number of zones in one loop over the lanes; LLVM unrolls a loop over the lanes that does less, and does not vectorise
#: it
BUNCH = 2

MOST_ZONES = 4096  #: most zones of a surface in the lanes; a power of 2, see `get_zone`

NO_ZONE = Zone(S=0.0, Rs=1.0, reached=0.0, centre=math.inf, strips=0.0)  #: empty zone that fills the last bunch


@inlined
def is_under(zone: Zone, place: Place) -> bool:
    """Return whether the wheel is over a zone."""
    return (place.edge <= zone.centre) & (zone.centre < place.end)


@inlined
def deepest_zone(surfaces: Array, i: int) -> float:
    """Return the depth of the deepest stroke on machine i, mm; `surfaces` has shape (N, zones, fields of `Zone`)."""
    deepest = 0.0
    for number in range(surfaces.shape[1]):
        deepest = max(deepest, read_zone(surfaces[i], number).reached)
    return deepest


def zoned_surface(buffer: Buffer) -> SurfaceLanes:
    """Return the functions for surfaces in zones; their table has shape (N, zones, fields of `Zone`).

    The zones are processed one after the other, each in all lanes side by side.
    """
    lanes, place_in, wheel_in, part_in = buffer.lanes, buffer.place, buffer.wheel, buffer.part
    stroking_in, stroke_in = buffer.stroking, buffer.stroke
    records = (Place, Contact, Removal)
    starts = [buffer.rows + sum(len(record._fields) for record in records[:k]) for k in range(4)]
    columns = [(record, start, lanes) for record, start in zip(records, starts, strict=False)]
    get_place, get_contact, get_removal = (lane_reader(*each) for each in columns)
    put_place, put_contact, put_removal = (lane_writer(*each) for each in columns)
    read_lane, write_lane = lane_reader(Zone, starts[-1], lanes), lane_writer(Zone, starts[-1], lanes)
    first_zone, zone_size = starts[-1] * lanes, len(Zone._fields) * lanes

    @inlined
    def get_zone(rows: Array, number: int, lane: int) -> Any:
        # a bounded number shows LLVM that a loop over the lanes does not write to this zone, and the loop vectorises
        return read_lane(rows, (number & (MOST_ZONES - 1)) * zone_size + lane)

    @inlined
    def put_zone(rows: Array, number: int, lane: int, zone: Zone) -> None:
        write_lane(rows, (number & (MOST_ZONES - 1)) * zone_size + lane, zone)

    @inlined
    def size(surfaces: Array) -> Any:
        if surfaces.shape[1] > MOST_ZONES:
            raise ValueError("a surface has more than 4096 zones: let a zone have more strips")
        bunches = (surfaces.shape[1] + BUNCH - 1) // BUNCH
        return first_zone + bunches * BUNCH * zone_size

    @inlined
    def begin(surfaces: Array, i: int) -> PartState:
        return PartState(Z=deepest_zone(surfaces, i), S=0.0, Rs=0.0, S_step=0.0, Rs_step=0.0)

    @inlined
    def load(rows: Array, lane: int, surfaces: Array, i: int) -> None:
        zones = surfaces.shape[1]
        for number in range((rows.size - first_zone) // zone_size):
            put_zone(rows, number, lane, read_zone(surfaces[i], number) if number < zones else NO_ZONE)

    @inlined
    def store(rows: Array, lane: int, surfaces: Array, i: int) -> None:
        for number in range(surfaces.shape[1]):
            write_zone(surfaces[i], number, get_zone(rows, number, lane))

    @entry
    def advance_lanes(rows: Array) -> None:
        zones = (rows.size - first_zone) // zone_size
        for lane in range(lanes):
            place = place_in(rows, lane)
            put_place(rows, lane, place)
            put_contact(rows, lane, contact_at(place.depth - wheel_in(rows, lane).W))
        for bunch in range(zones // BUNCH):
            for lane in range(lanes):
                place, contact = get_place(rows, lane), get_contact(rows, lane)
                for k in range(BUNCH):
                    zone = get_zone(rows, bunch * BUNCH + k, lane)
                    contact = add_zone(contact, zone, is_under(zone, place))
                put_contact(rows, lane, contact)
        for bunch in range(zones // BUNCH):
            for lane in range(lanes):
                place, contact = get_place(rows, lane), get_contact(rows, lane)
                for k in range(BUNCH):
                    zone = get_zone(rows, bunch * BUNCH + k, lane)
                    contact = add_to_cut(contact, zone, is_cut(contact, zone, is_under(zone, place)))
                put_contact(rows, lane, contact)
        for lane in range(lanes):
            contact = get_contact(rows, lane)
            b, part = cut_surface(contact, stroking_in(rows, lane).width, part_in(rows, lane).Z)
            slow, fast = stroke_in(rows, lane, b, contact.reached, part)
            put_removal(rows, lane, Removal(slow_ae=slow.ae, ae=fast.ae, slow_Rg=slow.Rg, Rg=fast.Rg))
        for number in range(zones):
            for lane in range(lanes):
                zone, place, contact = get_zone(rows, number, lane), get_place(rows, lane), get_contact(rows, lane)
                removal, under = get_removal(rows, lane), is_under(zone, place)
                cut, share = is_cut(contact, zone, under), stroking_in(rows, lane).slow_share
                put_zone(rows, number, lane, zone_after_stroke(zone, under, cut, contact.tip, place.Z, removal, share))

    return SurfaceLanes(size=size, begin=begin, load=load, store=store, advance_lanes=advance_lanes)
