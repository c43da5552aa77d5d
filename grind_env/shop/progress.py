"""How far a search or a sweep has come, on standard error."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress(seconds: float = math.inf) -> Iterator[Callable[[str, int], None]]:
    """Show a count for each thing that is being done, if somebody looks on; `advance(what, count)` adds to it."""
    from rich.console import Console
    from rich.progress import Progress, ProgressColumn, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn

    columns: tuple[ProgressColumn, ...] = (
        SpinnerColumn(),
        TextColumn("{task.description}: {task.completed:.0f}"),
        TimeElapsedColumn(),
    )
    if math.isfinite(seconds):
        columns = (*columns, TextColumn(f"of {seconds:g} s"))
    tasks: dict[str, TaskID] = {}
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as shown:

        def advance(what: str, count: int) -> None:
            if what not in tasks:
                tasks[what] = shown.add_task(what, total=None)
            shown.advance(tasks[what], count)

        yield advance
