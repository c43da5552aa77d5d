"""Change numbers of single words in the text of a program; every other byte stays."""

import re
from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import NamedTuple

from grind_env.control import Programs
from grind_env.control.block_words import Word, read_block
from grind_env.control.macro_statements import PREFIX
from grind_env.control.macro_variables import LOCALS
from grind_env.control.program_scanner import SourceText
from grind_env.message_text import listed

BYTE_ORDER_MARK = "\ufeff"
LATIN = "latin-1"

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n|\Z)")
_NUMBER = re.compile(r"([A-Za-z][ \t]*)([+-]?[ \t]*[0-9. \t]*[0-9.])")
_ASSIGNMENT = re.compile(
    PREFIX + r"(?:[Nn][ \t]*[0-9]{1,5}[ \t]*)?#[ \t]*([0-9]+)[ \t]*="
    r"[ \t]*([-+]?[ \t]*(?:[0-9]+\.?[0-9]*|\.[0-9]+))[ \t]*(?:\([^()]*\)[ \t]*)*"
)
_BLANKS = re.compile(r"[ \t](?=[A-Za-z])")
COMMENT = re.compile(r"\([^()]*\)")
_READ = re.compile(r"[-+]?\[?[-+]?#([0-9]+)\]?")
_ANY = re.compile(r"#[ \t]*([0-9]+)")
_ASSIGNED = re.compile(r"#[ \t]*([0-9]+)[ \t]*=")
_WORKED_OUT = re.compile(r"#[ \t]*[\[#]")
_TURN = re.compile(r"GOTO|WHILE|DO[ \t]*[0-9]|M[ \t]*0*99(?![0-9])", re.IGNORECASE)
_MACRO = re.compile(r"[Gg][ \t]*0*65(?![0-9.])")


class Edit(NamedTuple):
    """Replacement of `length` characters of a line by a text; line and column count from 1."""

    line: int
    column: int
    length: int
    text: str


class WordEdit(NamedTuple):
    """Edit of a block, and the text of its comment."""

    source: SourceText
    edit: Edit
    said: str


@dataclass(frozen=True, slots=True)
class ProgramText:
    """Text of a program file as the control counts its lines and columns."""

    encoding: str  #: encoding of the file
    mark: str  #: the byte order mark, if there is one
    lines: tuple[str, ...]  #: lines with their ends

    @property
    def text(self) -> str:
        """Return the text without a byte order mark."""
        return "".join(self.lines)

    def bytes(self) -> bytes:
        return (self.mark + self.text).encode(self.encoding)

    def edited(self, edits: Iterable[Edit]) -> "ProgramText":
        """Return the text with edits, which do not overlap; of several at one place, the last is first in the text."""
        lines = list(self.lines)
        for line, column, length, text in sorted(edits, key=lambda edit: edit[:2], reverse=True):
            old = lines[line - 1]
            lines[line - 1] = old[: column - 1] + text + old[column - 1 + length :]
        return ProgramText(self.encoding, self.mark, tuple(lines))

    def changed(self, changes: Iterable[WordEdit], other_edits: Iterable[Edit] = ()) -> "ProgramText":
        """Return the text with changed words, a comment at the end of each changed block, and other edits."""
        said: dict[SourceText, list[str]] = {}
        edits: list[Edit] = []
        for source, edit, each in dict.fromkeys(changes):
            edits.append(edit)
            said.setdefault(source, []).append(each)
        comments = [comment_edit(source, ", ".join(texts)) for source, texts in said.items()]
        return self.edited([*other_edits, *comments, *edits])


def text_of(data: bytes) -> ProgramText:
    """Return the text of a file, in UTF-8 or else one byte a character."""
    try:
        encoding, text = "utf-8", data.decode("utf-8")
    except UnicodeDecodeError:
        encoding, text = LATIN, data.decode(LATIN)
    mark = BYTE_ORDER_MARK if text.startswith(BYTE_ORDER_MARK) else ""
    return ProgramText(encoding, mark, tuple(_LINE.findall(text[len(mark) :])))


def word_of(source: SourceText, letter: str) -> Word | None:
    """Return the word of a block with a letter; None if it has none."""
    return next((word for word in read_block(source).words if word.letter == letter), None)


def number_text(source: SourceText, word: Word) -> str:
    """Return the number of a word as it is written, sign included."""
    return _match(source, word)[2]


def other_number(source: SourceText, word: Word, number: str) -> WordEdit:
    """Return the edit that gives a word another number; the letter and the blanks around it stay."""
    match = _match(source, word)
    edit = Edit(source.line, source.column + match.start(2), len(match[2]), number)
    return WordEdit(source, edit, f"{word.letter}{match[2]} TO {word.letter}{number}")


def added_word(source: SourceText, letter: str, number: str) -> WordEdit:
    """Return the edit that adds a word behind the last word of a block, in the block's case and with its blanks."""
    last = max(read_block(source).words, key=lambda word: word.column)
    letter_ends = last.column - source.column + 1
    end = letter_ends + len(last.expression.rstrip()) if last.expression else _match(source, last).end()
    before = source.text[:end]
    blank = " " if _BLANKS.search(before) else ""
    cased = letter.lower() if before == before.lower() else letter
    edit = Edit(source.line, source.column + end, 0, f"{blank}{cased}{number}")
    return WordEdit(source, edit, f"{letter}{number} ADDED")


