"""Job files: TOML, with the fields of the classes in `job.py` as keys.

::

    plant = "meter:7"       # optional, above all tables: the machine, where it is not the model (`grind_env.plants`)

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
    spindle = "always on"   # set by hand: S and M03 to M05 have no effect; "by program" if left out
    coolant = "always on"   # likewise, M07 to M09
    dresser_infeed = 0.03   # mm a pass, of a dresser that advances by itself

    [diamond]               # optional: where its tip stands; without it every dress program is taken to meet it
    x = -120                # mm, like y and z; as the axes are read when the wheel is at it
    y = 10
    z = -10

    [catalogue]             # optional: the user's own catalogue, beside the job file
    files = ["shop.toml"]

    [catalogue.uncertainty] # optional: what a calibration leaves open, as the calibrated file says it

    [lots]                  # optional: how the parts of a batch differ, in `grind/Job-v0`
    probability = 0.2       # that a part begins a new lot of material
    growth = 0.6            # spread of how fast a lot dulls the wheel, like that of pressure logarithmic
    stock = 0.1             # standard deviation of the stock of a part over the nominal one

    [[stations]]            # optional, one for each part that lies on the table, if there are several
    name = "left"           # in tables and messages; "1", "2" ... if left out
    offset = "G54"          # in which its place is given; machine coordinates if left out
    origin = [0, 0, 0]      # mm, where the zero of that offset lies on the machine
    start = 20              # mm, and any other key of [part] in which it differs

    [[parts]]               # optional, one for each part that the program grinds: how it differs
    stock = 0.31            # mm, its true stock
    factors = { kA = 1.2 }  # on parameters of the process model: a lot that dulls the wheel faster
    part = { length = 150 } # of a part of another kind, what differs from [part]

Tables `[times]` and `[wheel]` are optional too.

For grooves, `length` is what each infeed grinds (the circumference of a turning part) and `surface` the coordinate
at which the tool touches the part. Without `grooving_wheel` a turning tool cuts them: they take their time and leave
the wheel and the stock as they are. A program of grooves alone is judged by them: `stock` is then their depth,
`tolerance` and `roughness_limit` are those of their bottom.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grind_env.errors import shortened
from grind_env.files import ReadError, beside, is_file, missing, shown
from grind_env.machine.job.job import (
    PART_AT_STATION,
    Diamond,
    Job,
    JobError,
    Lots,
    Part,
    PartConditions,
    Setup,
    Stage,
    Station,
    Times,
    WheelStart,
    wrong,
)
from grind_env.machine.job.uncertainty import Uncertainty, uncertainty_of
from grind_env.process.catalogue import USUAL, Catalogue
from grind_env.process.entries import CatalogueError, Entry, Quantity
from grind_env.process.tables import (
    Content,
    TomlTable,
    checked,
    contents,
    keys,
    refuse_missing,
    refuse_unknown,
    sub_table,
)
from grind_env.process.user_catalogue import OVERRIDES, catalogue_of, entry_of
from grind_env.toml import TomlError, read_toml

if TYPE_CHECKING:
    from grind_env.plants import Plant

KEYS = "plant", "part", "setup", "times", "wheel", "lots", "diamond", "catalogue", "parts", "stations"
VALUES = tuple(contents(Setup))
"""Keys of `[setup]` that are no entries of the catalogue."""
WRITE_ONE = "write one: `grind job --template` prints a job, and `grind init FOLDER` makes a program with its job"
FACTORS = Content(Mapping, float, quantity=Quantity("", "", 1e-9, 1e9))


def job_beside(program: Path) -> Path:
    """The job of a program for which none is named: the file of its name with `.toml`.

    Raises:
        JobError: there is none.
        ReadError: there is no program either.
    """
    path = beside(program, ".toml")
    if not is_file(path):
        if not program.exists():
            raise missing(program)
        raise JobError(f"there is no job {shown(path)} beside the program; name one with --job, or {WRITE_ONE}")
    return path


def job_of(program: Path, job: str | Path | Job | None) -> Job:
    """The job by its file or as it is held; that beside a program if None. Errors as of `load_job`."""
    if isinstance(job, Job):
        return job
    return load_job(job_beside(program) if job is None else job)


def load_job(path: str | Path, *, plant: "Plant | None" = None, calibrated: bool = True) -> Job:
    """Read a job file.

    Args:
        path: of the file.
        plant: the machine, in place of that of the file.
        calibrated: whether calibrated catalogue files of it are read.

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
    try:
        job = _job(document, path.parent, calibrated)
        if plant is None and "plant" in document:
            plant = _plant(document["plant"])
    except JobError as error:
        raise JobError(error.message, error.key, error.found, error.legal, str(path)) from None
    return job if plant is None else job.on(plant)


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
    times = sub_table(document, "times", keys(Times), JobError)
    wheel = sub_table(document, "wheel", keys(WheelStart), JobError)
    lots = sub_table(document, "lots", keys(Lots), JobError)
    diamond = sub_table(document, "diamond", keys(Diamond), JobError)
    catalogue = catalogue_of(document, folder, JobError, calibrated=calibrated)

    lying = _tables(document, "stations")
    if not lying:
        refuse_missing(part, Part, "part", JobError)
    if "diamond" in document:
        refuse_missing(diamond, Diamond, "diamond", JobError)
    names = {"part.material": part["material"]} if "material" in part else {}
    names |= {f"setup.{kind}": setup.get(kind, default) for kind, default in USUAL.items()}
    entries = {key: entry_of(catalogue, key, name, setup, JobError) for key, name in names.items()}
    if "part.material" in entries:
        part = {**part, "material": entries["part.material"]}
    stations = tuple(_station(number, table, part, catalogue) for number, table in enumerate(lying, 1))
    return Job(
        part=stations[0].part if stations else _part(part),
        setup=Setup(
            **{kind: entries[f"setup.{kind}"] for kind in USUAL},
            **{key: setup[key] for key in VALUES if key in setup},
        ),
        times=Times(**times),
        wheel=WheelStart(**wheel),
        lots=Lots(**lots),
        diamond=Diamond(**diamond) if "diamond" in document else None,
        parts=_parts(document, part, catalogue),
        stations=stations,
        uncertainty=_uncertainty(catalogue, {key.rpartition(".")[2]: entry for key, entry in entries.items()}),
    )


