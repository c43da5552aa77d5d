"""Group 3: grit size and structure, and that every field of an entry does something."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from grind_env.process.corrected import EXPONENTS
from grind_env.process.entries import Entry, quantities
from grind_env.validation.check import FALLS, RISES, Check, at_most
from grind_env.validation.rig import USUAL, Grinder, Rig
from grind_env.validation.slopes import largest_step, smallest_step

WHEELS = ("a46h", "a60j", "a80k", "a120k")
GRITS = (0.33, 0.25, 0.19, 0.127)
"""mm; 46, 60, 80 and 120 mesh by 15.2/mesh."""
STRUCTURES = (0.48, 0.52, 0.56)
"""Share of grain in the volume: structures 7, 5 and 3."""

ENTRIES = {
    "material": (
        *("aisi_52100", "aisi_d2", "aisi_m2", "aisi_1045", "case_hardened_16mncr5", "grey_cast_iron"),
        *("inconel_718", "inc751", "ti_6al_4v"),
    ),
    "wheel": (*WHEELS, "a46j", "sg60j", "b126", "b91"),
    "fluid": ("emulsion", "synthetic", "oil", "dry"),
    "dresser": ("single_point", "blade", "rotary"),
}
"""What a shop looks for in the catalogue, by kind of entry."""

ELSEWHERE = {
    "material": ("tempering_rise", *EXPONENTS),
    "wheel": ("minimum_diameter", "maximum_speed", "price"),
    "dresser": ("cost_per_dress",),
    "fluid": (),
    "machine": (
        *("acceleration", "reversal_dwell", "rapid_feed", "hourly_rate", "stall_time", "meter_scale"),
        *("maximum_table_speed", "maximum_plunge_feed", "maximum_cross_feed", "maximum_spindle_speed"),
    ),
}
"""Fields that act outside of the strokes: on limits, times, prices, readings, and as a process of its own."""


TRIED: tuple[Mapping[str, str], ...] = tuple(
    dict(zip(("material", "wheel", "fluid", "dresser", "machine"), (*names, "default"), strict=True))
    for names in (("aisi_52100", "a60j", "emulsion", "single_point"), ("aisi_52100", "b126", "oil", "rotary"))
)
"""Entries among which a field has to change something; between them they have every effect of the process."""


def by_wheel(rig: Rig) -> list[dict[str, Any]]:
    """Set-ups with finer and finer wheels of the catalogue."""
    return [{"wheel": name} for name in WHEELS]


def by_grit(rig: Rig) -> list[dict[str, Any]]:
    """Set-ups with finer and finer grit in one and the same wheel."""
    return [{"changes": {"wheel": {"grit_size": grit}}} for grit in GRITS]


def by_structure(rig: Rig) -> list[dict[str, Any]]:
    """Set-ups with a denser and denser structure of one and the same wheel."""
    return [{"changes": {"wheel": {"grain_fraction": share}}} for share in STRUCTURES]


def steps(
    setups: Callable[[Rig], list[dict[str, Any]]],
    shown: Callable[[Grinder], float],
    step: Callable[[list[float]], float],
) -> Callable[[Rig], float]:
    """The largest or smallest step of what sharp wheels show."""
    return lambda rig: step([shown(rig.sharp(**setup)) for setup in setups(rig)])


def flats_after_volume(grinder: Grinder) -> float:
    """Wear-flat area after 300 mm3/mm more."""
    grinder.grind_volume(300.0)
    return grinder.wheel.A


def catalogue_gaps(rig: Rig) -> float:
    """How many of `ENTRIES` the catalogue lacks."""
    known: dict[str, Iterable[str]] = {
        "material": rig.catalogue.materials,
        "wheel": rig.catalogue.wheels,
        "fluid": rig.catalogue.fluids,
        "dresser": rig.catalogue.dressers,
    }
    return float(sum(name not in known[kind] for kind, names in ENTRIES.items() for name in names))


def idle_fields(rig: Rig) -> list[str]:
    """Numbers of entries that change neither wheel nor strokes if they are raised by 3 %, as `kind.field`."""
    catalogue = rig.catalogue
    finders: dict[str, Callable[[str], Entry]] = {
        "material": catalogue.material,
        "wheel": catalogue.wheel,
        "fluid": catalogue.fluid,
        "machine": catalogue.machine,
        "dresser": catalogue.dresser,
    }
    nominal = [_tried(rig, names, {}) for names in TRIED]
    idle = []
    for kind, find in finders.items():
        entries = [find(names[kind]) for names in TRIED]
        for name in _numbers(entries[0]):
            raised = [
                _tried(rig, names, {kind: {name: _raised(entry, name)}})
                for names, entry in zip(TRIED, entries, strict=True)
            ]
            if name not in ELSEWHERE[kind] and raised == nominal:
                idle.append(f"{kind}.{name}")
    return idle


def _numbers(entry: Entry) -> list[str]:
    return [name for name in quantities(type(entry)) if isinstance(getattr(entry, name), float)]


def _raised(entry: Entry, name: str) -> float:
    value: float = getattr(entry, name)
    raised = 1.03 * value if value != 0.0 else 0.03
    return raised if quantities(type(entry))[name].allows(raised) else 0.97 * value


def _tried(rig: Rig, names: Mapping[str, str], changes: dict[str, dict[str, float]]) -> tuple[float, ...]:
    """All numbers of wheel and strokes: sharp and dull, with boiling coolant, on a spindle that slows."""
    chosen = {kind: name for kind, name in names.items() if kind != "machine"}
    numbers: list[float] = []
    for conditions, flats in (
        ({}, None),
        ({"downfeed": 0.02, "table_speed": 300.0}, 0.05),
        ({"downfeed": 0.04, "table_speed": 300.0, "width": 40.0}, 0.05),
    ):
        grinder = rig.fresh(changes=changes, lead=0.15, depth=0.015, **chosen, **conditions)
        if flats is not None:
            grinder.wheel = grinder.wheel._replace(A=flats, lam=0.3)
        for _ in range(3):
            numbers += grinder.grind(20)
            numbers += grinder.wheel
            grinder.dress(1.0)
        numbers += grinder.grind(1, 0.0)
        numbers += grinder.wheel
    return tuple(numbers)


def density(grinder: Grinder) -> float:
    """Active grains per area, 1/mm2."""
    return grinder.grain_density()


SEEN: dict[str, tuple[str, Callable[[Grinder], float], bool]] = {
    "grains": ("active grains per area", density, True),
    "grain force": ("force per grain", lambda grinder: grinder.grind(5).fg, False),
    "roughness": ("Ra", lambda grinder: grinder.grind(5).Rg, False),
    "energy": ("specific energy", lambda grinder: grinder.grind(5).u_s, True),
    "flats": ("wear-flat area 300 mm3/mm later", flats_after_volume, True),
}
"""What a finer grit or a denser structure does: what is seen, and whether it rises."""

WAYS: dict[str, tuple[str, str, Callable[[Rig], list[dict[str, Any]]]]] = {
    "wheels": ("from A46H over A60J and A80K to A120K", "sharp wheels", by_wheel),
    "grit": ("with finer grit alone", "A60J with grit of .33 to .127 mm, sharp", by_grit),
    "structure": ("with denser structure alone", "A60J with 48 to 56 % of grain, sharp", by_structure),
}


def order(seen: str, way: str) -> Check:
    """That what is seen rises or falls throughout."""
    what, shown, rises = SEEN[seen]
    how, at, setups = WAYS[way]
    return Check(
        name=f"{seen} by {way}",
        group=3,
        what=f"{what} {how}, {'smallest' if rises else 'largest'} step",
        at=f"{USUAL}; {at}",
        band=RISES if rises else FALLS,
        measure=steps(setups, shown, smallest_step if rises else largest_step),
    )


CHECKS = (
    *(order(seen, way) for way in WAYS for seen in SEEN),
    Check(
        name="catalogue gaps",
        group=3,
        what="usual materials, wheels, fluids and dressers that the catalogue lacks",
        at=f"of {sum(map(len, ENTRIES.values()))} names",
        band=at_most(0.0),
        measure=catalogue_gaps,
    ),
    Check(
        name="idle fields",
        group=3,
        what="fields of entries that change nothing",
        at="each raised by 3 %; sharp and dull wheels, boiling, a stalling spindle, dresses by diamond and roll",
        band=at_most(0.0),
        measure=lambda rig: float(len(idle_fields(rig))),
    ),
)
