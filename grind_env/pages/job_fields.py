"""All keys of a job file, from its dataclasses."""

from collections.abc import Mapping

from grind_env.envs.tasks.schema import FILES, SchemaRow, rows_of
from grind_env.machine.job import Diamond, Lots, Part, Setup, Stage, Station, Times, WheelStart
from grind_env.process.catalogue import KINDS, USUAL
from grind_env.process.toml_tables import Content

STAGES = "part.stages"  #: a table for each stage, headed `[[part.stages]]`

STATIONS = "stations"  #: a table for each station, headed `[[stations]]`

NUMBER, BESIDE = "its number", "beside these any key of [part] in which it differs"
PLANT = "name of the out-of-model machine that grinds: meter:7, foreign:3+meter:7, held-out:5"
MATERIAL = "work material: the name of an entry of the catalogue"


def job_rows() -> list[SchemaRow]:
    """Return all keys, table by table."""
    known = {row.key: row.meaning for row in rows_of(STATIONS, Station)}
    text, numbers = Content(str, str), Content(Mapping, float)
    names = [
        SchemaRow("setup", kind, text, f"{kind}: the name of an entry of the catalogue", USUAL[kind]) for kind in USUAL
    ]
    overrides = [
        SchemaRow("setup", f"{kind}_overrides", numbers, f"single values of the {kind} that differ from its entry")
        for kind in KINDS
    ]
    return [
        SchemaRow("", "plant", text, PLANT, derived="the model"),
        SchemaRow("part", "material", text, MATERIAL, required=True),
        *rows_of("part", Part),
        *rows_of(STAGES, Stage),
        SchemaRow(STATIONS, "name", text, f"{known['name']}; {BESIDE}", derived=NUMBER),
        *(row for row in rows_of(STATIONS, Station) if row.key != "name"),
        *names,
        *rows_of("setup", Setup),
        *overrides,
        *rows_of("times", Times),
        *rows_of("wheel", WheelStart),
        *rows_of("diamond", Diamond),
        *rows_of("lots", Lots),
        SchemaRow("catalogue", "files", Content(tuple, str), FILES),
    ]
