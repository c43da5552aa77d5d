"""Exit of a command: an error is one line and an exit status, never a traceback."""

import errno
import os
import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

from grind_env.errors import GrindError, GrindWarning
from grind_env.message_text import printable

BAD_INPUT = 2
INTERRUPTED = 128 + signal.SIGINT
#: exit status if the reader closes the pipe, as for any command that SIGPIPE ends; this is no error
CLOSED_PIPE = 128 + 13


@contextmanager
def command(name: str) -> Iterator[None]:
    """Run a command: bad input, or output that cannot be written, is one line on standard error and exit status 2.

    An interrupt ends the command without a message.
    """
    try:
        try:
            with _warnings_in_one_line(name):
                yield
        finally:
            _flush()
    except GrindError as error:
        _end(error.status, f"{name}: {error}")
    except OSError as error:
        if error.errno == errno.EPIPE:
            _end(CLOSED_PIPE)
        output = error.filename is None and error.strerror is not None
        _end(BAD_INPUT, f"{name}: {f'the output cannot be written ({error.strerror})' if output else error}")
    except SystemExit as end:
        if isinstance(end.__context__, BrokenPipeError):  # Typer and Rich turn a broken pipe into an ordinary exit
            _end(CLOSED_PIPE)
        raise
    except KeyboardInterrupt:
        _end(INTERRUPTED)


@contextmanager
def _warnings_in_one_line(name: str) -> Iterator[None]:
    """Print each warning of the package once, without its place in the code."""
    others, told = warnings.showwarning, set()

    def show(message: Warning | str, category: type[Warning], *place: Any, **line: Any) -> None:
        if not issubclass(category, GrindWarning):
            others(message, category, *place, **line)
        elif str(message) not in told:
            told.add(str(message))
            print(printable(f"{name}: warning: {message}"), file=sys.stderr)

    with warnings.catch_warnings():
        warnings.simplefilter("always", GrindWarning)
        warnings.showwarning = show
        yield


def _flush() -> None:
    if sys.stdout is not None:  # a caller may have closed it
        sys.stdout.flush()


def _end(status: int, message: str = "") -> NoReturn:
    """End the process; output that cannot be written is discarded, or Python would complain about it at exit."""
    with suppress(OSError):
        if message:
            print(printable(message), file=sys.stderr)
    try:
        _flush()
    except OSError:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
    sys.exit(status)
