"""What Ctrl-C ends commands with whose work is kept: a sentence, and the exit status of the shell for it."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from grind_env.terminal import INTERRUPTED


@contextmanager
def going_on(fresh: bool = False) -> Iterator[None]:
    """Work that Ctrl-C may end.

    Args:
        fresh: the command throws away what is kept; without that it goes on.
    """
    try:
        yield
    except KeyboardInterrupt:
        again = "the same command without --fresh" if fresh else "the same command"
        print(f"agents: interrupted; {again} goes on where it was", file=sys.stderr)
        raise typer.Exit(INTERRUPTED) from None
