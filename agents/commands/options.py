"""Options of several commands, and the exit status after Ctrl-C."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from grind_env.arguments import PROBLEM
from grind_env.terminal import INTERRUPTED

TASKS = "--tasks", "--task", "--env", "--program"
Tasks = Annotated[
    str | None,
    typer.Option(*TASKS, help="core, all, or tasks, ids, task files, part programs with commas between."),
    PROBLEM,
]
"""What each command has by default, its own help says."""


@contextmanager
def going_on(fresh: bool = False) -> Iterator[None]:
    """Say after Ctrl-C that the command goes on where it was, without `--fresh` if it was given."""
    try:
        yield
    except KeyboardInterrupt:
        again = "the same command without --fresh" if fresh else "the same command"
        print(f"agents: interrupted; {again} goes on where it was", file=sys.stderr)
        raise typer.Exit(INTERRUPTED) from None
