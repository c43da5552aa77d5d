"""Text of a part program -> programs of blocks, and a block -> its words (10-6, 10-7, 10-23).

The text is only split at first; the words of a block are read when it is executed, so that a faulty block
stops the control where it stands and not before (ruling 12). Reading finds the programs of a text and where they
begin; their blocks are cut from the text again whenever they are needed.
"""

import functools
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from grind_env.control.errors import ControlError, Place
from grind_env.control.source import Mark, Scanner, Source, Text, changed, text_in, text_of

__all__ = [
    "HIGHEST_PROGRAM",
    "Block",
    "Blocks",
    "Program",
    "Programs",
    "Source",
    "Word",
    "read",
    "read_block",
    "read_file",
]

ADDRESSES = frozenset("DEFGIJKLMNOPQRSTXYZ")
REPEATABLE = frozenset("GM")
LONGEST_COMMENT = 128
LONGEST_NUMBER = 30
LONGEST_LABEL = 5
HIGHEST_PROGRAM = 99_999

_NAME = re.compile(r"[ \t]*(?:\([^()]*\)[ \t]*)*[Oo]")
_WORD = re.compile(r"([A-Za-z])[ \t]*([+-]?)([0-9]*)(\.?)([0-9]*)[ \t]*([0-9.]?)")
"""A word without blanks in its number; its last group begins what a blank, or a second point, has cut off."""
_SPACED_NUMBER = re.compile(r"[ \t]*([+-]?)[ \t]*([0-9 \t]*)(\.?)([0-9 \t]*)")
_VARIABLE = re.compile(r"#[0-9 \t]*")
_BRACKET = re.compile(r"[\[\]]")
_PARAMACRO = re.compile(r"(IF|WHILE|GOTO|DO|END)[ \t]*(?:[\[#0-9]|$)", re.IGNORECASE)


class Word(NamedTuple):
    """An address letter and its number as written, cut into sign, integer digits and decimals; blanks left out.

    Attributes:
        letter: the address, a capital.
        sign: "+", "-" or nothing.
        whole: the integer digits.
        point: whether the number has a decimal point.
        decimals: the digits after it.
        column: of the letter in its line, from 1.
        expression: what follows the letter when that is no number; there are no digits until it is evaluated.
    """

    letter: str
    sign: str
    whole: str
    point: bool
    decimals: str
    column: int
    expression: str = ""

    def __str__(self) -> str:
        """The word as written."""
        if self.expression:
            return f"{self.letter}{self.expression.strip()}"
        return f"{self.letter}{self.sign}{self.whole}{'.' if self.point else ''}{self.decimals}"


class Block(NamedTuple):
    """A block that has been read: its words in textual order, without the N word."""

    source: Source
    place: Place
    words: tuple[Word, ...]

    def error(self, name: str, message: str, word: Word | None = None) -> ControlError:
        """A `ControlError` at one of the block's words, or at the block as a whole."""
        return self.place.error(name, message, word.column if word else None)


@dataclass(frozen=True, slots=True)
class Blocks:
    """The blocks of a program, cut from its text anew by every iteration.

    Attributes:
        text: where they stand.
        start: where the first of them begins.
        count: how many they are.
        last: the last of them; None if there are none.
    """

    text: Text
    start: Mark
    count: int
    last: Source | None

    def __len__(self) -> int:
        """The number of blocks."""
        return self.count

    def __iter__(self) -> Iterator[Source]:
        """Read them from the first one on; the text is closed with the iterator.

        Raises:
            ControlError: file, the text has changed.
        """
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


@dataclass(frozen=True, slots=True)
class Program:
    """The blocks between one program name and the next; `number` is None for a text without a name."""

    number: int | None
    place: Place
    blocks: Blocks

    def last_place(self) -> Place:
        """The last block, or the name of an empty program."""
        last = self.blocks.last
        if last is None:
            return self.place
        try:
            return read_block(last).place
        except ControlError:  # it may have been deleted by its slash, unread
            return last.place


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
                found = _split(text_in(path), None)
                self._programs += found
                self._numbered = {number: found.main} | found._numbered | self._numbered
        return self._numbered.get(number)


def read_file(path: str | Path) -> Programs:
    """Read a part program; programs that it calls may be in files ``O<number>.nc`` beside it.

    Raises:
        ControlError: the file cannot be read as text, or its program names are faulty.
    """
    path = Path(path)
    return _split(text_in(path), path.parent)


def read(text: str, name: str = "program", folder: Path | None = None) -> Programs:
    """Split a text into its programs.

    Raises:
        ControlError: a program name is faulty or occurs twice.
    """
    return _split(text_of(text, name), folder)


