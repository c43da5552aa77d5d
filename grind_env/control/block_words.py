"""The words of a block (10-6, 10-7, 10-23): letters, numbers, comments, and expressions to evaluate later."""

import functools
import re
from decimal import Decimal
from typing import NamedTuple

from grind_env.control.errors import ControlError, Place
from grind_env.control.macro_formulas import LONGEST_NUMBER, NO_VARIABLE_NUMBER, FormulaFault
from grind_env.control.macro_statements import BEGIN, Statement, statement
from grind_env.control.program_scanner import SourceText
from grind_env.message_text import shortened

ADDRESSES = frozenset("DEFGIJKLMNOPQRSTXYZ")
ARGUMENTS = frozenset("ABCHUVW")  #: further letters, which only a block with G65 may have
REPEATABLE = frozenset("GM")
LONGEST_COMMENT = 128
LONGEST_LABEL = 5

#: a word in its usual form: capitals, no blanks. `_any_word` reads every form, but slower
_USUAL_WORD = re.compile(r"([DEFGI-TX-Z])([+-]?)([0-9]{0,15})(?:(\.)([0-9]{0,15}))?[ \t]*(?=[A-Z(]|$)")
_NUMBER = re.compile(r"[ \t]*([+-]?)[ \t]*([0-9 \t]*)(\.?)([0-9 \t]*)")
_VARIABLE = re.compile(r"#[ \t]*([0-9]?)[0-9 \t]*")
_BRACKET = re.compile(r"[\[\]]")
_COMMENT = re.compile(r"\(([^()]*)\)")
#: exponent of a number such as 1E-3. Without a sign it has one digit, because E words are larger than 9
_EXPONENT = re.compile(r"[Ee](?:[+-][0-9]{1,2}|0?[0-9])(?![0-9. \t]*[0-9.])")
_DECIMAL_COMMA = re.compile(r"([A-Za-z]?[ \t]*[+-]?[ \t]*[0-9]*),([0-9]+)")
_MACRO_CALL = re.compile(r"[Gg][ \t]*0*65(?![0-9.])")


ALONE = "it needs a block of its own"


class Word(NamedTuple):
    """An address letter and its number as written: sign, integer digits and decimals, without blanks."""

    letter: str
    sign: str
    whole: str
    point: bool
    decimals: str
    column: int  #: column of the letter in its line, from 1
    expression: str = ""  #: text behind the letter if it is no number; there are no digits until it is evaluated

    def __str__(self) -> str:
        if self.expression:
            return f"{self.letter}{shortened(self.expression.strip())}"
        return f"{self.letter}{self.sign}{self.whole}{'.' if self.point else ''}{self.decimals}"


class Block(NamedTuple):
    """A block that has been read: its words in textual order, without the N word, or its paramacro statement."""

    source: SourceText
    place: Place
    words: tuple[Word, ...]
    statement: Statement | None = None

    @property
    def has_expressions(self) -> bool:
        return ("[" in self.source.text or "#" in self.source.text) and any(word.expression for word in self.words)

    @property
    def calls_macro(self) -> bool:
        return any(word.letter == "G" and word.whole == "65" and not word.decimals for word in self.words)

    @property
    def is_plain(self) -> bool:
        return self.statement is None and not self.has_expressions and not self.calls_macro

    @property
    def comment(self) -> str:
        return " ".join(match.strip() for match in _COMMENT.findall(self.source.text))

    def error(self, name: str, message: str, word: Word | None = None) -> ControlError:
        return self.place.error(name, message, word.column if word else None)


@functools.lru_cache(maxsize=1024)
def read_block(source: SourceText) -> Block:
    """Read the words of a block."""
    text, column = source.text, source.column
    place, size = source.place, len(text)
    position = 1 if source.deletable else 0
    words: list[Word] = []
    seen: set[str] = set()
    said: Statement | None = None
    addresses = ADDRESSES | ARGUMENTS if _MACRO_CALL.search(_COMMENT.sub("", text)) else ADDRESSES
    while position < size:
        if BEGIN.match(text, position):
            said, position = _statement(text, position, place, column, alone=not words and said is None)
            continue
        match = _USUAL_WORD.match(text, position)
        if match is not None and (match[3] or match[5]):
            letter, sign, whole, point, decimals = match.groups("")
            word, end = Word(letter, sign, whole, bool(point), decimals, column + position), match.end()
        elif text[position].isascii() and text[position].isalpha():
            word, end = _any_word(text, position, place, column + position, addresses)
            letter = word.letter
        else:
            position = _after_blank_or_comment(text, position, place, column + position)
            continue
        if said is not None:
            raise place.error(
                "block-format", f"{word} stands in the block of a paramacro statement; {ALONE}", word.column
            )
        if letter == "E" and words and _is_exponent(text, position, words[-1]):
            raise _exponent(words[-1], word, text[position:end], place)
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
    return Block(source, place, tuple(words), said)


