"""Check that every field of a catalogue entry has an effect."""

from collections.abc import Mapping

from grind_env.process.entries import Entry, quantities
from grind_env.process.force_correction import EXPONENTS
from grind_env.validation.rig import Rig

#: fields that act outside of the strokes (on limits, times, prices, readings) or in a process of their own
ELSEWHERE = {
    "material": ("tempering_rise", *EXPONENTS),
    "wheel": ("minimum_diameter", "maximum_speed", "width", "price"),
    "dresser": ("cost_per_dress",),
    "fluid": (),
    "machine": (
        *("acceleration", "reversal_dwell", "rapid_feed", "hourly_rate", "stall_time", "meter_scale"),
        *("maximum_table_speed", "maximum_plunge_feed", "maximum_cross_feed", "maximum_spindle_speed"),
    ),
}


#: two sets of entries with which each field is tried; together they have every effect of the process
TRIED: tuple[Mapping[str, str], ...] = tuple(
    dict(zip(("material", "wheel", "fluid", "dresser", "machine"), (*names, "default"), strict=True))
    for names in (("aisi_52100", "a60j", "emulsion", "single_point"), ("aisi_52100", "b126", "oil", "rotary"))
)


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
    """Return all numbers of wheel and strokes, with sharp and dull wheel, worn diamond, boiling and slow spindle."""
    chosen = {kind: name for kind, name in names.items() if kind != "machine"}
    numbers: list[float] = []
    for conditions, flats in (
        ({}, None),
        ({"downfeed": 0.02, "table_speed": 300.0}, 0.05),
        ({"downfeed": 0.04, "table_speed": 300.0, "width": 40.0}, 0.05),
    ):
        grinder = rig.fresh(changes=changes, lead=0.15, depth=0.015, **chosen, **conditions)
        grinder.wheel = grinder.wheel._replace(wd=0.05)
        if flats is not None:
            grinder.wheel = grinder.wheel._replace(A=flats, lam=0.3)
        for _ in range(3):
            numbers += grinder.grind(5)
            numbers += grinder.wheel
            grinder.dress(1.0)
        numbers += grinder.grind(1, 0.0)
        numbers += grinder.wheel
    return tuple(numbers)
