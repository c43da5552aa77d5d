"""A file that one process at a time holds, whatever becomes of the process."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

if sys.platform != "win32":
    import fcntl


@contextmanager
def alone(path: Path, taken: Exception | None = None) -> Iterator[int]:
    """Hold the lock that a file stands for; it is open, for a process to share it, and goes in the end.

    The system takes the lock from a process that ends, however it ends. Windows has no such locks: nothing is held. If
    another process has the lock, `taken` is raised; if None, it is waited for.
    """
    if sys.platform == "win32":
        yield -1
        return
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX if taken is None else fcntl.LOCK_EX | fcntl.LOCK_NB)
            # whoever had it before has removed the file
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(descriptor), path.stat()):
                    break
        except BlockingIOError as error:
            os.close(descriptor)
            raise (taken or error) from None
        os.close(descriptor)
    try:
        yield descriptor
    finally:
        path.unlink(missing_ok=True)
        os.close(descriptor)
