"""Numbers of single words changed in the text of a program; every other byte stays what it is."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import NamedTuple

from grind_env.control.source import SourceText
from grind_env.control.statements import PREFIX
from grind_env.control.words import Word, read_block

BYTE_ORDER_MARK = "\ufeff"
LATIN = "latin-1"

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n|\Z)")
_NUMBER = re.compile(r"([A-Za-z][ \t]*)([+-]?[ \t]*[0-9. \t]*[0-9.])")
_ASSIGNMENT = re.compile(
    PREFIX + r"(?:[Nn][ \t]*[0-9]{1,5}[ \t]*)?#[ \t]*([0-9]+)[ \t]*="
    r"[ \t]*([-+]?[ \t]*(?:[0-9]+\.?[0-9]*|\.[0-9]+))[ \t]*(?:\([^()]*\)[ \t]*)*"
)
_BLANKS = re.compile(r"[ \t](?=[A-Za-z])")


class Edit(NamedTuple):
    """Some characters of a line replaced by others; line and column from 1."""

    line: int
    column: int
    length: int
    text: str


class WordEdit(NamedTuple):
    """An edit of a block, and what a comment behind it says of it."""

    source: SourceText
    edit: Edit
    said: str


@dataclass(frozen=True, slots=True)
class ProgramText:
    """The text of a program file as the control counts its lines and columns."""

    encoding: str  # of the file
    mark: str  # the byte order mark, if there is one
    lines: tuple[str, ...]  # with their ends

    @property
    def text(self) -> str:
        """Without a byte order mark."""
        return "".join(self.lines)

    def bytes(self) -> bytes:
        return (self.mark + self.text).encode(self.encoding)

    def edited(self, edits: Iterable[Edit]) -> "ProgramText":
        """The text with its words changed; no two edits overlap, and what comes last in one place stands first."""
        lines = list(self.lines)
        for line, column, length, text in sorted(edits, key=lambda edit: edit[:2], reverse=True):
            old = lines[line - 1]
            lines[line - 1] = old[: column - 1] + text + old[column - 1 + length :]
        return ProgramText(self.encoding, self.mark, tuple(lines))

    def changed(self, changes: Iterable[WordEdit], besides: Iterable[Edit] = ()) -> "ProgramText":
        """The text with blocks changed and a comment at the end of each of them, and with other edits."""
        said: dict[SourceText, list[str]] = {}
        edits: list[Edit] = []
        for source, edit, each in dict.fromkeys(changes):
            edits.append(edit)
            said.setdefault(source, []).append(each)
        comments = [comment_edit(source, ", ".join(texts)) for source, texts in said.items()]
        return self.edited([*besides, *comments, *edits])


def text_of(data: bytes) -> ProgramText:
    """The text of a file, in UTF-8 or else one byte a character."""
    try:
        encoding, text = "utf-8", data.decode("utf-8")
    except UnicodeDecodeError:
        encoding, text = LATIN, data.decode(LATIN)
    mark = BYTE_ORDER_MARK if text.startswith(BYTE_ORDER_MARK) else ""
    return ProgramText(encoding, mark, tuple(_LINE.findall(text[len(mark) :])))


def word_of(source: SourceText, letter: str) -> Word | None:
    """The word of a block with a letter; None if it has none."""
    return next((word for word in read_block(source).words if word.letter == letter), None)


def number_text(source: SourceText, word: Word) -> str:
    """The number of a word as it is written, sign included."""
    return _match(source, word)[2]


def other_number(source: SourceText, word: Word, number: str) -> WordEdit:
    """Another number in a word; its letter and the blanks around it stay."""
    match = _match(source, word)
    edit = Edit(source.line, source.column + match.start(2), len(match[2]), number)
    return WordEdit(source, edit, f"{word.letter}{match[2]} TO {word.letter}{number}")


def added_word(source: SourceText, letter: str, number: str) -> WordEdit:
    """A word behind the last one of a block, in the case and with the blanks of that block."""
    last = max(read_block(source).words, key=lambda word: word.column)
    letter_ends = last.column - source.column + 1
    end = letter_ends + len(last.expression.rstrip()) if last.expression else _match(source, last).end()
    before = source.text[:end]
    blank = " " if _BLANKS.search(before) else ""
    cased = letter.lower() if before == before.lower() else letter
    edit = Edit(source.line, source.column + end, 0, f"{blank}{cased}{number}")
    return WordEdit(source, edit, f"{letter}{number} ADDED")


def value_text(source: SourceText) -> str | None:
    """The number that a block assigns to a variable, as it is written; None of other blocks."""
    match = _ASSIGNMENT.fullmatch(source.text)
    return match[2] if match else None


def other_value(source: SourceText, number: str) -> WordEdit:
    """Another number in a block that assigns one to a variable."""
    match = _ASSIGNMENT.fullmatch(source.text)
    assert match is not None
    edit = Edit(source.line, source.column + match.start(2), len(match[2]), number)
    return WordEdit(source, edit, f"#{match[1]}={match[2]} TO #{match[1]}={number}")


def comment_edit(source: SourceText, text: str) -> Edit:
    """A comment at the end of a block."""
    return Edit(source.line, source.column + len(source.text), 0, f" ({text})")


def like(value: Decimal, written: str) -> str:
    """A number in the form of another one: its sign, its decimal point, its zero before the point."""
    sign, old = ("-" if "-" in written else "+" if "+" in written else ""), written.strip("+- \t")
    digits = f"{value.normalize():f}"
    if "." in old and "." not in digits:
        digits += "."
    if "." in digits and not old.startswith("0."):
        digits = digits.removeprefix("0") if digits != "0." else digits
    return f"{sign if value else sign.strip('-')}{digits}"


def sources_in(blocks: Iterable[SourceText], line: int) -> Sequence[SourceText]:
    """The blocks that stand in a line."""
    return [source for source in blocks if source.line == line]


def _match(source: SourceText, word: Word) -> re.Match[str]:
    match = _NUMBER.match(source.text, word.column - source.column)
    assert match is not None  # the word has been read as one with a number
    return match
