"""The page of all that may stand in the files of a user: jobs, catalogues and tasks."""

from collections.abc import Sequence
from itertools import groupby

from grind_env.envs.tasks import schema
from grind_env.envs.tasks.schema import Row
from grind_env.pages.catalogue_fields import keys_of, preface, remark_on
from grind_env.pages.job_fields import STAGES, STATIONS, job_rows
from grind_env.pages.markdown import table
from grind_env.process.catalogue import KINDS, load_catalogue

FILE = "fields.md"

JOB = """\
A job says what is ground on which machine, and what a good part is. `grind run part.nc` looks for it beside the
program, `grind job --template` prints one with all keys."""

CATALOGUE = """\
Entries stand in tables `[KIND.NAME]` of a file that a job or a task names under `[catalogue] files`. An entry gives
every key without a default, or names as `base` an entry that supplies the rest. `grind catalogue` lists what there is,
`grind catalogue wheel a60j` shows an entry."""

TASK = """\
A task is what an environment of cycle blocks draws and asks for: `gym.make("grind/Task-v0", task="shop.toml")`. Beside
these tables it may hold catalogue entries. `grind tasks shop.toml` prints it with its defaults."""


def fields_page() -> str:
    """The page, Markdown."""
    known = load_catalogue()
    lines = ["# Fields of jobs, catalogues and tasks", "## Job", JOB, *_tables(job_rows()), "## Catalogue", CATALOGUE]
    for kind, entry in KINDS.items():
        names = [(f"`{name}`", remark_on(kind, name) or "–") for name in getattr(known, f"{kind}s")]
        keys = [
            (f"`{each.key}`", each.symbol, each.unit or "–", each.legal, each.default or "required", each.meaning)
            for each in keys_of(entry)
        ]
        lines += [f"### [{kind}.NAME]", *filter(None, [preface(kind)])]
        lines += [table(("key", "symbol", "unit", "range", "default", "meaning"), keys), table(("entry", ""), names)]
    lines += ["## Task", TASK, *_tables(schema.rows())]
    return "\n\n".join(lines) + "\n"


def _tables(rows: Sequence[Row]) -> list[str]:
    lines = []
    for name, listed in groupby(rows, key=lambda row: row.table):
        heading = f"[[{name}]]" if name in ("kind", STAGES, STATIONS) else f"[{name}]" if name else "Above all tables"
        cells = [(f"`{row.key}`", _unit(row), row.holds, row.otherwise, row.meaning) for row in listed]
        lines += [f"### {heading}", table(("key", "unit", "holds", "", "meaning"), cells)]
    return lines


def _unit(row: Row) -> str:
    quantity = row.content.quantity
    return (quantity.unit if quantity else "") or "–"
