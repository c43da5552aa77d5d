"""Reader of part programs: text -> programs -> blocks (10-6, 10-7, 10-23).

Reading only finds the programs of a text and where they begin. The words of a block are read when it is executed, so
a faulty block stops the control only there (ruling 12). Blocks are cut from the text again whenever they are needed.
"""

import functools
import itertools
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from grind_env.control.block_words import read_block
from grind_env.control.errors import ControlError, Place
from grind_env.control.foreign_programs import HEAD_BYTES, MOST_BLOCKS_BEFORE, check_before, check_head, has_words
from grind_env.control.program_scanner import Mark, Scanner, SourceText, Text, changed, text_in, text_of
from grind_env.files import ReadError, is_file, read_bytes
from grind_env.notebook_loader import html

HIGHEST_PROGRAM = 99_999
#: number of blocks up to which a program stays in memory instead of being cut from its text again
IN_MEMORY_BLOCKS = 50

_FILE = re.compile(r"O([1-9]\d{0,4})\.nc")
#: a P word that may name a program: its number, or the beginning of an expression
_CALL = re.compile(rb"[Pp][ \t]*\+?[ \t]*(?:0*([1-9]\d{0,4})(?!\d)|([#\[]))")
_NAME = re.compile(r"[ \t]*(?:\([^()]*\)[ \t]*)*[Oo]")


@dataclass(frozen=True, slots=True)
class Blocks:
    """The blocks of a program; every iteration cuts them from the text again."""

    text: Text
    start: Mark
    count: int
    last: SourceText | None

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[SourceText]:
        if self.count <= IN_MEMORY_BLOCKS:
            yield from _read_blocks(self)
        else:
            yield from self._read()

    def _read(self) -> Iterator[SourceText]:
        left = self.count
        if not left:
            return
        with self.text.open() as handle:
            for source in Scanner(handle, self.text, self.start):
                yield source
                left -= 1
                if not left:
                    return
        raise changed(self.text.title)


@functools.lru_cache(maxsize=64)
def _read_blocks(blocks: Blocks) -> tuple[SourceText, ...]:
    return tuple(blocks._read())


@dataclass(frozen=True, slots=True)
class Program:
    """The blocks between one program name and the next; `number` is None for a text without a name."""

    number: int | None
    place: Place
    blocks: Blocks

    def last_place(self) -> Place:
        """Return the place of the last block; that of the program without blocks."""
        last = self.blocks.last
        if last is None:
            return self.place
        try:
            return read_block(last).place
        except ControlError:  # its words may be faulty if its slash (block delete) kept it from being read
            return last.place


class Programs:
    """The programs of a file: the first is the main program, the others are found by their O numbers.

    Attributes:
        name: name of the file, for messages.
        main: the program that is executed.
        folder: folder with the files of further programs, ``O<number>.nc``; None if there is none.
    """

    def __init__(self, name: str, programs: list[Program], folder: Path | None = None) -> None:
        self.name, self.main, self.folder = name, programs[0], folder
        self._programs = programs
        self._numbered = {program.number: program for program in programs if program.number is not None}

    def __iter__(self) -> Iterator[Program]:
        return iter(self._programs)

    def find(self, number: int) -> Program | None:
        """Return the program O`number` of the file, or of the file ``O<number>.nc`` beside it.

        A text in that file without a program name counts as O`number`.
        """
        if number not in self._numbered and self.folder is not None:
            path = _file_of(self.folder, number)
            if path.is_file():
                found = _split(text_in(path), None)
                self._programs += found
                self._numbered = {number: found.main} | found._numbered | self._numbered
        return self._numbered.get(number)

    def _repr_html_(self) -> str:
        return html("programs", self)


def read_file(path: str | Path, faults: list[ControlError] | None = None) -> Programs:
    """Read a part program; programs that it calls may be in files ``O<number>.nc`` beside it.

    Args:
        path: the file.
        faults: list that receives the errors of program names while reading goes on; the result must then not be
            executed. None to raise the first error.

    Raises:
        ControlError: the file cannot be read as text, or its program names are faulty.
    """
    path = Path(path)
    if path.suffix.lower() == ".toml":
        message = f"{path} is a TOML file, such as a job or a task; name the part program, and the job with --job"
        raise ControlError("file", message)
    return _split(text_in(path), path.parent, faults)


def called_files(path: Path, interrupts: Iterable[int] = ()) -> list[Path]:
    """Return the files ``O<number>.nc`` beside a program that it may call, directly or through other files.

    The program is not executed: every number of a P word counts as a program number, and an expression as all of them.
    """
    if not is_file(path):
        return []
    beside = {int(found[1]) for each in path.parent.glob("O*.nc") if (found := _FILE.fullmatch(each.name))}
    called, waiting = set[int](), [path]
    new = beside & set(interrupts)
    while beside and waiting:
        try:
            calls = _CALL.findall(read_bytes(waiting.pop()))
        except ReadError:  # execution will report the error
            calls = []
        new |= beside if any(expression for _, expression in calls) else beside & {int(number) for number, _ in calls}
        waiting += [_file_of(path.parent, number) for number in new - called]
        called |= new
    return [_file_of(path.parent, number) for number in sorted(called)]


def _file_of(folder: Path, number: int) -> Path:
    return folder / f"O{number}.nc"


def read(text: str, name: str = "program", folder: Path | None = None) -> Programs:
    """Split a text into its programs.

    Raises:
        ControlError: a program name is faulty or occurs twice.
    """
    return _split(text_of(text, name), folder)


def _split(text: Text, folder: Path | None, faults: list[ControlError] | None = None) -> Programs:
    number: int | None = None
    place = Place(text.name, 1, 1, 1)
    start, count, last, begun = Mark(), 0, None, False
    programs: list[Program] = []
    taken: set[int] = set()
    with text.open() as handle:
        check_head(handle.read(HEAD_BYTES), text.name)
        scanner = Scanner(handle, text, start)
        first = list(itertools.islice(scanner, MOST_BLOCKS_BEFORE))
        if scanner.unread:
            check_before(first)
        scanner = Scanner(handle, text, start)
        for source in scanner:
            if not _NAME.match(source.text):
                count, last = count + 1, source
                begun = begun or has_words(source, faulty=True)
                continue
            if begun:
                programs.append(Program(number, place, Blocks(text, start, count, last)))
            place, begun = source.place, True
            start, count, last = scanner.mark, 0, None
            try:
                number = _new_number(source, taken)
            except ControlError as error:
                if faults is None:
                    raise
                number = None
                faults.append(error)
    programs.append(Program(number, place, Blocks(text, start, count, last)))
    return Programs(text.name, programs, folder)


def _new_number(source: SourceText, taken: set[int]) -> int:
    block = read_block(source)
    name, *others = block.words
    if others:
        raise block.error("block-format", f"{others[0]} follows a program name; a name stands alone", others[0])
    number = int(name.whole or "0")
    if name.sign or name.point or not 1 <= number <= HIGHEST_PROGRAM:
        raise block.error("out-of-range", f"{name} is not a program name; O1 to O{HIGHEST_PROGRAM} are", name)
    if number in taken:
        raise source.place.error("block-format", f"O{number} is named twice; every program needs its own number")
    taken.add(number)
    return number
