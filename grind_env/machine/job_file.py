"""Job files: TOML, with the fields of the classes in `job.py` as keys.

::

    [part]
    material = "aisi_52100"
    length = 200            # mm, along the reciprocating axis
    width = 20              # mm, across
    stock = 0.3             # mm
    tolerance = 9           # um; leave out where none is asked for, as roughness_limit (um)
    scrap_cost = 40         # $

    [[part.stages]]         # optional, one for each M01 at which the part must keep limits of its own
    stock = 0.25            # mm, ground off by then
    rise_allowance = 150    # K; its plunges count here only, as do peaks of the power

    [setup]                 # optional: names of the catalogue, and changes to single values of an entry
    wheel = "a60j"
    machine_overrides = { stiffness = 50_000 }
    grooving_wheel = true   # the wheel makes the infeeds of G76 and G77; false if left out

    [catalogue]             # optional: the user's own catalogue, beside the job file
    files = ["shop.toml"]

    [lots]                  # optional: how the parts of a batch differ, in `grind/Job-v0`
    probability = 0.2       # that a part begins a new lot of material
    growth = 0.6            # spread of how fast a lot dulls the wheel, like that of pressure logarithmic
    stock = 0.1             # standard deviation of the stock of a part over the nominal one

Tables `[times]` and `[wheel]` are optional too.

For grooves, `length` is what each infeed grinds (the circumference of a turning part) and `surface` the coordinate
at which the tool touches the part. Without `grooving_wheel` a turning tool cuts them: they take their time and leave
the wheel and the stock as they are. A program of grooves alone is judged by them: `stock` is then their depth,
`tolerance` and `roughness_limit` are those of their bottom.
"""

import dataclasses
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from grind_env.errors import did_you_mean, shortened
from grind_env.files import ReadError
from grind_env.machine.job import Job, JobError, Lots, Part, Setup, Stage, Times, WheelStart, wrong
from grind_env.process.catalogue import Catalogue, CatalogueError, load_catalogue, quantities
from grind_env.toml import TomlError, read_toml

DEFAULTS = {"wheel": "a60j", "dresser": "single_point", "fluid": "emulsion", "machine": "default"}
"""The entry of each kind for a set-up that names none."""

KINDS = ("material", *DEFAULTS)
VALUES = ("wheel_speed", "constant_surface_speed", "grooving_wheel")

Table = Mapping[str, Any]


def load_job(path: str | Path) -> Job:
    """Read a job file.

    Raises:
        JobError: the file cannot be read, is not TOML, or has an unknown, missing or illegal key.
    """
    path = Path(path)
    try:
        document = read_toml(path)
    except ReadError as error:
        raise JobError(f"the job cannot be read ({error.reason}); name a TOML file", file=str(path)) from None
    except TomlError as error:
        raise JobError(f"the job is not valid TOML: {error}", file=str(path)) from None
    try:
        return _job(document, path.parent)
    except JobError as error:
        raise JobError(error.message, error.key, error.found, error.legal, str(path)) from None


def _job(document: Table, folder: Path) -> Job:
    _refuse_unknown(document, ("part", "setup", "times", "wheel", "lots", "catalogue"))
    part = _table(document, "part", _names(Part))
    setup = _table(document, "setup", (*DEFAULTS, *VALUES, *(f"{kind}_overrides" for kind in KINDS)))
    times = _table(document, "times", _names(Times))
    wheel = _table(document, "wheel", _names(WheelStart))
    lots = _table(document, "lots", _names(Lots))
    catalogue = _catalogue(_table(document, "catalogue", ("files",)), folder)

    _refuse_missing(part, Part, "part")
    names = {"part.material": part["material"]}
    names |= {f"setup.{kind}": setup.get(kind, default) for kind, default in DEFAULTS.items()}
    material, *tools = (_entry(catalogue, key, name, setup) for key, name in names.items())
    return Job(
        part=Part(**{**part, "material": material, "stages": _stages(part)}),
        setup=Setup(**dict(zip(DEFAULTS, tools, strict=True)), **{key: setup[key] for key in VALUES if key in setup}),
        times=Times(**times),
        wheel=WheelStart(**wheel),
        lots=Lots(**lots),
    )


def _stages(part: Table) -> tuple[Stage, ...]:
    """The stages of the part before the last one."""
    place, found = "part.stages", part.get("stages", [])
    if not isinstance(found, list):
        raise wrong(place, found, f"tables, each headed [[{place}]]")
    return tuple(_stage(number, {place: table}, place) for number, table in enumerate(found, 1))


def _stage(number: int, parent: Table, place: str) -> Stage:
    try:
        table = _table(parent, place, _names(Stage))
        _refuse_missing(table, Stage, place)
        return Stage(**table)
    except JobError as error:
        raise JobError(f"stage {number}: {error.message}", error.key, error.found, error.legal) from None


def _catalogue(table: Table, folder: Path) -> Catalogue:
    files = table.get("files", [])
    if not isinstance(files, list) or not all(isinstance(name, str) for name in files):
        raise wrong("catalogue.files", files, "a list of file names")
    try:
        return load_catalogue(*(folder / name for name in files))
    except CatalogueError as error:
        raise JobError(f"catalogue.files: {error}", "catalogue.files", files) from None


def _entry(catalogue: Catalogue, key: str, name: object, setup: Table) -> Any:
    """The catalogue entry that a key names, with the overrides for its kind."""
    kind = key.rpartition(".")[2]
    place = f"setup.{kind}_overrides"
    try:
        entry = getattr(catalogue, kind)(name)
    except CatalogueError as error:
        raise JobError(f"{key}: {error}", key, name) from None
    legal = quantities(type(entry))
    overrides = _table(setup, f"{kind}_overrides", tuple(legal), place)
    try:
        return dataclasses.replace(entry, **overrides)
    except CatalogueError as error:
        raise JobError(f"{place}: {error}", place, overrides) from None


def _table(parent: Table, name: str, legal: Iterable[str], place: str = "") -> Table:
    """A table without unknown keys; an empty one if it is missing."""
    place, value = place or name, parent.get(name, {})
    if not isinstance(value, Mapping):
        raise wrong(place, value, f"a table, headed [{place}]")
    _refuse_unknown(value, legal, f"{place}.")
    return value


def _refuse_unknown(table: Table, legal: Iterable[str], prefix: str = "") -> None:
    legal = tuple(legal)
    for key, value in table.items():
        if key not in legal:
            hint, names = did_you_mean(key.lower(), legal), ", ".join(legal)
            raise JobError(
                f"there is no key {prefix}{shortened(key)}{hint}; legal are {names}", f"{prefix}{key}", value, names
            )


def _refuse_missing(table: Table, kind: type[Any], place: str) -> None:
    for key in _names(kind, required=True):
        if key not in table:
            raise JobError(f"{place}.{key} is missing; it has no default", f"{place}.{key}")


def _names(kind: type[Any], required: bool = False) -> tuple[str, ...]:
    return tuple(
        item.name for item in dataclasses.fields(kind) if not required or (item.default is dataclasses.MISSING)
    )
