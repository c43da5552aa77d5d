"""The catalogue entries of a job, and copies of a job with other numbers in them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from grind_env.machine.job.job import Job
from grind_env.machine.job.parts import Station
from grind_env.process.catalogue import USUAL
from grind_env.process.entries import Entry, Material


def entries_of(job: Job) -> Mapping[str, Entry]:
    """Return the entries of the catalogue that a job works with, by kind."""
    return {"material": job.part.material, **{kind: getattr(job.setup, kind) for kind in USUAL}}


def with_entries(job: Job, changes: Mapping[str, Mapping[str, float]]) -> Job:
    """Return a job with fields of its entries changed, by kind; the state of the wheel at the start stays.

    The material of a station is not changed if it differs from that of the first station.
    """
    entries: Mapping[str, Any] = entries_of(job)
    changed = {kind: replace(entry, **changes.get(kind, {})) for kind, entry in entries.items()}
    material = changed["material"]
    return replace(
        job,
        part=replace(job.part, material=material),
        stations=tuple(_with_material(each, job.part.material, material) for each in job.stations),
        part_stations=tuple(_with_material(each, job.part.material, material) for each in job.part_stations),
        setup=replace(job.setup, **{kind: entry for kind, entry in changed.items() if kind != "material"}),
    )


def _with_material(station: Station, old: Material, new: Material) -> Station:
    return replace(station, part=replace(station.part, material=new)) if station.part.material == old else station
