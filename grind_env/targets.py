"""What a command may write: no file that it reads, none twice, and under a name of its own choice only what is its own.

`check_targets` is asked before any work; `grind_env.arguments` asks it for every command.
"""

import os
import stat
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from grind_env.files import FileError, ReadError, check_target, is_stream, open_file, shown, status_of

HEAD = 1 << 16
"""Bytes of a file by which it is known."""


@dataclass(frozen=True, slots=True)
class Own:
    """Files that a command replaces although nobody has named them to it, or that it goes on with.

    Attributes:
        what: they are, as a message says it.
        known: whether a file begins as they do, by its first `HEAD` bytes; with one that is empty nothing is lost.
    """

    what: str
    known: Callable[[bytes], object]

    def fits(self, path: Path) -> bool:
        """Whether there is nothing of this name yet, or such a file.

        Raises:
            FileError: there can be no file of this name.
        """
        if status_of(path) is None:
            return True
        try:
            with open_file(path) as file:
                head = file.read(HEAD)
        except (ReadError, OSError):
            return False
        return not head or bool(self.known(head))


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A file that is to be written.

    Attributes:
        path: of it.
        option: by which it is named, or what it is named after; empty for a call without options.
        own: what it may replace; anything if None.
        after: the file that was named, where this one is written beside it.
        in_folder: whether the option names its folder.
        called: whether it may be among the programs that are read, if it is its own: values that a program calls.
    """

    path: Path
    option: str = ""
    own: Own | None = None
    after: Path | None = None
    in_folder: bool = False
    called: bool = False

    @property
    def remedy(self) -> str:
        """What is to be done instead, as a message ends."""
        what = "folder" if self.in_folder else "file"
        return f"name another {what} with {self.option}" if self.option else f"name another {what} to write"

    def __str__(self) -> str:
        """As a message names it."""
        return shown(self.path) if self.after is None else f"{shown(self.path)}, written beside {shown(self.after)},"


def check_targets(targets: Sequence[Target], read: Iterable[Path] = ()) -> None:
    """Find out, before any work, whether files may be written.

    Args:
        targets: all that the work writes.
        read: files that it reads; looked through only if something may be replaced.

    Raises:
        FileError: one cannot be written, is read, is written twice, or is there already and not what the work has
            written before.
    """
    for target in targets:
        check_target(target.path)
        if target.after is not None and is_stream(target.after):
            raise FileError(f"{shown(target.after)} is no file beside which another can be written; {target.remedy}")
    replaced = [(target, status) for target in targets if (status := _regular(target.path)) is not None]
    known = [(path, status) for path in dict.fromkeys(read if replaced else ()) if (status := _regular(path))]
    for target, status in replaced:
        own = target.own is not None and target.own.fits(target.path)
        values = own and target.called and status.st_size > 0  # nobody knows what an empty file is to be
        for path, other in known:
            if os.path.samestat(status, other) and not values:
                which = "" if path == target.path else f"{shown(path)}, which is "
                raise FileError(f"{target} is {which}read here and would be lost; {target.remedy}")
        if target.own is not None and not own:
            raise FileError(
                f"{target} is there already and would be lost, for it is no {target.own.what}: "
                f"move it away, or {target.remedy}"
            )
    _refuse_twice([target for target in targets if not is_stream(target.path)])


def check_own(path: Path, own: Own, option: str) -> None:
    """Find out, before any work, whether a file may be replaced that has a name of the command's own in a folder.

    Args:
        path: of the file, whose folder may yet have to be made.
        own: what it may be.
        option: by which the folder is named.

    Raises:
        FileError: it is there already and something else.
    """
    if status_of(path) is not None:
        check_targets([Target(path=path, option=option, own=own, in_folder=True)])


def _refuse_twice(files: Sequence[Target]) -> None:
    """Refuse names of one file; those that differ in capital letters alone are, on many a disk."""
    taken = dict[str, Target]()
    for target in files:
        place = os.path.realpath(target.path).casefold()
        if place in taken:
            if target.after == taken[place].path:
                raise FileError(f"{shown(target.path)} is the name of what is written beside it, too; {target.remedy}")
            options = " and ".join(dict.fromkeys(each.option for each in (taken[place], target) if each.option))
            by = f" with {options}" if options else ""
            raise FileError(f"{shown(target.path)} would be written twice{by}; name different files")
        taken[place] = target


def _regular(path: Path) -> os.stat_result | None:
    """The status of a regular file; None of anything else, and of a name that no file has."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return None
    return status if stat.S_ISREG(status.st_mode) else None
