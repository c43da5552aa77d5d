"""The inputs behind a report: file revisions, catalogue values, and the range of the model."""

import hashlib
from collections.abc import Mapping
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING

from grind_env.data_table import table_of
from grind_env.files import read_bytes
from grind_env.machine.job import Job
from grind_env.machine.job.job_entries import entries_of
from grind_env.process.catalogue import KINDS, USUAL, load_catalogue
from grind_env.process.entries import Entry, Quantity, quantities
from grind_env.shop.report.document import items, paragraph, table
from grind_env.validation import unfit_uses

if TYPE_CHECKING:
    from markupsafe import Markup


def revisions(files: Mapping[str, Path]) -> dict[str, str]:
    """Return names and revisions of files by kind of file, and the time of the report."""
    facts = {}
    for name, path in files.items():
        changed = datetime.fromtimestamp(path.stat().st_mtime, timezone.utc)
        facts[name] = path.name
        digest = hashlib.sha256(read_bytes(path)).hexdigest()[:16]
        facts[f"revision of the {name}"] = f"sha256 {digest}, {changed:%Y-%m-%d %H:%M} UTC"
    return facts | {"report written": f"{datetime.now(timezone.utc):%Y-%m-%d %H:%M} UTC"}


def foundations(job: Job) -> "list[Markup]":
    """Return the differences of a job from the built-in catalogue, and the forbidden uses of the model."""
    rows = changes(job)
    state = (
        "These values differ from the built-in catalogue; all others are its literature values."
        if rows
        else "No value differs from the built-in catalogue: nothing is calibrated to this machine, wheel or material."
    )
    values = [table(table_of(("entry", "value", "unit", "here", "catalogue"), rows, left=3))] if rows else []
    unfit = items([f"{use}: {why}." for use, why in unfit_uses().items()])
    return [paragraph(state), *values, paragraph("What the process model must not be used for:"), unfit]


def changes(job: Job) -> list[tuple[str, str, str, str, str]]:
    """Return the differences from the built-in entry of the same name, or from the most similar one.

    A row has entry, key, unit, value here and value in the catalogue.
    """
    found = []
    others = dict.fromkeys(each.part.material for each in job.stations if each.part.material != job.part.material)
    for kind, entry in (*entries_of(job).items(), *(("material", other) for other in others)):
        base = _nearest(kind, entry)
        name = f"{kind} {entry.name}" if base.name == entry.name else f"{kind} {entry.name}, beside {base.name}"
        for key, legal in quantities(KINDS[kind]).items():
            here, known = getattr(entry, key), getattr(base, key)
            if here != known:
                unit = legal.unit if isinstance(legal, Quantity) else ""
                found.append((name, key, unit, _text(here), _text(known)))
    return found


def assumptions(job: Job) -> list[str]:
    """Return the assumptions of a run as sentences."""
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
        found.append(f"Simulated on {job.plant}, an out-of-model machine.")
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
    """Return the built-in entry of that name, or the one with most equal values."""
    known: Mapping[str, Entry] = getattr(load_catalogue(), f"{kind}s")
    if entry.name in known:
        return known[entry.name]
    keys = list(quantities(KINDS[kind]))
    usual = USUAL.get(kind)
    return max(
        known.values(),
        key=lambda each: (sum(getattr(each, key) == getattr(entry, key) for key in keys), each.name == usual),
    )


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
