"""Result tables of `python -m agents`, which replace only tables of the same command in a folder."""

import csv
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar, get_type_hints

from grind_env.files import read_text
from grind_env.targets import Own, check_own

RowT = TypeVar("RowT")


def check_tables(folder: Path, command: str, begins: Mapping[str, str]) -> None:
    """Refuse a folder in which a file that is no table of the command has the name of one."""
    for name, begin in begins.items():
        own = Own(f"table of `python -m agents {command}`", re.compile(re.escape(begin.encode())).match)
        check_own(folder / name, own, "--results")


def csv_of(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table as CSV, its cells as they are."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue()


def csv_rows(path: Path) -> list[dict[str, str]]:
    """Rows of a table, by the names of its columns; errors as of `read_text`."""
    return list(csv.DictReader(io.StringIO(read_text(path), newline="")))


def typed(kind: type[RowT], row: Mapping[str, str]) -> RowT:
    """Return a row of a table as a dataclass, whose types read the texts of its cells."""
    return kind(**{name: read(row[name]) for name, read in get_type_hints(kind).items()})
