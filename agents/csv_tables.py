"""Result tables of `python -m agents`, which replace only tables of the same command in a folder."""

import csv
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar, get_type_hints

from grind_env.files import read_text
from grind_env.output_checks import FileKind, check_replaceable

RowT = TypeVar("RowT")


def check_tables(folder: Path, command: str, begins: Mapping[str, str]) -> None:
    """Raise an error if a file has the name of a table of the command, but is no such table."""
    for name, begin in begins.items():
        own = FileKind(f"table of `python -m agents {command}`", re.compile(re.escape(begin.encode())).match)
        check_replaceable(folder / name, own, "--results")


def csv_of(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table as CSV, with unrounded cells."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue()


def csv_rows(path: Path) -> list[dict[str, str]]:
    """Return the rows of a table, by the names of its columns; raise the errors of `read_text`."""
    return list(csv.DictReader(io.StringIO(read_text(path), newline="")))


def typed(kind: type[RowT], row: Mapping[str, str]) -> RowT:
    """Return a row of a table as a dataclass; the types of its fields convert the texts of the cells."""
    return kind(**{name: read(row[name]) for name, read in get_type_hints(kind).items()})
