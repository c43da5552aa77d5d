"""Checks of output files: no input is overwritten, no file is written twice, a default name replaces only own files.

`check_targets` runs before any work; `grind_env.file_arguments` calls it for every command.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from grind_env.files import FileError, ReadError, check_target, is_file, open_file, shown, status_of

HEAD = 1 << 16  #: number of bytes at the beginning of a file by which its kind is recognised


class FileKind(NamedTuple):
    """Kind of file that a command may replace or continue although the user has not named it."""

    what: str  #: name of these files in a message
    # whether the first `HEAD` bytes of a file are of this kind; an empty file is always one, because nothing is lost
    known: Callable[[bytes], object]

    def fits(self, path: Path) -> bool:
        """Return whether the path is free, or has an empty file or a file of this kind."""
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

    `option` is the option that names the file, or its folder if `kind` is "folder". The file is written beside
    `main_file`. Files that `replaceable` recognises may be replaced, all if None; with `may_be_input`, such a file may
    be an input program.
    """

    path: Path
    option: str = ""
    replaceable: FileKind | None = None
    main_file: Path | None = None
    kind: str = "file"
    may_be_input: bool = False

    def refused(self, why: str) -> FileError:
        """Return the error that says why the file is not written, and what to do instead."""
        beside = "" if self.main_file is None else f", written beside {shown(self.main_file)},"
        remedy = f"name another {self.kind} " + (f"with {self.option}" if self.option else "to write")
        return FileError(f"{shown(self.path)}{beside} {why}{remedy}")


def check_targets(targets: Sequence[Target], read: Iterable[Path] = ()) -> None:
    """Check, before any work, that the output files may be written; `read` are the input files.

    Raises:
        FileError: a file cannot be written, is an input, is written twice, or exists and is not recognised by its
            `replaceable`.
    """
    for target in targets:
        check_target(target.path)
    there = [target for target in targets if is_file(target.path)]
    known = [path for path in dict.fromkeys(read if there else ()) if is_file(path)]
    for target in there:
        own = target.replaceable is not None and target.replaceable.fits(target.path)
        is_values = own and target.may_be_input and target.path.stat().st_size > 0  # an empty input may become anything
        for path in () if is_values else known:
            if path.samefile(target.path):
                which = "" if path == target.path else f"{shown(path)}, which is "
                raise target.refused(f"is {which}read here and would be lost; ")
        if target.replaceable is not None and not own:
            what = target.replaceable.what
            raise target.refused(f"is there already and would be lost, for it is no {what}: move it away, or ")
    taken = dict[str, Target]()
    for target in targets:
        place = os.path.realpath(target.path).casefold()  # many file systems ignore case
        other = taken.setdefault(place, target)
        if other is not target and target.main_file == other.path:
            raise replace(target, main_file=None).refused("is the name of what is written beside it, too; ")
        if other is not target:
            options = " and ".join(dict.fromkeys(each.option for each in (other, target) if each.option))
            by = f" with {options}" if options else ""
            raise FileError(f"{shown(target.path)} would be written twice{by}; name different files")


def check_replaceable(path: Path, own: FileKind, option: str) -> None:
    """Check, before any work, that a file whose name the command chooses may be replaced; `option` names its folder."""
    if status_of(path) is not None:
        check_targets([Target(path=path, option=option, replaceable=own, kind="folder")])
