"""What a run takes for granted, and which of its numbers are those of the catalogue."""

from collections.abc import Mapping
from typing import NamedTuple

from grind_env.machine.job import Job
from grind_env.process.catalogue import KINDS, USUAL, load_catalogue
from grind_env.process.entries import Entry, Quantity, quantities

PLACES = ("wheel", "dresser", "fluid", "machine")


class Change(NamedTuple):
    """A value of a job that is not that of the built-in catalogue."""

    entry: str
    key: str
    unit: str
    here: str
    known: str


def entries_of(job: Job) -> dict[str, Entry]:
    """The catalogue entries of a job, by kind."""
    return {"material": job.part.material, **{kind: getattr(job.setup, kind) for kind in PLACES}}


def changes(job: Job) -> list[Change]:
    """What differs from the built-in entry of the same name, or from the one that is most like it."""
    found = []
    others = dict.fromkeys(each.part.material for each in job.stations if each.part.material != job.part.material)
    for kind, entry in (*entries_of(job).items(), *(("material", other) for other in others)):
        base = _nearest(kind, entry)
        name = f"{kind} {entry.name}" if base.name == entry.name else f"{kind} {entry.name}, beside {base.name}"
        for key, legal in quantities(KINDS[kind]).items():
            here, known = getattr(entry, key), getattr(base, key)
            if here != known:
                unit = legal.unit if isinstance(legal, Quantity) else ""
                found.append(Change(name, key, unit, _text(here), _text(known)))
    return found


def assumptions(job: Job) -> list[str]:
    """Sentences."""
    setup, times, start = job.setup, job.times, job.wheel
    diameter = setup.wheel.diameter if start.diameter is None else start.diameter
    dull = "freshly dressed" if start.wear_flat_area is None else f"with {100.0 * start.wear_flat_area:g} % wear flats"
    loaded = "for all stations together" if job.stations else "a part"
    found = [
        "Every part is nominal: its material, its stock and the wheel are just as the job says.",
        f"The run begins with a wheel of {diameter:g} mm, {dull}.",
        f"Loading takes {times.load:g} s {loaded}, the set-up of a dress {times.dress_setup:g} s beside its motions.",
    ]
    if job.plant:
        found.append(f"The machine is not the model but {job.plant}.")
    if times.gauge > 0.0:
        found.append(f"Gauging takes {times.gauge:g} s at every M01 at which the table stands.")
    if job.diamond is None:
        found.append("The job does not say where the diamond stands: every dress program is taken to meet it.")
    if times.wheel_change is None:
        found.append("A worn wheel stays on the machine: the job gives no time for a change.")
    for what, how in (("wheel", setup.spindle), ("coolant", setup.coolant)):
        if how == "always on":
            found.append(f"The {what} is set by hand and always on; the words of the program have no effect on it.")
    if job.part.stages:
        found.append("A part is judged at each gauging stop that ends one of its stages, and at the end.")
    return found


def _nearest(kind: str, entry: Entry) -> Entry:
    """The built-in entry of that name, or the one with most values the same."""
    known: Mapping[str, Entry] = getattr(load_catalogue(), f"{kind}s")
    if entry.name in known:
        return known[entry.name]
    keys = list(quantities(KINDS[kind]))
    usual = USUAL.get(kind)
    return max(known.values(), key=lambda each: (_alike(each, entry, keys), each.name == usual))


def _alike(one: Entry, other: Entry, keys: list[str]) -> int:
    return sum(getattr(one, key) == getattr(other, key) for key in keys)


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
