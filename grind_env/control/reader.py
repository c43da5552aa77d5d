"""Text of a part program -> programs of blocks, and a block -> its words (10-6, 10-7, 10-23).

The text is only split at first; the words of a block are read when it is executed, so that a faulty block
stops the control where it stands and not before (ruling 12).
"""

import functools
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from grind_env.control.errors import ControlError, Place

ADDRESSES = frozenset("DEFGIJKLMNOPQRSTXYZ")
REPEATABLE = frozenset("GM")
LONGEST_COMMENT = 128
LONGEST_NUMBER = 30
HIGHEST_PROGRAM = 99_999

_NUMBER = re.compile(r"[ \t]*([+-]?)([0-9]*)(\.?)([0-9]*)")
_NAME = re.compile(r"[ \t]*(?:\([^()]*\)[ \t]*)*[Oo]")


@dataclass(frozen=True, slots=True)
class Source:
    """The text of one block as it stands in the file; line and column count from 1."""

    file: str
    line: int
    column: int
    text: str

    @property
    def deletable(self) -> bool:
        """Whether the block begins with ``/``."""
        return self.text.startswith("/")

    @property
    def place(self) -> Place:
        """The place as far as it is known before the N word is read."""
        return Place(self.file, self.line, self.column, self.line)


@dataclass(frozen=True, slots=True)
class Word:
    """An address letter and its number as written, cut into sign, integer digits and decimals."""

    letter: str
    sign: str
    whole: str
    point: bool
    decimals: str
    column: int

    def __str__(self) -> str:
        """The word as written."""
        return f"{self.letter}{self.sign}{self.whole}{'.' if self.point else ''}{self.decimals}"


@dataclass(frozen=True, slots=True)
class Block:
    """A block that has been read: its words in textual order, without the N word."""

    source: Source
    place: Place
    words: tuple[Word, ...]

    def error(self, name: str, message: str, word: Word | None = None) -> ControlError:
        """A `ControlError` at one of the block's words, or at the block as a whole."""
        return self.place.error(name, message, word.column if word else None)


@dataclass(frozen=True, slots=True)
class Program:
    """The blocks between one program name and the next; `number` is None for a text without a name."""

    number: int | None
    place: Place
    blocks: tuple[Source, ...]

    def last_place(self) -> Place:
        """The last block, or the name of an empty program."""
        return read_block(self.blocks[-1]).place if self.blocks else self.place


class Programs:
    """The programs of a file: the first is the main program, the others are found by their O numbers.

    Attributes:
        name: name of the file, for messages.
        main: the program that is executed.
        folder: where the files of further programs, ``O<number>.nc``, are looked for; None: nowhere.
    """

    def __init__(self, name: str, programs: list[Program], folder: Path | None = None) -> None:
        self.name, self.main, self.folder = name, programs[0], folder
        self._programs = programs
        self._numbered = {program.number: program for program in programs if program.number is not None}

    def __iter__(self) -> Iterator[Program]:
        """Every program read so far, the main program first."""
        return iter(self._programs)

    def find(self, number: int) -> Program | None:
        """The program O`number` of the file, or of the file ``O<number>.nc`` beside it.

        A text without a name in that file is taken to be O`number`.
        """
        if number not in self._numbered and self.folder is not None:
            path = self.folder / f"O{number}.nc"
            if path.is_file():
                found = read(read_text(path), path.name)
                self._programs += found
                self._numbered = {number: found.main} | found._numbered | self._numbered
        return self._numbered.get(number)


def read_file(path: str | Path) -> Programs:
    """Read a part program; programs that it calls may be in files ``O<number>.nc`` beside it.

    Raises:
        ControlError: the file cannot be read as text, or its program names are faulty.
    """
    path = Path(path)
    return read(read_text(path), path.name, path.parent)


