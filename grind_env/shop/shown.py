"""What a search and a sweep print: tables of texts, then sentences."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rich.console import Console


class Shown(NamedTuple):
    """A table."""

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str = ""
    left: int = 0
    """Columns of texts, which come first."""


def print_shown(console: "Console", tables: Iterable[Shown], sentences: Iterable[str]) -> None:
    """Print tables, and sentences below them."""
    from rich.box import SIMPLE
    from rich.table import Column, Table

    for shown in tables:
        columns = [
            Column(heading, justify="left" if k < shown.left else "right", no_wrap=True)
            for k, heading in enumerate(shown.headings)
        ]
        table = Table(*columns, title=shown.title or None, title_justify="left", box=SIMPLE, pad_edge=False)
        for row in shown.rows:
            table.add_row(*row)
        console.print(table)
    for sentence in sentences:
        console.print(sentence, highlight=False, soft_wrap=True)
