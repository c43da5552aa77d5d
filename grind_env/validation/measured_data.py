"""The measured and published data of the package; `data/README.md` lists the sources."""

import csv
from pathlib import Path

DATA = Path(__file__).with_name("data")


def rows(name: str, folder: Path = DATA) -> list[dict[str, str]]:
    """Return the rows of `NAME.csv`, text by column."""
    with (folder / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
