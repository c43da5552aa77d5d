"""Options of several commands, and the exit status after Ctrl-C."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from grind_env.command_exit import INTERRUPTED
from grind_env.file_arguments import PROBLEM

TASKS = "--tasks", "--task", "--env", "--program"
#: option for tasks; the help of each command says its default
Tasks = Annotated[
    str | None,
    typer.Option(*TASKS, help="core, all, or tasks, ids, task files, programs, with commas."),
    PROBLEM,
]


@contextmanager
def going_on(fresh: bool = False) -> Iterator[None]:
    """Print after Ctrl-C that the same command, without `--fresh`, resumes the work."""
    try:
        yield
    except KeyboardInterrupt:
        again = "the same command without --fresh" if fresh else "the same command"
        print(f"agents: interrupted; {again} goes on where it was", file=sys.stderr)
        raise typer.Exit(INTERRUPTED) from None
