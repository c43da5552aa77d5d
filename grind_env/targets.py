"""What a command may write: no file that it reads, none twice, and under a name of its own choice only what is its own.

`check_targets` is asked before any work; `grind_env.arguments` asks it for every command.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from grind_env.files import FileError, ReadError, check_target, is_file, open_file, shown, status_of

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
    """A file that is to be written.

    `option` names it, or the file or folder (`kind`) that it goes by; `after` is the file beside which it lies. `own`
    is what it may replace, anything if None; `called`: it may then be among the programs that are read, as values.
    """

    path: Path
    option: str = ""
    own: Own | None = None
    after: Path | None = None
    kind: str = "file"
    called: bool = False

    @property
    def remedy(self) -> str:
        """What is to be done instead, as a message ends."""
        return f"name another {self.kind} " + (f"with {self.option}" if self.option else "to write")

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
    there = [target for target in targets if is_file(target.path)]
    known = [path for path in dict.fromkeys(read if there else ()) if is_file(path)]
    for target in there:
        own = target.own is not None and target.own.fits(target.path)
        is_values = own and target.called and target.path.stat().st_size > 0  # an empty file may become anything
        for path in () if is_values else known:
            if path.samefile(target.path):
                which = "" if path == target.path else f"{shown(path)}, which is "
                raise FileError(f"{target} is {which}read here and would be lost; {target.remedy}")
        if target.own is not None and not own:
            raise FileError(
                f"{target} is there already and would be lost, for it is no {target.own.what}: "
                f"move it away, or {target.remedy}"
            )
    taken = dict[str, Target]()
    for target in targets:
        place = os.path.realpath(target.path).casefold()  # on many a disk capital letters make no difference
        other = taken.setdefault(place, target)
        if other is not target and target.after == other.path:
            raise FileError(f"{shown(target.path)} is the name of what is written beside it, too; {target.remedy}")
        if other is not target:
            options = " and ".join(dict.fromkeys(each.option for each in (other, target) if each.option))
            by = f" with {options}" if options else ""
            raise FileError(f"{shown(target.path)} would be written twice{by}; name different files")


def check_own(path: Path, own: Own, option: str) -> None:
    """Find out, before any work, whether a file that a command names itself may be replaced in a folder."""
    if status_of(path) is not None:
        check_targets([Target(path=path, option=option, own=own, kind="folder")])
