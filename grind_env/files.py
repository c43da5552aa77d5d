"""User files: reads are limited in size, and writes are atomic."""

import codecs
import csv
import io
import os
import select
import stat
import tempfile
from collections.abc import Callable, Iterable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import BinaryIO

from grind_env.errors import GrindError
from grind_env.message_text import closest, shortened

MOST_BYTES = 64_000_000  #: largest input file, bytes; a part program of three million blocks is no longer
PATIENCE = 1.0  #: time that a pipe without a writer may take to get one, s
AT_ONCE = getattr(os, "O_NONBLOCK", 0)  #: flag to open a pipe without waiting for a process at its other end
FORMULA = ("=", "+", "-", "@", "\t", "\r")  #: characters that begin a formula in a spreadsheet
LIKENESS = 0.8  #: least similarity of a file name to a missing one at which the name is suggested
LONGEST_PATH = 200  #: greatest number of characters of a path in a message


class FileError(GrindError):
    """File that cannot be written."""


class EncodingError(GrindError):
    """Bytes that are not text in UTF-8."""


class ReadError(GrindError):
    """File that cannot be read; `reason` says why."""

    def __init__(self, path: Path, reason: str) -> None:
        self.reason = reason
        super().__init__(f"{shown(path)} cannot be read ({reason})")


def shown(path: Path | str) -> str:
    """Return a path as a message shows it."""
    return shortened(str(path), LONGEST_PATH)


def is_file(path: Path) -> bool:
    """Return whether there is a file; False for a name that no file can have."""
    return os.path.isfile(path)  # noqa: PTH113 - the method raises an error of some names


def missing(path: Path) -> ReadError:
    """Return the error for a missing file, with a similar name beside it."""
    try:
        close = closest(path.name, (each.name for each in path.parent.iterdir()), LIKENESS)
    except (OSError, ValueError):
        close = ""
    return ReadError(path, "No such file or directory" + (f"; did you mean {shown(close)}?" if close else ""))


def open_file(path: Path) -> BinaryIO:
    """Open a file for reading without waiting; a pipe is read into memory until its writers close it.

    Raises:
        ReadError: the file is missing, too long, or neither a regular file nor a pipe with a writer.
    """
    try:
        raw = io.FileIO(path, opener=lambda name, flags: os.open(name, flags | AT_ONCE))
    except FileNotFoundError:
        raise missing(path) from None
    except OSError as error:
        raise ReadError(path, error.strerror or "not readable") from None
    except ValueError:
        raise ReadError(path, "no file can have this name") from None
    file = io.BufferedReader(raw)
    with ExitStack() as opened:
        opened.callback(file.close)
        status = os.fstat(raw.fileno())
        if stat.S_ISFIFO(status.st_mode):
            return io.BytesIO(_received(file, path))
        if not stat.S_ISREG(status.st_mode):
            raise ReadError(path, "it is a device")
        _require(path, status.st_size, MOST_BYTES)
        opened.pop_all()
        return file


def contents(file: BinaryIO, path: Path, most: int = MOST_BYTES) -> bytes:
    """Return the content of an opened file; a `ReadError` says that it is unreadable or longer than `most` bytes."""
    try:
        data = file.read(most + 1) or b""  # None if no data has arrived yet
    except OSError as error:
        raise ReadError(path, error.strerror or "not readable") from None
    _require(path, len(data), most)
    return data


def read_bytes(path: Path, most: int = MOST_BYTES) -> bytes:
    """Return the content of a file or pipe of at most `most` bytes; errors as in `open_file`."""
    with open_file(path) as file:
        return contents(file, path, most)


def read_text(path: Path) -> str:
    """Return a text file in UTF-8, with or without a byte order mark; a `ReadError` says why it cannot be read."""
    try:
        return decoded(read_bytes(path))
    except EncodingError as error:
        raise ReadError(path, str(error)) from None