def _split(text: Text, folder: Path | None) -> Programs:
    """Find the programs of a text in one pass."""
    number: int | None = None
    place = Place(text.name, 1, 1, 1)
    start, count, last, begun = Mark(), 0, None, False
    programs: list[Program] = []
    taken: set[int] = set()
    with text.open() as handle:
        scanner = Scanner(handle, text, start)
        for source in scanner:
            if not _NAME.match(source.text):
                count, last = count + 1, source
                begun = begun or _has_words(source)
                continue
            if begun:
                programs.append(Program(number, place, Blocks(text, start, count, last)))
            number, place, begun = _program_number(source), source.place, True
            start, count, last = scanner.mark, 0, None
            if number in taken:
                raise place.error("block-format", f"O{number} is named twice; every program needs its own number")
            taken.add(number)
    programs.append(Program(number, place, Blocks(text, start, count, last)))
    return Programs(text.name, programs, folder)


def _has_words(source: Source) -> bool:
    """Whether a block holds more than comments; a faulty one does."""
    try:
        return bool(read_block(source).words)
    except ControlError:
        return True


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
    text, column = source.text, source.column
    place, size = source.place, len(text)
    position = 1 if source.deletable else 0
    words: list[Word] = []
    seen: set[str] = set()
    while position < size:
        match = _WORD.match(text, position)
        if match is None:
            position = _after_blank_or_comment(text, position, place, column + position)
            continue
        written, sign, whole, point, decimals, more = match.groups()
        letter, end = written.upper(), match.end()
        if more or not (whole or decimals) or letter not in ADDRESSES or end - position > LONGEST_NUMBER:
            word, end = _unusual_word(text, position, place, column + position)
        else:
            word = Word(letter, sign, whole, bool(point), decimals, column + position)
        if letter in seen and letter not in REPEATABLE:
            raise place.error(
                "block-format", f"{word} repeats the letter {letter}; only G and M may repeat", column + position
            )
        seen.add(letter)
        if letter == "N":
            place = _labelled(place, word)
        else:
            words.append(word)
        position = end
    return Block(source, place, tuple(words))


def _labelled(place: Place, word: Word) -> Place:
    if word.expression or word.sign or word.point or len(word.whole) > LONGEST_LABEL:
        raise place.error(
            "number-format",
            f"{word} is not a block label; N takes up to {LONGEST_LABEL} digits",
            word.column,
        )
    return Place(place.file, place.line, place.column, int(word.whole))


def _after_blank_or_comment(text: str, start: int, place: Place, column: int) -> int:
    """The position after what stands at `start`, where no word does."""
    character = text[start]
    if character in " \t":
        return start + 1
    if character != "(":
        name = "not-supported" if character == "#" else "block-format"
        raise place.error(name, _stray(character), column)
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


def _unusual_word(text: str, start: int, place: Place, column: int) -> tuple[Word, int]:
    """The word that begins at `start`, and the position after it; its number may have blanks or be an expression."""
    letter = text[start].upper()
    paramacro = _PARAMACRO.match(text, start)
    if paramacro:
        raise place.error(
            "not-supported", f"{paramacro[1].upper()} is a paramacro command; expressions alone are supported", column
        )
    if letter not in ADDRESSES:
        raise place.error("unknown-word", f"{letter} is not an address of this control", column)
    match = _SPACED_NUMBER.match(text, start + 1)
    assert match is not None  # every part of the pattern may be empty
    sign, point, end = match[1], match[3], match.end()
    whole, decimals = ("".join(match[group].split()) for group in (2, 4))
    if len(whole) + len(decimals) > LONGEST_NUMBER:
        raise place.error("number-format", f"{letter} has a number of more than {LONGEST_NUMBER} digits", column)
    if whole or decimals:
        return Word(letter, sign, whole, bool(point), decimals, column), end
    if point or not text.startswith(("[", "#"), end):
        raise place.error("number-format", f"{letter}{sign}{point} has no digits; a number must follow", column)
    end = _expression_end(text, end, place, column - start)
    return Word(letter, "", "", False, "", column, text[start + 1 : end]), end


def _expression_end(text: str, start: int, place: Place, first_column: int) -> int:
    """The position after the bracket or the variable that begins at `start`."""
    variable = _VARIABLE.match(text, start)
    begin = variable.end() if variable else start
    if not text.startswith("[", begin):
        return begin
    depth = 0
    for bracket in _BRACKET.finditer(text, begin):
        depth += 1 if bracket[0] == "[" else -1
        if depth == 0:
            return bracket.end()
    raise place.error("expression", "'[' is not closed; a ']' is missing", first_column + begin)


def _stray(character: str) -> str:
    if character == "/":
        return "'/' stands inside a block; block delete is its first character"
    if character == ")":
        return "')' closes no comment"
    if character == "#":
        return "'#' begins an assignment; variables can only be read, they get their values outside the program"
    return f"{character!r} cannot begin a word; words are a letter and a number"
