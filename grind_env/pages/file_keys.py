"""The page of all keys of job, catalogue and task files."""

from collections.abc import Sequence
from itertools import groupby

from grind_env.data_table import Column, table_of
from grind_env.envs.tasks import schema
from grind_env.envs.tasks.schema import SchemaRow
from grind_env.pages.catalogue_fields import keys_of, preface, remark_on
from grind_env.pages.job_fields import STAGES, STATIONS, job_rows
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

KEYS = (
    Column("key", lambda each: f"`{each.key}`"),
    Column("symbol", "symbol"),
    Column("unit", lambda each: each.unit or None),
    Column("range", "legal"),
    Column("default", lambda each: each.default or "required"),
    Column("meaning", "meaning"),
)
ROWS = (
    Column("key", lambda row: f"`{row.key}`"),
    Column("unit", lambda row: (row.content.quantity and row.content.quantity.unit) or None),
    Column("holds", "holds"),
    Column("", "otherwise"),
    Column("meaning", "meaning"),
)


def fields_page() -> str:
    """Return the page, Markdown."""
    known = load_catalogue()
    lines = ["# Fields of jobs, catalogues and tasks", "## Job", JOB, *_tables(job_rows()), "## Catalogue", CATALOGUE]
    for kind, entry in KINDS.items():
        names = [(f"`{name}`", remark_on(kind, name) or "–") for name in getattr(known, f"{kind}s")]
        lines += [f"### [{kind}.NAME]", *filter(None, [preface(kind)])]
        lines += [table_of(KEYS, keys_of(entry)).markdown(), table_of(("entry", ""), names).markdown()]
    lines += ["## Task", TASK, *_tables(schema.rows())]
    return "\n\n".join(lines) + "\n"


def _tables(rows: Sequence[SchemaRow]) -> list[str]:
    lines = []
    for name, listed in groupby(rows, key=lambda row: row.table):
        heading = f"[[{name}]]" if name in ("kind", STAGES, STATIONS) else f"[{name}]" if name else "Above all tables"
        lines += [f"### {heading}", table_of(ROWS, listed).markdown()]
    return lines
