"""Files that are written whole or not at all."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from grind_env.errors import GrindError


class FileError(GrindError):
    """A file that cannot be written."""


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write(temporary path)` make a file beside `path`, and move it there.

    Raises:
        FileError: the folder does not exist or cannot be written to.
    """
    if not path.parent.is_dir():
        raise FileError(f"{path}: there is no folder {path.parent}; make it first")
    if path.is_dir():
        raise FileError(f"{path} is a folder; name a file")
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".grind-") as folder:
            temporary = Path(folder) / path.name
            write(temporary)
            temporary.replace(path)
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror or error}") from None
