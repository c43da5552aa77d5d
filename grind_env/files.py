"""Files of a user: read only as far as memory allows, and written whole or not at all."""

import io
import os
import select
import stat
import tempfile
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import BinaryIO

from grind_env.errors import GrindError, shortened

MOST_BYTES = 64_000_000
"""Bytes that are read of a file; a part program of three million blocks is no longer."""
PATIENCE = 1.0
"""s; how long a pipe without a writer is given to find one."""
CHUNK = 1 << 16
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""What a spreadsheet takes for the beginning of a formula."""
LONGEST_PATH = 200
"""Characters that a message shows of a path."""


class FileError(GrindError):
    """A file that cannot be written."""


class ReadError(GrindError):
    """A file that cannot be read.

    Attributes:
        reason: why, for a message that says what is to be named in its place.
    """

    def __init__(self, path: Path, reason: str) -> None:
        self.reason = reason
        super().__init__(f"{shown(path)} cannot be read ({reason})")


def shown(path: Path | str) -> str:
    """A path as a message shows it."""
    return shortened(str(path), LONGEST_PATH)


def is_file(path: Path) -> bool:
    """Whether there is a file; there is none of a name that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def open_file(path: Path) -> BinaryIO:
    """Open a file for reading without ever waiting for it; a pipe is read into memory as long as it has a writer.

    Raises:
        ReadError: it is not there, is too long, or neither a file nor a pipe that someone writes to.
    """
    if "\0" in str(path):
        raise ReadError(path, "no file can have this name")
    with ExitStack() as opened:
        try:
            raw = opened.enter_context(io.FileIO(path, opener=_open_at_once))
            status = os.fstat(raw.fileno())
            if stat.S_ISFIFO(status.st_mode):
                return io.BytesIO(_received(raw, path))
        except OSError as error:
            raise ReadError(path, error.strerror or "not readable") from None
        if not stat.S_ISREG(status.st_mode):
            raise ReadError(path, "it is a device")
        if status.st_size > MOST_BYTES:
            raise _too_long(path, MOST_BYTES)
        opened.pop_all()
        return io.BufferedReader(raw)


def contents(file: BinaryIO, path: Path, most: int = MOST_BYTES) -> bytes:
    """What an opened file holds.

    Raises:
        ReadError: it cannot be read, or holds more than `most` bytes.
    """
    try:
        data = file.read(most + 1) or b""  # None of a file that the system has yet to write
    except OSError as error:
        raise ReadError(path, error.strerror or "not readable") from None
    if len(data) > most:
        raise _too_long(path, most)
    return data


def read_bytes(path: Path, most: int = MOST_BYTES) -> bytes:
    """What a file or a pipe holds, `most` bytes or fewer; errors as of `open_file`."""
    with open_file(path) as file:
        return contents(file, path, most)


def read_text(path: Path) -> str:
    """The text in UTF-8 that a file holds, with or without a byte order mark.

    Raises:
        ReadError: it cannot be read, is too long, or is not in UTF-8.
    """
    try:
        return read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ReadError(path, f"its byte {error.start + 1} is not text in UTF-8") from None


def csv_cell(value: object) -> object:
    """A cell of a CSV file as a spreadsheet may open it: a text that it would take for a formula gets an apostrophe."""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value


def check_target(path: Path, read: Iterable[Path] = ()) -> None:
    """Find out whether there may be a file of this name, such as before long work that ends in it.

    Args:
        path: the file.
        read: files that the work reads, which it must not write over.

    Raises:
        FileError: its folder does not exist, or it is a folder itself or one of the files that are read.
    """
    if not path.parent.is_dir():
        raise FileError(f"{path}: there is no folder {path.parent}; make it first")
    if path.is_dir():
        raise FileError(f"{path} is a folder; name a file")
    if any(is_file(each) and is_file(path) and path.samefile(each) for each in read):
        raise FileError(f"{path} is read here and would be lost; name another file to write")


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write(temporary path)` make a file beside `path`, and move it there.

    Raises:
        FileError: the folder does not exist or cannot be written to.
    """
    check_target(path)
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".grind-") as folder:
            temporary = Path(folder) / path.name
            write(temporary)
            temporary.replace(path)
    except OSError as error:
        raise FileError(f"{path} cannot be written: {error.strerror or error}") from None


def _open_at_once(path: str, flags: int) -> int:
    """Open a file; one of another kind, such as a pipe, without waiting for who is at its other end."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _received(pipe: io.FileIO, path: Path) -> bytes:
    """All that comes out of a pipe until its writers have gone; one that has none is given a while to find one."""
    data, watch, waited = bytearray(), select.poll(), False
    watch.register(pipe, select.POLLIN)
    while len(data) <= MOST_BYTES:
        piece = pipe.read(CHUNK)
        if piece is None:  # its writer has nothing to say yet
            watch.poll()
        elif piece:
            data += piece
        elif data or watch.poll(0):  # its writers have gone
            return bytes(data)
        elif waited:
            raise ReadError(path, "nobody writes to this pipe")
        else:
            watch.poll(1000.0 * PATIENCE)
            waited = True
    raise _too_long(path, MOST_BYTES)


def _too_long(path: Path, most: int) -> ReadError:
    return ReadError(path, f"it has more than {most / 1e6:g} MB")
