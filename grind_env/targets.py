"""Checks of output files: not an input, not twice, and a default name replaces only the command's own file.

`check_targets` is asked before any work; `grind_env.arguments` asks it for every command.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from grind_env.files import FileError, ReadError, check_target, is_file, open_file, shown, status_of

HEAD = 1 << 16
"""Bytes of a file by which it is known."""


class Own(NamedTuple):
    """Files that a command replaces although nobody has named them to it, or that it goes on with."""

    what: str  # they are, as a message says it
    # whether a file begins as they do, by its first `HEAD` bytes; with one that is empty nothing is lost
    known: Callable[[bytes], object]

    def fits(self, path: Path) -> bool:
        """Return whether there is nothing of this name yet, or such a file."""
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
    """Output file.

    `option` names the file, or the file or folder (`kind`) behind its name; `after` is the file beside it. Files that
    `own` recognises may be replaced, any if None; with `called` also one of the input programs.
    """

    path: Path
    option: str = ""
    own: Own | None = None
    after: Path | None = None
    kind: str = "file"
    called: bool = False

    def refused(self, why: str) -> FileError:
        """Return the error that says why the file is not written, and what to do instead."""
        beside = "" if self.after is None else f", written beside {shown(self.after)},"
        remedy = f"name another {self.kind} " + (f"with {self.option}" if self.option else "to write")
        return FileError(f"{shown(self.path)}{beside} {why}{remedy}")


def check_targets(targets: Sequence[Target], read: Iterable[Path] = ()) -> None:
    """Find out, before any work, whether files may be written; `read` are those that the work reads.

    Raises:
        FileError: one cannot be written, is read, is written twice, or is there already and not what the work has
            written before.
    """
    for target in targets:
        check_target(target.path)
    there = [target for target in targets if is_file(target.path)]
    known = [path for path in dict.fromkeys(read if there else ()) if is_file(path)]
    for target in there:
        own = target.own is not None and target.own.fits(target.path)
        is_values = own and target.called and target.path.stat().st_size > 0  # an empty file may become anything
        for path in () if is_values else known:
            if path.samefile(target.path):
                which = "" if path == target.path else f"{shown(path)}, which is "
                raise target.refused(f"is {which}read here and would be lost; ")
        if target.own is not None and not own:
            what = target.own.what
            raise target.refused(f"is there already and would be lost, for it is no {what}: move it away, or ")
    taken = dict[str, Target]()
    for target in targets:
        place = os.path.realpath(target.path).casefold()  # on many a disk capital letters make no difference
        other = taken.setdefault(place, target)
        if other is not target and target.after == other.path:
            raise replace(target, after=None).refused("is the name of what is written beside it, too; ")
        if other is not target:
            options = " and ".join(dict.fromkeys(each.option for each in (other, target) if each.option))
            by = f" with {options}" if options else ""
            raise FileError(f"{shown(target.path)} would be written twice{by}; name different files")


def check_own(path: Path, own: Own, option: str) -> None:
    """Find out, before any work, whether a file that a command names itself may be replaced in a folder."""
    if status_of(path) is not None:
        check_targets([Target(path=path, option=option, own=own, kind="folder")])
