"""Write a job as the text of a job file that reads back equal."""

from collections.abc import Mapping
from dataclasses import MISSING, asdict, fields
from typing import Any

from grind_env.machine.job import Job, Part, PartConditions
from grind_env.process.catalogue import KINDS, USUAL, load_catalogue
from grind_env.process.entries import Entry, quantities
from grind_env.process.toml_tables import contents
from grind_env.toml import toml_text


def job_text(job: Job) -> str:
    """Return the job as TOML that needs no other file: it has all values of entries that are not built in."""
    tools = {kind: getattr(job.setup, kind) for kind in USUAL}
    kinds = (*(each.part for each in job.parts if each.part is not None), *(each.part for each in job.stations))
    materials = [job.part.material, *(each.material for each in kinds)]
    entries = [("material", each) for each in materials] + list(tools.items())
    tables = {
        "plant": job.plant,
        "part": {} if job.stations else _part(job.part),
        "setup": {kind: entry.name for kind, entry in tools.items()} | _said(job.setup),
        "times": _said(job.times),
        "wheel": _said(job.wheel),
        "diamond": {} if job.diamond is None else _said(job.diamond),
        "lots": _said(job.lots),
        "catalogue": _own(entries) | ({} if job.uncertainty is None else {"uncertainty": asdict(job.uncertainty)}),
        "stations": [_said(each) | _part(each.part) for each in job.stations],
        "parts": [_conditions(each, job.part) for each in job.parts],
    }
    return toml_text({name: table for name, table in tables.items() if table}) + "\n"


def _own(entries: list[tuple[str, Entry]]) -> dict[str, dict[str, Any]]:
    known = load_catalogue()
    own: dict[str, dict[str, Any]] = {}
    for kind, entry in entries:
        if getattr(known, f"{kind}s").get(entry.name) != entry:
            values = {key: getattr(entry, key) for key in quantities(KINDS[kind])}
            own.setdefault(kind, {})[entry.name] = values
    return own


def _part(part: Part) -> dict[str, Any]:
    stages = [_said(stage) for stage in part.stages]
    return {"material": part.material.name, **_said(part), **({"stages": stages} if stages else {})}


def _conditions(differs: PartConditions, part: Part) -> dict[str, Any]:
    found: dict[str, Any] = {} if differs.stock is None else {"stock": differs.stock}
    if differs.part is not None and differs.part != part:
        found["part"] = _differing(differs.part, part)
    for key in ("factors", "new_wheel_factors"):
        factors: Mapping[str, float] | None = getattr(differs, key)
        if factors:
            found[key] = dict(factors)
    return found


def _differing(own: Part, part: Part) -> dict[str, Any]:
    found = {key: getattr(own, key) for key in contents(Part) if getattr(own, key) != getattr(part, key)}
    if own.material != part.material:
        found["material"] = own.material.name
    if own.stages != part.stages:
        found["stages"] = [_said(stage) for stage in own.stages]
    return found


def _said(table: Any) -> dict[str, Any]:
    defaults = {each.name: each.default for each in fields(table) if each.default is not MISSING}
    values = {key: getattr(table, key) for key in contents(table.__class__)}
    return {key: value for key, value in values.items() if key not in defaults or value != defaults[key]}
