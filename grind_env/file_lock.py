"""A file lock for one process at a time, released when the process ends in any way."""

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

if sys.platform != "win32":
    import fcntl


@contextmanager
def alone(path: Path, taken: Exception | None = None) -> Iterator[None]:
    """Hold the lock of a file until the block ends; the system releases it if the process ends.

    If another process has the lock, raise `taken`, or wait if None. Windows has no such locks: nothing is locked there.
    """
    with ExitStack() as held:
        while sys.platform != "win32":
            file = held.enter_context(path.open("ab"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX if taken is None else fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise (taken or error) from None
            with suppress(FileNotFoundError):  # whoever had the lock before has removed the file
                if os.path.samestat(os.fstat(file.fileno()), path.stat()):
                    held.callback(path.unlink, missing_ok=True)
                    break
            held.close()
        yield
