"""The rows as a CSV file."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path

from grind_env.files import csv_cell, write_atomically
from grind_env.validation import GROUPS, Row
from grind_env.validation.report import reason, verdict

COLUMNS = (
    *("group", "name", "what", "at", "evidence", "source", "reference", "predicted", "low", "high", "unit"),
    *("verdict", "reason", "outside limits"),
)


def write_csv(rows: Sequence[Row], path: Path) -> None:
    """Write a line for each row, numbers to six digits; a cell is empty where there is no number.

    Raises:
        FileError: the folder does not exist or cannot be written to.
    """
    write_atomically(path, lambda temporary: _write(rows, temporary))


def _write(rows: Sequence[Row], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows(map(csv_cell, _cells(row)) for row in rows)


def _cells(row: Row) -> tuple[object, ...]:
    check = row.check
    return (
        *(GROUPS[check.group], check.name, check.what, check.at, check.basis.evidence.name.lower(), check.basis.text),
        *map(_digits, (check.reference, row.value, check.band.low, check.band.high)),
        *(check.unit, verdict(row), reason(row), "; ".join(map(str, row.outside))),
    )


def _digits(value: float | None) -> float | None:
    return float(f"{value:.6g}") if value is not None and math.isfinite(value) else None
