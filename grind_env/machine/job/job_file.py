"""Job files: TOML, with the fields of the classes in this folder as keys.

`docs/howto/job-file.md` explains the tables, and `grind job --template` prints all keys with unit, range and default.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grind_env.files import ReadError, beside, is_file, missing, shown
from grind_env.machine.job.errors import JobError
from grind_env.machine.job.job import PART_AT_STATION, Job
from grind_env.machine.job.machine_setup import Diamond, Setup, Times, WheelStart
from grind_env.machine.job.parts import Lots, Part, PartConditions, Stage, Station
from grind_env.machine.job.uncertainty import Uncertainty, uncertainty_of
from grind_env.message_text import shortened
from grind_env.process.catalogue import USUAL, Catalogue
from grind_env.process.entries import CatalogueError, Entry, Quantity
from grind_env.process.toml_tables import (
    Content,
    TomlTable,
    checked,
    contents,
    keys,
    refuse_missing,
    refuse_unknown,
    sub_table,
    wrong,
)
from grind_env.process.user_catalogue import OVERRIDES, catalogue_of, entry_of
from grind_env.toml import TomlError, read_toml

if TYPE_CHECKING:
    from grind_env.plants import Plant

KEYS = "plant", "part", "setup", "times", "wheel", "lots", "diamond", "catalogue", "parts", "stations"
PLAIN: Mapping[str, Any] = {"times": Times, "wheel": WheelStart, "lots": Lots, "diamond": Diamond}
VALUES = tuple(contents(Setup))  #: keys of `[setup]` that are no entries of the catalogue
WRITE_ONE = "write one: `grind job --template` prints a job, and `grind init FOLDER` makes a program with its job"
FACTORS = Content(Mapping, float, quantity=Quantity("", "", 1e-9, 1e9))


def job_beside(program: Path) -> Path:
    """Return the path of the job file beside a program: the same name with `.toml`.

    Raises:
        JobError: there is no such job file.
        ReadError: there is no program either.
    """
    path = beside(program, ".toml")
    if not is_file(path):
        if not program.exists():
            raise missing(program)
        raise JobError(f"there is no job {shown(path)} beside the program; name one with --job, or {WRITE_ONE}")
    return path


def job_of(program: Path, job: str | Path | Job | None, *, plant: "Plant | None" = None) -> Job:
    """Return the job of a file or object; for None, of the job file beside the program. Errors as of `load_job`."""
    if isinstance(job, Job):
        return job if plant is None else job.on(plant)
    return load_job(job_beside(program) if job is None else job, plant=plant)


def load_job(path: str | Path, *, plant: "Plant | None" = None, calibrated: bool = True) -> Job:
    """Read a job file.

    Args:
        path: job file.
        plant: the machine, in place of that of the file.
        calibrated: whether the calibrated catalogue files of the job are read.

    Raises:
        JobError: the file cannot be read, is not TOML, or has an unknown, missing or illegal key.
    """
    path = Path(path)
    try:
        document = read_toml(path)
    except ReadError as error:
        message = f"the job cannot be read ({error.reason}); name a TOML file, or {WRITE_ONE}"
        raise JobError(message, file=str(path)) from None
    except TomlError as error:
        raise JobError(f"the job is not valid TOML: {error}", file=str(path)) from None
    with _naming(file=str(path)):
        job = _job(document, path.parent, calibrated)
        if plant is None and "plant" in document:
            plant = _plant(document["plant"])
    return job if plant is None else job.on(plant)


@contextmanager
def _naming(place: str = "", file: str = "") -> Iterator[None]:
    """Add the place in the job, or the file, to errors."""
    try:
        yield
    except JobError as error:
        raise JobError(f"{place}{error.message}", error.key, error.found, error.legal, file) from None


def _plant(name: Any) -> "Plant":
    from grind_env.plants import PlantError, find_plant

    try:
        return find_plant(name)
    except PlantError as error:
        raise JobError(f"plant: {error}", "plant", name) from None


def _job(document: TomlTable, folder: Path, calibrated: bool) -> Job:
    refuse_unknown(document, KEYS, JobError)
    part = sub_table(document, "part", keys(Part), JobError)
    setup = sub_table(document, "setup", (*USUAL, *VALUES, *OVERRIDES), JobError)
    plain = {name: sub_table(document, name, keys(kind), JobError) for name, kind in PLAIN.items() if name in document}
    catalogue = catalogue_of(document, folder, JobError, calibrated=calibrated)

    lying = _tables(document, "stations")
    if not lying:
        refuse_missing(part, Part, "part", JobError)
    for name, table in plain.items():
        refuse_missing(table, PLAIN[name], name, JobError)
    part = _with_material(part, setup, catalogue)
    tools = {
        kind: entry_of(catalogue, f"setup.{kind}", setup.get(kind, default), setup, JobError)
        for kind, default in USUAL.items()
    }
    stations = tuple(_station(number, table, part, catalogue) for number, table in enumerate(lying, 1))
    return Job(
        part=stations[0].part if stations else _part(part),
        setup=Setup(**tools, **{key: setup[key] for key in VALUES if key in setup}),
        **{name: PLAIN[name](**table) for name, table in plain.items()},
        parts=_parts(document, part, catalogue),
        stations=stations,
        uncertainty=_uncertainty(catalogue, tools | ({"material": part["material"]} if "material" in part else {})),
    )


def _uncertainty(catalogue: Catalogue, entries: Mapping[str, Entry]) -> Uncertainty | None:
    """Return the uncertainty left by the calibration of these entries, by kind; None without such a calibration."""
    found = catalogue.calibrated
    if found is None or any(kind in entries and entries[kind].name not in names for kind, names in found.names.items()):
        return None
    try:
        return uncertainty_of(found.table)
    except CatalogueError as error:
        place = "catalogue.files" if found.file else "catalogue"
        raise JobError(f"{place}: {f'{shown(Path(found.file))}: ' if found.file else ''}{error}", place) from None


def _tables(parent: TomlTable, name: str, place: str = "") -> list[object]:
    found = parent.get(name, [])
    if not isinstance(found, list):
        raise wrong(f"{place}{name}", found, f"tables, each headed [[{place}{name}]]", JobError)
    return found


def _part(table: TomlTable) -> Part:
    stages = []
    for number, stage in enumerate(_tables(table, "stages", "part."), 1):
        with _naming(f"stage {number}: "):
            known = checked(stage, "part.stages", keys(Stage), JobError)
            refuse_missing(known, Stage, "part.stages", JobError)
            stages.append(Stage(**known))
    return Part(**{**table, "stages": tuple(stages)})


def _station(number: int, table: object, part: TomlTable, catalogue: Catalogue) -> Station:
    """Return a station, given the `part` table with its material."""
    place = tuple(contents(Station))
    name = table.get("name", str(number)) if isinstance(table, Mapping) else number
    with _naming(f"station {shortened(str(name))}: "):
        table = checked(table, "stations", (*place, *keys(Part)), JobError)
        own = _with_material({key: value for key, value in table.items() if key not in place}, {}, catalogue)
        refuse_missing({**part, **own}, Part, "part", JobError)
        lies: dict[str, Any] = {key: table[key] for key in place if key in table}
        if isinstance(lies.get("origin"), list):
            lies["origin"] = tuple(lies["origin"])
        return Station(**{"name": str(number), **lies, "part": _part({**part, **own})})


def _parts(document: TomlTable, part: TomlTable, catalogue: Catalogue) -> tuple[PartConditions, ...]:
    """Return the differences of each part from the `part` table, given with its material."""
    parts = []
    for number, table in enumerate(_tables(document, "parts"), 1):
        with _naming(f"part {number}: "):
            parts.append(_conditions(checked(table, "parts", keys(PartConditions), JobError), part, catalogue))
    return tuple(parts)


def _conditions(table: TomlTable, part: TomlTable, catalogue: Catalogue) -> PartConditions:
    for key, content in {"stock": contents(Part)["stock"], "factors": FACTORS, "new_wheel_factors": FACTORS}.items():
        if key in table and not content.allows(table[key]):
            raise wrong(f"parts.{key}", table[key], content.legal, JobError)
    own = None
    if "part" in table:
        if not part.keys() >= set(keys(Part, required=True)):  # the stations give the missing keys
            raise JobError(PART_AT_STATION, "parts.part")
        differing = sub_table(table, "part", keys(Part), JobError, "parts.part")
        own = _part({**part, **_with_material(differing, {}, catalogue)})
    return PartConditions(**{**table, "part": own})


def _with_material(table: TomlTable, setup: TomlTable, catalogue: Catalogue) -> TomlTable:
    if "material" not in table:
        return table
    return {**table, "material": entry_of(catalogue, "part.material", table["material"], setup, JobError)}
