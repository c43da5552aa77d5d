"""Output of commands: tables, and progress in a terminal."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

UNBROKEN = 100_000  #: width of the output in a pipe or file, columns; no table or sentence is as wide


def table_console() -> "Console":
    """Return the console for tables: fitted to a terminal; in a pipe or file each row is one line."""
    from rich.console import Console

    made = Console(markup=False, highlight=False)
    if not made.file.isatty():
        made.width = UNBROKEN
    return made


@contextmanager
def progress(total: int | None = None, most: str = "") -> Iterator[Callable[[str, int], None]]:
    """Show counts on standard error in a terminal; `advance(what, count)` adds to one of the counts.

    `total` is the total of each count, if known; `most` is a text behind the counts.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    console, tasks = Console(stderr=True), dict[str, TaskID]()
    with Progress(
        *columns, TextColumn(most), console=console, transient=True, disable=not console.is_terminal
    ) as shown:

        def advance(what: str, count: int) -> None:
            if what not in tasks:
                tasks[what] = shown.add_task(what, total=total)
            shown.advance(tasks[what], count)

        yield advance
