"""Arithmetic in the place of numbers: ``X[#12+6]``, ``G[#1]``, ``X-#2`` (10-7, 10-23).

Of the paramacros of chapter 20 no more is known than that such expressions exist. D: ``+ - * /`` with the usual
precedence, nested brackets, one sign before an operand, and variables that a program can read and not set.
"""

import re
from collections.abc import Mapping
from decimal import ROUND_HALF_UP, Context, Decimal, DecimalException

from grind_env.control.errors import ControlError
from grind_env.control.reader import Block, Word
from grind_env.control.words import LONGEST_NUMBER, NO_VARIABLE_NUMBER
from grind_env.errors import shortened

DEEPEST_BRACKET = 20
DECIMALS = 10
"""Decimals of a value; beyond them stands what division by 3 and the like leave behind."""

_ARITHMETIC = Context(prec=50, rounding=ROUND_HALF_UP)
_LAST_DECIMAL = Decimal(1).scaleb(-DECIMALS)
_DIGITS = frozenset("0123456789")
_NUMBER = re.compile(r"[0-9 \t]*\.?[0-9 \t]*")
_VARIABLE_NUMBER = re.compile(r"[0-9 \t]*")
_NAME = re.compile(r"[A-Za-z]+")


def evaluated(block: Block, variables: Mapping[int, float]) -> Block:
    """The block with its expressions replaced by their values; the block itself if it has none.

    A value counts as written with a decimal point. The words still print as they were written.

    Args:
        block: as it was read.
        variables: finite values of the ``#`` variables by their numbers, as `Control` has checked them.

    Raises:
        ControlError: expression, what is wrong in one of them; not-supported, a function.
    """
    text = block.source.text
    if "[" not in text and "#" not in text:
        return block
    words = tuple(_evaluated_word(block, word, variables) if word.expression else word for word in block.words)
    return block if words == block.words else Block(block.source, block.place, words)


def _evaluated_word(block: Block, word: Word, variables: Mapping[int, float]) -> Word:
    try:
        value = _rounded(_Evaluation(block, word, variables).value())
    except DecimalException:
        message = f"the value of {word.letter} has more digits than the control can hold; use smaller numbers"
        raise block.error("expression", message, word) from None
    whole, _, decimals = f"{value.copy_abs():f}".partition(".")
    return word._replace(sign="-" if value < 0 else "", whole=whole, point=True, decimals=decimals.rstrip("0"))


def _rounded(value: Decimal) -> Decimal:
    return value.quantize(_LAST_DECIMAL, context=_ARITHMETIC)


class _Evaluation:
    """Evaluates the expression of a word from left to right."""

    def __init__(self, block: Block, word: Word, variables: Mapping[int, float]) -> None:
        self._block, self._word, self._variables = block, word, variables
        self._text, self._position, self._depth = word.expression, 0, 0

    def value(self) -> Decimal:
        """The value of a sign, if there is one, and of the bracket or the variable that is the whole expression."""
        return self._signed_operand()

    def _sum(self) -> Decimal:
        value = self._product()
        while (operator := self._next()) in ("+", "-"):
            self._position += 1
            operand = self._product()
            value = _ARITHMETIC.add(value, operand) if operator == "+" else _ARITHMETIC.subtract(value, operand)
        return value

    def _product(self) -> Decimal:
        value = self._signed_operand()
        while (operator := self._next()) in ("*", "/"):
            at = self._position
            self._position += 1
            operand = self._signed_operand()
            if operator == "*":
                value = _ARITHMETIC.multiply(value, operand)
            elif operand:
                value = _ARITHMETIC.divide(value, operand)
            else:
                raise self._error("a value is divided by 0; a divisor must not be 0", at)
        return value

    def _signed_operand(self) -> Decimal:
        sign = self._next()
        if sign not in ("+", "-"):
            return self._operand()
        self._position += 1
        value = self._operand()
        return value.copy_negate() if sign == "-" else value

    def _operand(self) -> Decimal:
        character = self._next()
        if character == "[":
            return self._bracket()
        if character == "#":
            return self._variable()
        if character == "." or character in _DIGITS:
            return Decimal(self._digits(_NUMBER))
        if character in "]+-*/":
            message = f"{character!r} follows no operand; a number, a # variable or a bracket must stand before it"
            raise self._error(message, self._position)
        raise self._misplaced(character)

    def _bracket(self) -> Decimal:
        if self._depth == DEEPEST_BRACKET:
            message = f"brackets are nested more than {DEEPEST_BRACKET} deep; {DEEPEST_BRACKET} are allowed"
            raise self._error(message, self._position)
        self._depth += 1
        self._position += 1
        value = self._sum()
        character = self._next()
        if character != "]":
            raise self._misplaced(character)
        self._depth -= 1
        self._position += 1
        return value

    def _variable(self) -> Decimal:
        """The value of ``#n`` or ``#[expression]``."""
        at = self._position
        self._position += 1
        if self._next() == "[":
            value = _rounded(self._bracket())
            if value != value.to_integral_value():
                raise self._error(f"#{value.normalize():f} is no variable; its number must be whole", at)
            number = int(value)
        elif self._next() in _DIGITS:
            number = int(self._digits(_VARIABLE_NUMBER))
        else:
            raise self._error(NO_VARIABLE_NUMBER, at)
        if number not in self._variables:
            raise self._error(f"#{number} has no value; give it one in the variables of the control", at)
        return Decimal(repr(float(self._variables[number])))

    def _digits(self, pattern: re.Pattern[str]) -> str:
        """The number that begins here, without its blanks."""
        at = self._position
        match = pattern.match(self._text, at)
        assert match is not None  # its first character has been seen
        self._position = match.end()
        digits = "".join(match[0].split())
        if digits == ".":
            raise self._error("'.' has no digits; a number must stand here", at)
        count = len(digits) - digits.count(".")
        if count > LONGEST_NUMBER:
            raise self._error(f"a number has {count} digits; {LONGEST_NUMBER} are allowed", at)
        return digits

    def _next(self) -> str:
        """The next character that is not blank; empty at the end."""
        while self._text.startswith((" ", "\t"), self._position):
            self._position += 1
        return self._text[self._position : self._position + 1]

    def _misplaced(self, character: str) -> ControlError:
        name = _NAME.match(self._text, self._position)
        if name is not None:
            column = self._word.column + 1 + self._position
            message = f"{shortened(name[0].upper())} is no part of an expression here; + - * / and brackets are"
            return self._block.place.error("not-supported", message, column)
        if character in "#[." or character in _DIGITS:
            return self._error(f"{character!r} follows an operand; + - * or / must stand between", self._position)
        message = f"{character!r} has no place in an expression; numbers, # variables, + - * / and brackets have"
        return self._error(message, self._position)

    def _error(self, message: str, position: int) -> ControlError:
        return self._block.place.error("expression", message, self._word.column + 1 + position)
