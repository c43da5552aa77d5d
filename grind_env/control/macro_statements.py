"""Blocks without motion that decide what is executed: assignments, jumps and loops of paramacros.

A statement is only read here; `control_flow.execute_statement` executes it.
"""

import re
from typing import NamedTuple, TypeAlias

from grind_env.control.macro_formulas import FormulaFault, Tree, Variable, formula, operand

LOOPS = (1, 2, 3)  #: numbers that DO and END may have

#: beginning of a statement; no word of a block begins like this
BEGIN = re.compile(r"#|(?:IF|WHILE|GOTO|DO|END)[ \t]*(?:[\[#0-9]|$)", re.IGNORECASE)
_KEYWORD = re.compile(r"[ \t]*(IF|THEN|WHILE|GOTO|DO|END)[ \t]*", re.IGNORECASE)
_EQUALS = re.compile(r"[ \t]*=[ \t]*")
_DIGITS = re.compile(r"[ \t]*([0-9]+)")

PREFIX = r"/?[ \t]*(?:\([^()]*\)[ \t]*)*"
_LABEL = re.compile(PREFIX + r"[Nn][ \t]*([0-9]{1,5})(?![0-9.])")
_END = re.compile(PREFIX + r"(?:[Nn][ \t]*[0-9]{1,5}[ \t]*)?END[ \t]*([0-9]+)", re.IGNORECASE)


class Assign(NamedTuple):
    """``#1=#2+3``."""

    target: Variable
    value: Tree


class Goto(NamedTuple):
    """``GOTO 10`` or ``IF [..] GOTO 10``; a condition of None always holds."""

    condition: Tree | None
    label: Tree


class Then(NamedTuple):
    """``IF [..] THEN #1=2``."""

    condition: Tree
    assign: Assign


class While(NamedTuple):
    """``WHILE [..] DO 1``, or ``DO 1`` alone, whose condition is None and always holds."""

    condition: Tree | None
    number: int


class End(NamedTuple):
    """``END 1``."""

    number: int


Statement: TypeAlias = Assign | Goto | Then | While | End


def statement(text: str, start: int) -> tuple[Statement, int]:
    """Return the statement that begins at `start`, and the position behind it."""
    if text.startswith("#", start):
        return _assignment(text, start)
    keyword, position = _keyword(text, start)
    if keyword == "GOTO":
        label, position = operand(text, position)
        return Goto(None, label), position
    if keyword in ("DO", "END"):
        number, position = _loop_number(text, position, keyword)
        return (While(None, number) if keyword == "DO" else End(number)), position
    if not text.startswith("[", position):
        raise FormulaFault(f"{keyword} lacks its condition; it is written as in {keyword} [#1 LT 5]", position)
    condition, position = operand(text, position)
    then, after = _keyword(text, position)
    if keyword == "WHILE":
        if then != "DO":
            raise FormulaFault("WHILE lacks DO; it is written as in WHILE [#1 LT 5] DO 1", position)
        number, after = _loop_number(text, after, "DO")
        return While(condition, number), after
    if then == "GOTO":
        label, after = operand(text, after)
        return Goto(condition, label), after
    if then == "THEN" and text.startswith("#", after):
        assign, after = _assignment(text, after)
        return Then(condition, assign), after
    message = "IF lacks what is to be done; it is written as in IF [#1 GT 5] GOTO 10 or IF [#1 GT 5] THEN #1=5"
    raise FormulaFault(message, position)


def label_of(text: str) -> int | None:
    """Return the N number with which the text of a block begins; None without one."""
    match = _LABEL.match(text)
    return int(match[1]) if match else None


def with_label(text: str, number: int) -> str:
    """Return the text of a block with another N number in place of the one at its beginning."""
    match = _LABEL.match(text)
    assert match is not None
    return f"{text[: match.start(1)]}{number}{text[match.end(1) :]}"


def end_of(text: str) -> int | None:
    """Return the loop number of an END block from its text; None for other blocks."""
    match = _END.match(text)
    return int(match[1]) if match else None


def _keyword(text: str, start: int) -> tuple[str, int]:
    match = _KEYWORD.match(text, start)
    return (match[1].upper(), match.end()) if match else ("", start)


def _assignment(text: str, start: int) -> tuple[Assign, int]:
    target, position = operand(text, start)
    assert isinstance(target, Variable)  # it begins with #
    match = _EQUALS.match(text, position)
    if match is None:
        raise FormulaFault("a # variable begins an assignment, which lacks =; it is written as in #1=5", position)
    value, position = formula(text, match.end())
    return Assign(target, value), position


def _loop_number(text: str, start: int, keyword: str) -> tuple[int, int]:
    match = _DIGITS.match(text, start)
    if match is None or int(match[1]) not in LOOPS:
        raise FormulaFault(f"{keyword} lacks the number of its loop; 1, 2 and 3 are", start)
    return int(match[1]), match.end()