def decoded(data: bytes) -> str:
    """Decode bytes as UTF-8; an `EncodingError` says where they are not UTF-8, and what to do."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) or b"\0" in data[:4]:
        raise EncodingError("it is in UTF-16, or no text at all; save it as text in UTF-8")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = len((data[: error.start] + b"?").splitlines())
        raise EncodingError(f"line {line} is not in UTF-8, but in a code such as Latin-1; save it as UTF-8") from None


def csv_cell(value: object) -> object:
    """Return a cell of a CSV file that is safe in a spreadsheet: a text like a formula gets an apostrophe."""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value


def beside(path: Path, suffix: str) -> Path:
    """Return the path with another suffix; a `FileError` says that the path ends in no name."""
    try:
        return path.with_suffix(suffix)
    except ValueError:
        raise FileError(f"{shown(path)} is no name of a file; name a file") from None


def status_of(path: Path) -> os.stat_result | None:
    """Return the status of the file or folder at a path, links followed; None if there is none yet.

    Raises:
        FileError: no file can have this name, or its links lead in a circle.
    """
    try:
        return path.stat()
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", "no file can have this name")
        raise FileError(f"{shown(path)} cannot be written: {why}; name another file") from None


def check_target(path: Path) -> None:
    """Check that a file can be written under this name, before long work.

    Raises:
        FileError: its folder does not exist, no file can have this name, or it is a folder, a device, a pipe or the
            output of this process.
    """
    status = status_of(path)
    for folder in (path.parent, path.resolve().parent) if status is None else ():
        if not folder.is_dir():
            raise FileError(f"{shown(path)}: there is no folder {shown(folder)}; make it first")
    if status is not None and stat.S_ISDIR(status.st_mode):
        raise FileError(f"{shown(path)} is a folder; name a file")
    if status is not None and (not stat.S_ISREG(status.st_mode) or any(_goes_to(status, each) for each in (1, 2))):
        raise FileError(f"{shown(path)} is a device, a pipe or the output of this command; name a file")


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file with `write(temporary path)`, then move it to `path`; a link at `path` stays and leads to the file.

    Raises:
        FileError: as in `check_target`, or the folder cannot be written to.
    """
    check_target(path)
    place = path.resolve()
    try:
        with tempfile.TemporaryDirectory(dir=place.parent, prefix=".grind-") as folder:
            temporary = Path(folder) / path.name
            write(temporary)
            temporary.replace(place)
    except OSError as error:
        raise FileError(f"{shown(path)} cannot be written: {error.strerror or error}") from None


def write_csv(path: Path, rows: Iterable[Iterable[object]]) -> None:
    """Write rows to a CSV file, each cell through `csv_cell`; errors as in `write_atomically`."""

    def write(temporary: Path) -> None:
        with temporary.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows(map(csv_cell, row) for row in rows)

    write_atomically(path, write)


def _goes_to(status: os.stat_result, descriptor: int) -> bool:
    """Return whether an output descriptor writes to the file of a status; False if the caller has closed it."""
    with suppress(OSError):
        return os.path.samestat(status, os.fstat(descriptor))
    return False


def _received(pipe: "io.BufferedReader[io.FileIO]", path: Path) -> bytes:
    """Return the content of a pipe, read until its writers close it; the first writer must come within `PATIENCE`."""
    watch = select.poll()
    watch.register(pipe, select.POLLIN)
    first = None if watch.poll(1000.0 * PATIENCE) else pipe.raw.read(1)  # None if there is a writer but no data yet
    if first == b"":
        raise ReadError(path, "nobody writes to this pipe")
    os.set_blocking(pipe.fileno(), True)
    return contents(io.BytesIO((first or b"") + pipe.read(MOST_BYTES + 1)), path, MOST_BYTES)


def _require(path: Path, length: int, most: int) -> None:
    if length > most:
        raise ReadError(path, f"it has more than {most / 1e6:g} MB")