def _statement(text: str, start: int, place: Place, column: int, *, alone: bool) -> tuple[Statement, int]:
    if not alone:
        found = BEGIN.match(text, start)
        assert found is not None  # the caller has matched it
        name = found[0].rstrip(" \t[#0123456789").upper() or "#"
        raise place.error(
            "block-format", f"{name} begins a paramacro statement within a block; {ALONE}", column + start
        )
    try:
        return statement(text, start)
    except FormulaFault as fault:
        raise place.error(fault.name, fault.message, column + fault.position) from None


def _is_exponent(text: str, position: int, before: Word) -> bool:
    """Return whether an E directly follows the number of a word, like the E of an exponent."""
    number = before.letter not in REPEATABLE and text[position - 1] in ".0123456789"
    return number and _EXPONENT.match(text, position) is not None


def _exponent(before: Word, word: Word, power: str, place: Place) -> ControlError:
    """Return the error for a number with an exponent, whose E would be a separate word."""
    number = f"{before.sign}{before.whole or '0'}.{before.decimals or '0'}"
    value = Decimal(f"{number}{power.strip().replace(' ', '')}").normalize()
    message = f"{before}{power.strip()} looks like a number with an exponent; write {before.letter}{value:f}"
    return place.error("number-format", f"{message}, or a blank before E if it is a feed", word.column)


def _labelled(place: Place, word: Word) -> Place:
    if word.expression or word.sign or word.point or len(word.whole) > LONGEST_LABEL:
        raise place.error(
            "number-format", f"{word} is not a block label; N takes up to {LONGEST_LABEL} digits", word.column
        )
    return Place(place.file, place.line, place.column, int(word.whole))


def _after_blank_or_comment(text: str, start: int, place: Place, column: int) -> int:
    character = text[start]
    if character in " \t":
        return start + 1
    if character == ",":
        comma = next((match for match in _DECIMAL_COMMA.finditer(text) if match.end(1) == start), None)
        legal = "decimals follow a point, as in Y-0.1"
        if comma is not None:
            whole, decimals = comma[1].strip(), comma[2]
            is_either = len(decimals) == 3 and re.search("[1-9]", whole) is not None
            thousands = f"{whole}{decimals} if ',' separates thousands, else " if is_either else ""
            legal = f"write {thousands}{whole}.{decimals}"
        raise place.error("block-format", f"',' cannot begin a word; {legal}", column)
    if character != "(":
        raise place.error(*_stray(character), column)
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


def _any_word(text: str, start: int, place: Place, column: int, addresses: frozenset[str]) -> tuple[Word, int]:
    """Return the word at `start`, and the position after it; its number may have blanks or be an expression."""
    letter = text[start].upper()
    if letter not in addresses:
        known = " ".join(sorted(addresses))
        raise place.error("unknown-word", f"{letter} is not an address of this control; {known} are", column)
    match = _NUMBER.match(text, start + 1)
    assert match is not None  # every part of the pattern may be empty
    sign, point, end = match[1], match[3], match.end()
    whole, decimals = ("".join(match[group].split()) for group in (2, 4))
    digits = len(whole) + len(decimals)
    if digits > LONGEST_NUMBER:
        message = f"the number of {letter} has {digits} digits; {LONGEST_NUMBER} are allowed"
        raise place.error("number-format", message, column)
    if whole or decimals:
        return Word(letter, sign, whole, bool(point), decimals, column), end
    if point or not text.startswith(("[", "#"), end):
        zero = letter == "O" and start > 0 and text[start - 1] in ".0123456789"
        legal = "write a zero if this letter is to be one" if zero else "a number must follow"
        raise place.error("number-format", f"{letter}{sign}{point} has no digits; {legal}", column)
    end = _expression_end(text, end, place, column - start)
    return Word(letter, "", "", False, "", column, text[start + 1 : end]), end


def _expression_end(text: str, start: int, place: Place, first_column: int) -> int:
    variable = _VARIABLE.match(text, start)
    if variable is not None and variable[1]:
        return variable.end()
    begin = variable.end() if variable is not None else start
    if not text.startswith("[", begin):
        raise place.error("expression", NO_VARIABLE_NUMBER, first_column + start)
    depth = 0
    for bracket in _BRACKET.finditer(text, begin):
        depth += 1 if bracket[0] == "[" else -1
        if depth == 0:
            return bracket.end()
    raise place.error("expression", "'[' is not closed; a ']' is missing", first_column + begin)


def _stray(character: str) -> tuple[str, str]:
    if character == "/":
        return "block-format", "'/' stands inside a block; block delete is its first character"
    if character == ")":
        return "block-format", "')' closes no comment; '(' must open one before it"
    if character in "[]=":
        return "expression", f"{character!r} stands outside a value; an expression is written as in X[#1+2]"
    if character in "+-*":
        return "block-format", f"{character!r} stands outside brackets; arithmetic is written as in X[#1+2]"
    return "block-format", f"{character!r} cannot begin a word; words are a letter and a number"