def _uncertainty(catalogue: Catalogue, entries: Mapping[str, Entry]) -> Uncertainty | None:
    """What the calibration of these entries, by kind, leaves open; None where that was of others, or there is none."""
    found = catalogue.calibrated
    if found is None or any(kind in entries and entries[kind].name not in names for kind, names in found.names.items()):
        return None
    try:
        return uncertainty_of(found.table)
    except CatalogueError as error:
        place = "catalogue.files" if found.file else "catalogue"
        raise JobError(f"{place}: {f'{shown(Path(found.file))}: ' if found.file else ''}{error}", place) from None


def _tables(document: TomlTable, name: str) -> list[object]:
    found = document.get(name, [])
    if not isinstance(found, list):
        raise wrong(name, found, f"tables, each headed [[{name}]]")
    return found


def _part(table: TomlTable) -> Part:
    place, found = "part.stages", table.get("stages", [])
    if not isinstance(found, list):
        raise wrong(place, found, f"tables, each headed [[{place}]]")
    stages = tuple(_stage(number, {place: stage}, place) for number, stage in enumerate(found, 1))
    return Part(**{**table, "stages": stages})


def _station(number: int, table: object, part: TomlTable, catalogue: Catalogue) -> Station:
    """A station, whose part differs from the one in the table `part`, which has its material already if it has one."""
    place = tuple(contents(Station))
    name = table.get("name", str(number)) if isinstance(table, Mapping) else number
    try:
        table = checked(table, "stations", (*place, *keys(Part)), JobError)
        own = {key: value for key, value in table.items() if key not in place}
        if "material" in own:
            own["material"] = entry_of(catalogue, "part.material", own["material"], {}, JobError)
        refuse_missing({**part, **own}, Part, "part", JobError)
        lies: dict[str, Any] = {key: table[key] for key in place if key in table}
        if isinstance(lies.get("origin"), list):
            lies["origin"] = tuple(lies["origin"])
        return Station(**{"name": str(number), **lies, "part": _part({**part, **own})})
    except JobError as error:
        message = f"station {shortened(str(name))}: {error.message}"
        raise JobError(message, error.key, error.found, error.legal) from None


def _parts(document: TomlTable, part: TomlTable, catalogue: Catalogue) -> tuple[PartConditions, ...]:
    """How each part differs from the one in the table `part`, which has its material already."""
    parts = []
    for number, table in enumerate(_tables(document, "parts"), 1):
        try:
            parts.append(_conditions(checked(table, "parts", keys(PartConditions), JobError), part, catalogue))
        except JobError as error:
            raise JobError(f"part {number}: {error.message}", error.key, error.found, error.legal) from None
    return tuple(parts)


def _conditions(table: TomlTable, part: TomlTable, catalogue: Catalogue) -> PartConditions:
    for key, content in {"stock": contents(Part)["stock"], "factors": FACTORS, "new_wheel_factors": FACTORS}.items():
        if key in table and not content.allows(table[key]):
            raise wrong(f"parts.{key}", table[key], content.legal)
    own = None
    if "part" in table:
        if not part.keys() >= set(keys(Part, required=True)):  # it is that of the stations to say what is missing
            raise JobError(PART_AT_STATION, "parts.part")
        differing = dict(sub_table(table, "part", keys(Part), JobError, "parts.part"))
        if "material" in differing:
            differing["material"] = entry_of(catalogue, "part.material", differing["material"], {}, JobError)
        own = _part({**part, **differing})
    return PartConditions(**{**table, "part": own})


def _stage(number: int, parent: TomlTable, place: str) -> Stage:
    try:
        table = sub_table(parent, place, keys(Stage), JobError)
        refuse_missing(table, Stage, place, JobError)
        return Stage(**table)
    except JobError as error:
        raise JobError(f"stage {number}: {error.message}", error.key, error.found, error.legal) from None
