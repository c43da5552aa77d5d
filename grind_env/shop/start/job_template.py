"""The job file with every key: values of an example, and defaults in comments."""

import json
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from grind_env.envs.tasks.schema import SchemaRow
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.pages.job_fields import STAGES, STATIONS, job_rows
from grind_env.toml import read_toml

EXAMPLE = EXAMPLES / "plate_g82"  #: program and job that `grind init` copies, without the endings of their names
WIDTH = 110

HEAD = """\
# Job of a part program: what is ground on which machine, and what a good part is. `grind run part.nc` looks for it
# under the name part.toml. A key behind a # has the default that stands there; take the # away to change it."""

REPEATED = (STAGES, STATIONS)  #: tables that may occur several times


def job_template(given: Mapping[str, Any] | None = None) -> str:
    """Return the text of a job file with every key; `given` are its values by table, by default the example's."""
    values = example_values() if given is None else given
    blocks = [HEAD]
    for table, listed in groupby(job_rows(), key=lambda row: row.table):
        blocks.append("\n".join(_table(table, list(listed), values.get(table, {}))))
    return "\n\n".join(blocks) + "\n"


def example_values() -> Mapping[str, Any]:
    """Return the values of the example's job, by table."""
    return read_toml(EXAMPLE.with_suffix(".toml"))


def _table(name: str, rows: Sequence[SchemaRow], given: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of a table; without values its heading is a comment if the table would lack a required key."""
    out = "" if given or not (name in REPEATED or any(row.required for row in rows)) else "#"
    if name:
        yield f"{out}{f'[[{name}]]' if name in REPEATED else f'[{name}]'}"
    for row in rows:
        yield from textwrap.wrap(f"{row.meaning} ({row.holds})", WIDTH, initial_indent="# ", subsequent_indent="#   ")
        if row.key in given:
            yield f"{row.key} = {json.dumps(given[row.key])}"
        else:
            yield f"#{row.key} = {'' if row.default is None else json.dumps(row.default)}".rstrip()