def other_value(source: SourceText, number: str) -> WordEdit:
    """Return the edit with which a block assigns another number to its variable."""
    match = _ASSIGNMENT.fullmatch(source.text)
    assert match is not None
    edit = Edit(source.line, source.column + match.start(2), len(match[2]), number)
    return WordEdit(source, edit, f"#{match[1]}={match[2]} TO #{match[1]}={number}")


def comment_edit(source: SourceText, text: str) -> Edit:
    """Return the edit that adds a comment at the end of a block."""
    return Edit(source.line, source.column + len(source.text), 0, f" ({text})")


def like(value: Decimal, written: str) -> str:
    """Return a number in the form of another one: its sign, its decimal point, its zero before the point."""
    sign, old = ("-" if "-" in written else "+" if "+" in written else ""), written.strip("+- \t")
    digits = f"{value.normalize():f}"
    if "." in old and "." not in digits:
        digits += "."
    if "." in digits and not old.startswith("0."):
        digits = digits.removeprefix("0") if digits != "0." else digits
    return f"{sign if value else sign.strip('-')}{digits}"


def _match(source: SourceText, word: Word) -> re.Match[str]:
    match = _NUMBER.match(source.text, word.column - source.column)
    assert match is not None  # the word has been read as one with a number
    return match


class Spot(NamedTuple):
    """Place of the number of a word in a cycle block, or the place to add it."""

    source: SourceText
    letter: str
    form: str  #: number as it is written, or the form of a new number
    missing: bool
    # number of the variable that the block assigns and the word reads; None if the word itself has the number
    variable: int | None = None

    @property
    def place(self) -> str:
        """The variable and the line that assigns it, as tables show them."""
        return f"#{self.variable}, line {self.source.line}"

    def change(self, number: str) -> WordEdit:
        """Return the change to another number, or to a variable, at this place."""
        if self.variable is not None:
            return other_value(self.source, number)
        word = word_of(self.source, self.letter)
        return added_word(self.source, self.letter, number) if word is None else other_number(self.source, word, number)


def variable_of(word: Word | None) -> int | None:
    """Return the variable that alone, or negated, is the value of a word; None for other words."""
    match = None if word is None else _READ.fullmatch("".join(word.expression.split()))
    return int(match[1]) if match else None


class Assignments:
    """Variables of a program, and where they are assigned and read."""

    def __init__(self, programs: Programs, given: Collection[int]) -> None:
        self.file, self.given = programs.name, given
        self._assigned: dict[int, list[SourceText]] = {}
        self._read: dict[int, Counter[SourceText]] = {}
        self._worked_out = self._macro = False
        for program in programs:
            for source in program.blocks:
                self._add(source)
        main = [*programs.main.blocks]
        straight = not any(_TURN.search(COMMENT.sub("", each.text)) for each in main)
        self._order = {source: number for number, source in enumerate(main)} if straight else {}

    def _add(self, source: SourceText) -> None:
        text = COMMENT.sub("", source.text)
        self._worked_out |= _WORKED_OUT.search(text) is not None
        self._macro |= _MACRO.search(text) is not None
        assigned = [int(number) for number in _ASSIGNED.findall(text)]
        for number in assigned:
            self._assigned.setdefault(number, []).append(source)
        for number, times in (Counter(map(int, _ANY.findall(text))) - Counter(assigned)).items():
            self._read.setdefault(number, Counter())[source] += times

    def place(self, variable: int, reader: SourceText) -> SourceText | None:
        """Return the block that assigns the variable that `reader` reads; None if the text does not determine it.

        The block is the only one that assigns the variable, or the last one before `reader` in a main program without
        jumps.
        """
        places = self._assigned.get(variable, [])
        if len(places) != 1:
            order = self._order
            known = all(each in order for each in (*places, reader))
            places = [each for each in places if known and order[each] < order[reader]][-1:]
        return places[0] if places else None

    def spot(self, variable: int, letter: str, readers: Sequence[SourceText]) -> Spot | str:
        """Return the only assignment of a variable that some blocks read, or what the user must change to have one."""
        place, places = self.place(variable, readers[0]), self._assigned.get(variable, [])
        others = self._read.get(variable, Counter()) - Counter(dict.fromkeys(readers, 1))
        others = Counter({each: n for each, n in others.items() if self.place(variable, each) in (place, None)})
        assigned = _ASSIGNMENT.fullmatch(place.text) if place else None
        own = "give it a variable of its own"
        reasons = {
            f"assign one in the program, for #{variable} has a value from outside": variable in self.given,
            "name variables by their numbers, for one whose number is worked out may be this one": self._worked_out,
            "take a variable from #100 on, for a G65 may assign this one": self._macro and variable in LOCALS,
            "change what is assigned": not places,
            f"{own}, for this one is assigned in {_lines(places)}": place is None,
            f"in {_lines([place] if place else [])}, where it is worked out": assigned is None,
            f"{own}, for this one is read in {_lines(others)}, too": bool(others),
            f"assign it in {self.file}": place is not None and place.file != self.file,
        }
        why = next((remedy for remedy, holds in reasons.items() if holds), None)
        if why is not None:
            return why
        assert assigned is not None and place is not None
        return Spot(place, letter, assigned[2], missing=False, variable=variable)


def _lines(sources: Collection[SourceText]) -> str:
    lines: Sequence[str] = [str(source.line) for source in sources]
    return f"line{'s' if len(lines) > 1 else ''} {listed(lines)}" if lines else "nothing"
