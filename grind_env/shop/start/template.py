"""A job file with every key: those with a value stand as they are, all others are remarks with their defaults."""

import json
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from grind_env.envs.tasks.schema import SchemaRow
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.pages.job_fields import STAGES, STATIONS, job_rows
from grind_env.toml import read_toml

EXAMPLE = "plate_g82"
"""The program and the job that beginners get."""

WIDTH = 110

HEAD = """\
# Job of a part program: what is ground on which machine, and what a good part is. `grind run part.nc` looks for it
# under the name part.toml. A key behind a # has the default that stands there; take the # away to change it."""

Values = Mapping[str, Any]
"""Keys that are given, by table."""

REPEATED = (STAGES, STATIONS)
"""Tables of which there may be several."""


def job_template(given: Values | None = None) -> str:
    """The text of a job file that `load_job` reads."""
    values = example_values() if given is None else given
    blocks = [HEAD]
    for table, listed in groupby(job_rows(), key=lambda row: row.table):
        blocks.append("\n".join(_table(table, list(listed), values.get(table, {}))))
    return "\n\n".join(blocks) + "\n"


def example_values() -> Values:
    """The values of the example's job, by table."""
    return read_toml(EXAMPLES / f"{EXAMPLE}.toml")


def _table(name: str, rows: Sequence[SchemaRow], given: Mapping[str, Any]) -> Iterator[str]:
    """A table; one that is left out is a remark as a whole if some key of it would be missing."""
    out = "" if given or not (name in REPEATED or any(row.required for row in rows)) else "#"
    if name:
        yield f"{out}{f'[[{name}]]' if name in REPEATED else f'[{name}]'}"
    for row in rows:
        yield from textwrap.wrap(f"{row.meaning} ({row.holds})", WIDTH, initial_indent="# ", subsequent_indent="#   ")
        if row.key in given:
            yield f"{row.key} = {json.dumps(given[row.key])}"
        else:
            yield f"#{row.key} = {'' if row.default is None else json.dumps(row.default)}".rstrip()
