"""The measured and published data that ship with the package; `data/README.md` says where they are from."""

import csv
from pathlib import Path

DATA = Path(__file__).with_name("data")
MAGNITUDES = "expected_magnitudes.csv: a reading of Malkin and Rowe"
"""What its orders of magnitude are."""


def rows(name: str) -> list[dict[str, str]]:
    """The rows of `data/NAME.csv`, text by column."""
    with (DATA / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def number(name: str, key: str, column: str, of: str = "id") -> float:
    """The number in `column` of the row whose `of` is `key`."""
    return next(float(row[column]) for row in rows(name) if row[of] == key)