def read_text(path: Path) -> str:
    """The text of a file; a `ControlError` says why it cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        reason = error.strerror or "not readable"
        raise ControlError("file", f"{path} cannot be read ({reason}); name a text file") from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise ControlError(
            "file", f"line {line} of {path} is not text in UTF-8; save the part program in this encoding"
        ) from None


def read(text: str, name: str = "program", folder: Path | None = None) -> Programs:
    """Split a text into its programs.

    Raises:
        ControlError: a program name is faulty or occurs twice.
    """
    number: int | None = None
    place = Place(name, 1, 1, 1)
    blocks: list[Source] = []
    programs: list[Program] = []
    taken: set[int] = set()
    for source in _blocks(text, name):
        if not _NAME.match(source.text):
            blocks.append(source)
            continue
        if number is not None or any(_has_words(block) for block in blocks):
            programs.append(Program(number, place, tuple(blocks)))
        number, place, blocks = _program_number(source), source.place, []
        if number in taken:
            raise place.error("block-format", f"O{number} is named twice; every program needs its own number")
        taken.add(number)
    programs.append(Program(number, place, tuple(blocks)))
    return Programs(name, programs, folder)


def _has_words(source: Source) -> bool:
    """Whether a block holds more than comments; a faulty one does."""
    try:
        return bool(read_block(source).words)
    except ControlError:
        return True


def _blocks(text: str, file: str) -> Iterator[Source]:
    """Cut a text into blocks, from a leading ``%`` up to the next one; blank blocks are left out."""
    begun = False
    for line, content in enumerate(re.split(r"\r\n|\r|\n", text), 1):
        start = 0
        for end, mark in _block_ends(content):
            block = content[start:end]
            if block.strip():
                yield Source(file, line, start + len(block) - len(block.lstrip()) + 1, block.strip())
            elif mark == "%" and not begun:
                mark = ""
                begun = True
            begun = begun or bool(block.strip())
            if mark == "%":
                return
            start = end + 1


def _block_ends(line: str) -> Iterator[tuple[int, str]]:
    """Where blocks end in a line: at ``;``, at ``%`` outside a comment, at the end of the line."""
    commented = False
    for index, character in enumerate(line):
        if character == ";" or (character == "%" and not commented):
            yield index, character
            commented = False
        elif character in "()":
            commented = character == "("
    yield len(line), ""


def _program_number(source: Source) -> int:
    block = read_block(source)
    name, *others = block.words
    if others:
        raise block.error("block-format", f"{others[0]} follows a program name; a name stands alone", others[0])
    number = int(name.whole or "0")
    if name.sign or name.point or not 1 <= number <= HIGHEST_PROGRAM:
        raise block.error("out-of-range", f"{name} is not a program name; O1 to O{HIGHEST_PROGRAM} are", name)
    return number


@functools.lru_cache(maxsize=4096)
def read_block(source: Source) -> Block:
    """Read the words of a block.

    Raises:
        ControlError: a comment, a word or a number is malformed, or a letter is unknown or repeated.
    """
    place, text = source.place, source.text
    position = 1 if source.deletable else 0
    words: list[Word] = []
    seen: set[str] = set()
    while position < len(text):
        column = source.column + position
        character = text[position]
        if character in " \t":
            position += 1
        elif character == "(":
            position = _comment_end(text, position, place, column)
        elif character.isascii() and character.isalpha():
            word, position = _word(text, position, place, column)
            if word.letter in seen and word.letter not in REPEATABLE:
                raise place.error(
                    "block-format",
                    f"{word} repeats the letter {word.letter}; only G and M may repeat",
                    column,
                )
            seen.add(word.letter)
            if word.letter == "N":
                place = _labelled(place, word)
            else:
                words.append(word)
        else:
            raise place.error("block-format", _stray(character), column)
    return Block(source, place, tuple(words))


def _labelled(place: Place, word: Word) -> Place:
    if word.sign or word.point or len(word.whole) > 5:
        raise place.error("number-format", f"{word} is not a block label; N takes up to five digits", word.column)
    return Place(place.file, place.line, place.column, int(word.whole))


def _comment_end(text: str, start: int, place: Place, column: int) -> int:
    """The position after the comment that begins at `start`."""
    end = text.find(")", start)
    inside = text[start + 1 : end] if end > 0 else text[start + 1 :]
    if "(" in inside:
        raise place.error("block-format", "a comment holds '('; comments cannot be nested", column)
    if "%" in inside:
        raise place.error("block-format", "a comment holds '%'; it is kept for the end of the file", column)
    if end < 0:
        raise place.error("block-format", "a comment is not closed; ')' must come in the same block", column)
    length = end + 1 - start
    if length > LONGEST_COMMENT:
        raise place.error("block-format", f"a comment has {length} characters; {LONGEST_COMMENT} are allowed", column)
    return end + 1


def _word(text: str, start: int, place: Place, column: int) -> tuple[Word, int]:
    """The word that begins at `start`, and the position after it."""
    letter = text[start].upper()
    if letter not in ADDRESSES:
        raise place.error("unknown-word", f"{letter} is not an address of this control", column)
    match = _NUMBER.match(text, start + 1)
    assert match is not None  # every part of the pattern may be empty
    sign, whole, point, decimals = match.groups()
    if len(whole) + len(decimals) > LONGEST_NUMBER:
        raise place.error("number-format", f"{letter} has a number of more than {LONGEST_NUMBER} digits", column)
    if not whole and not decimals:
        if text.startswith(("[", "#"), match.end()):
            raise place.error("not-supported", f"{letter} has a paramacro value; only numbers are supported", column)
        raise place.error("number-format", f"{letter}{sign}{point} has no digits; a number must follow", column)
    return Word(letter, sign, whole, bool(point), decimals, column), match.end()


def _stray(character: str) -> str:
    if character == "/":
        return "'/' stands inside a block; block delete is its first character"
    if character == ")":
        return "')' closes no comment"
    return f"{character!r} cannot begin a word; words are a letter and a number"
