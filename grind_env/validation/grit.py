"""Group 3: grit size, structure and grade, and that every field of an entry does something."""

from collections.abc import Mapping
from functools import partial

from grind_env.process.corrected import EXPONENTS
from grind_env.process.entries import Entry, quantities
from grind_env.validation.check import FALLS, RISES, Check, Question, at_least, at_most, own
from grind_env.validation.measures import (
    Measurement,
    Quantity,
    SetUps,
    changed_over,
    flats_after,
    g_over,
    over,
    quotient,
    stroke,
)
from grind_env.validation.rig import Grinder, Rig
from grind_env.validation.slopes import largest_step, smallest_step

WHEELS = ("a46h", "a60j", "a80k", "a120k")
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


def catalogue_gaps(rig: Rig) -> float:
    """Return how many of `ENTRIES` the catalogue lacks."""
    known = {kind: getattr(rig.catalogue, f"{kind}s") for kind in ENTRIES}
    return float(sum(name not in known[kind] for kind, names in ENTRIES.items() for name in names))


def idle_fields(rig: Rig) -> list[str]:
    """Return the numbers of entries that change neither wheel nor strokes when raised by 3 %, as `kind.field`."""
    nominal = [_tried(rig, names, {}) for names in TRIED]
    idle = []
    for kind, elsewhere in ELSEWHERE.items():
        entries: list[Entry] = [getattr(rig.catalogue, kind)(names[kind]) for names in TRIED]
        for name in quantities(type(entries[0])):
            if name in elsewhere or not isinstance(getattr(entries[0], name), float):
                continue
            raised = [
                _tried(rig, names, {kind: {name: _raised(entry, name)}})
                for names, entry in zip(TRIED, entries, strict=True)
            ]
            if raised == nominal:
                idle.append(f"{kind}.{name}")
    return idle


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


SEEN: dict[str, tuple[str, Quantity, bool]] = {
    "grains": ("active grains per area", Grinder.grain_density, True),
    "grain force": ("force per grain", stroke("fg"), False),
    "roughness": ("Ra", stroke("Rg"), False),
    "energy": ("specific energy", stroke("u_s"), True),
    "flats": ("wear-flat area 300 mm3/mm later", flats_after(300.0), True),
}
"""What a finer grit or a denser structure does: what is seen, and whether it rises."""

WAYS: dict[str, tuple[str, str, SetUps]] = {
    "wheels": ("from A46H over A60J and A80K to A120K", "sharp wheels", over("wheel", WHEELS)),
    "grit": (
        "with finer grit alone",
        "A60J with grit of .33 to .127 mm, sharp",
        changed_over("wheel", "grit_size", (0.33, 0.25, 0.19, 0.127)),
    ),
    "structure": (
        "with denser structure alone",
        "A60J with 48 to 56 % of grain, sharp",
        changed_over("wheel", "grain_fraction", (0.48, 0.52, 0.56)),
    ),
}
"""Finer and finer wheels. Grits of 46, 60, 80 and 120 mesh by 15.2/mesh; structures 7, 5 and 3."""

GRADES = {"H": 0.8, "J": 1.2, "L": 2.0, "M": 2.5}
"""Force per grain that breaks grain or bond, N, at the reference grit."""
MALKIN_COOK = own("the way of the trend: Malkin & Cook, J. Eng. Ind. 93 (1971) (from memory)")

ask = partial(Question, 3)


def order(seen: str, way: str) -> Check:
    """Return the check that what is seen rises or falls throughout."""
    what, shown, rises = SEEN[seen]
    how, at, setups = WAYS[way]
    band, end, step = (RISES, "smallest", smallest_step) if rises else (FALLS, "largest", largest_step)
    return ask(f"{seen} by {way}", f"{what} {how}, {end} step", f"usual; {at}").within(
        band, Measurement(shown, setups, step, Rig.sharp)
    )


def over_grade_j(quantity: Quantity, grade: str) -> Measurement:
    """Measure a quantity of a wheel of some grade over that of grade J; nothing of the wheels is loose."""
    changes = [{"wheel": {"fracture_force": GRADES[each], "initial_wear": 0.0}} for each in (grade, "J")]
    return Measurement(quantity, over("changes", changes), quotient)


LATER = "usual; 600 mm3/mm after the dress"

CHECKS = (
    *(order(seen, way) for way in WAYS for seen in SEEN),
    ask(
        "catalogue gaps",
        "usual materials, wheels, fluids and dressers that the catalogue lacks",
        f"of {sum(map(len, ENTRIES.values()))} names",
    ).within(at_most(0.0), catalogue_gaps),
    ask(
        "idle fields",
        "fields of entries that change nothing",
        "each raised by 3 %; sharp and dull wheels, boiling, a stalling spindle, dresses by diamond and roll",
    ).within(at_most(0.0), lambda rig: float(len(idle_fields(rig)))),
    ask(
        "G of grade L",
        "G-ratio of grade L over that of grade J",
        "usual; steady wear over 100 mm3/mm from the dress on",
    ).within(at_least(1.15), over_grade_j(g_over(100.0), "L"), MALKIN_COOK),
    ask("flats of grade M", "wear-flat area of grade M over that of grade J", LATER).within(
        at_least(1.2), over_grade_j(flats_after(600.0), "M"), MALKIN_COOK
    ),
    ask("flats of grade H", "wear-flat area of grade H over that of grade J", LATER).within(
        at_most(0.9), over_grade_j(flats_after(600.0), "H"), MALKIN_COOK
    ),
)
