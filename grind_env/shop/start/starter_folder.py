"""The folder of `grind init`: program, job, catalogue, notebook and sample log; and the job with every key."""

import json
import tempfile
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from typing import Any

from grind_env.envs.tasks.schema import SchemaRow
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.files import FileError, read_text, shown
from grind_env.pages.job_fields import STAGES, STATIONS, job_rows
from grind_env.toml import read_toml

HERE = Path(__file__).parent
PROGRAM, JOB, CATALOGUE, NOTEBOOK, LOG = "part.nc", "part.toml", "shop.toml", "first_steps.ipynb", "log.csv"
OWN = {"wheel": "our_a60j", "machine": "our_grinder"}
"""Entries of the catalogue that the job names."""
EXAMPLE = "plate_g82"
"""Name of the example whose program and job `grind init` copies."""

WIDTH = 110

HEAD = """\
# Job of a part program: what is ground on which machine, and what a good part is. `grind run part.nc` looks for it
# under the name part.toml. A key behind a # has the default that stands there; take the # away to change it."""

Values = Mapping[str, Any]
"""Values of keys, by table."""

REPEATED = (STAGES, STATIONS)
"""Tables that may occur several times."""


def job_template(given: Values | None = None) -> str:
    """Return the text of a job file with every key; `given` are its values, by default the example's."""
    values = example_values() if given is None else given
    blocks = [HEAD]
    for table, listed in groupby(job_rows(), key=lambda row: row.table):
        blocks.append("\n".join(_table(table, list(listed), values.get(table, {}))))
    return "\n\n".join(blocks) + "\n"


def example_values() -> Values:
    """Return the values of the example's job, by table."""
    return read_toml(EXAMPLES / f"{EXAMPLE}.toml")


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


def start_folder(folder: Path) -> list[Path]:
    """Write the files into a folder, which is created if missing; return their paths, the program first."""
    example = example_values()
    job = {**example, "setup": {**example["setup"], **OWN}, "catalogue": {"files": [CATALOGUE]}}
    texts = {PROGRAM: read_text(EXAMPLES / f"{EXAMPLE}.nc"), JOB: job_template(job)}
    texts |= {name: read_text(HERE / name) for name in (CATALOGUE, NOTEBOOK, LOG)}
    paths = _require_new(folder, texts)
    made = [each for each in (folder, *folder.parents) if not _is_there(each)]
    moved = list[Path]()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".grind-") as unfinished:
            for name, text in texts.items():
                Path(unfinished, name).write_text(text, encoding="utf-8")
            for path in paths:
                Path(unfinished, path.name).replace(path)
                moved.append(path)
    except BaseException as error:
        _take_back(moved, made)
        if isinstance(error, OSError | ValueError):  # ValueError: no folder can have this name
            why = getattr(error, "strerror", None) or error
            raise FileError(f"{shown(folder)} cannot be made: {why}; make room, or name another folder") from None
        raise
    return paths


def _require_new(folder: Path, names: Iterable[str]) -> list[Path]:
    place = next((each for each in (folder, *folder.parents) if _is_there(each)), folder)
    if _is_there(place) and not place.is_dir():
        raise FileError(f"{shown(folder)} cannot be made: {shown(place)} is no folder; name another one")
    paths = [folder / name for name in names]
    for path in paths:
        if _is_there(path):
            raise FileError(f"{shown(path)} is there already, and is not overwritten; name another folder")
    return paths


def _is_there(path: Path) -> bool:
    """Return whether a name is taken, even by a broken link."""
    try:
        path.lstat()
    except (OSError, ValueError):
        return False
    return True


def _take_back(files: Sequence[Path], folders: Sequence[Path]) -> None:
    """Remove files, and then the empty ones of some folders, the innermost folder first."""
    with suppress(OSError):
        for path in files:
            path.unlink(missing_ok=True)
        for folder in folders:
            folder.rmdir()
