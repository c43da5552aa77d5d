"""Files of a cell on the way between this machine and a node: whole, by their names below a folder."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path, PurePath

from grind_env.errors import quoted
from grind_env.files import FileError, shown, write_atomically

Parcel = dict[str, bytes | None]
"""Contents by name; None of a file that has been removed."""
Stamp = tuple[int, int, int]


def packed(folder: Path, patterns: Iterable[str]) -> Parcel:
    """The files of a folder that patterns name, as in `Path.glob`; not unfinished ones, which begin with a dot."""
    found: Parcel = {}
    for path in _named(folder, patterns):
        # what is removed meanwhile is not there
        with suppress(FileNotFoundError):
            found[path.relative_to(folder).as_posix()] = path.read_bytes()
    return found


def unpack(parcel: Parcel, folder: Path) -> None:
    """Write the files, each whole or not at all, and remove those that are gone.

    Raises:
        FileError: a file cannot be written, or would lie outside the folder.
    """
    for name, content in parcel.items():
        below = PurePath(name)
        if below.anchor or ".." in below.parts:
            raise FileError(f"{quoted(name)}, which a cell sends, leads out of {shown(folder)}: it is not written")
        path = folder / below
        if content is None:
            path.unlink(missing_ok=True)
            continue
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, partial(_write, content))


def _write(content: bytes, unfinished: Path) -> None:
    unfinished.write_bytes(content)


class Outbox:
    """What changes among the files that patterns name, since it was asked for last.

    Args:
        folder: where they lie; what lies there now is no change.
        patterns: as those of `packed`.
    """

    def __init__(self, folder: Path, patterns: Iterable[str]) -> None:
        self._folder, self._patterns = folder, tuple(patterns)
        self._sent = self._stamps()

    def changes(self) -> Parcel:
        """The files that are new or other than before, and the names of those that are gone."""
        stamps = self._stamps()
        changed: Parcel = dict.fromkeys(self._sent.keys() - stamps.keys())
        for name in stamps:
            if stamps[name] != self._sent.get(name):
                with suppress(FileNotFoundError):
                    changed[name] = (self._folder / name).read_bytes()
        self._sent = stamps
        return changed

    def _stamps(self) -> dict[str, Stamp]:
        stamps: dict[str, Stamp] = {}
        for path in _named(self._folder, self._patterns):
            with suppress(FileNotFoundError):
                status = path.stat()
                stamps[path.relative_to(self._folder).as_posix()] = (
                    status.st_mtime_ns,
                    status.st_size,
                    status.st_ino,
                )
        return stamps


def _named(folder: Path, patterns: Iterable[str]) -> Iterator[Path]:
    for pattern in patterns:
        yield from (path for path in folder.glob(pattern) if path.is_file() and not _unfinished(path, folder))


def _unfinished(path: Path, folder: Path) -> bool:
    return any(part.startswith(".") for part in path.relative_to(folder).parts)
