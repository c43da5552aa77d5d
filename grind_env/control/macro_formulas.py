"""Paramacro expressions: text to a tree, and a tree to its value (20-2; functions D).

Values are decimal numbers, so that 0.1+0.2 is 0.3; values of variables, words and comparisons are rounded to
`DECIMALS`. A vacant variable is None, which only copies, EQ and NE accept.
"""

import functools
import re
from collections.abc import Callable
from decimal import ROUND_HALF_UP, Context, Decimal
from typing import NamedTuple, TypeAlias

from grind_env.control import macro_functions
from grind_env.control.macro_functions import FunctionFault
from grind_env.message_text import did_you_mean, shortened

DEEPEST_BRACKET = 20
LONGEST_NUMBER = 30  #: most digits of a number in a program
DECIMALS = 10  #: decimals of a value; further ones are rounding errors, as of a division by 3
ARITHMETIC = Context(prec=50, rounding=ROUND_HALF_UP)

NO_VARIABLE_NUMBER = "'#' lacks the number of a variable; write #1 or #[1+2]"
COMPARISONS = ("EQ", "NE", "GT", "GE", "LT", "LE")
LOGIC = ("AND", "OR", "XOR")
PRODUCTS = ("*", "/", "MOD")
SUMS = ("+", "-", *LOGIC)
BEHIND_CONDITIONS = ("GOTO", "THEN", "DO")
KNOWN = (*macro_functions.FUNCTIONS, "ATAN", *COMPARISONS, *LOGIC, "MOD")

_LAST_DECIMAL = Decimal(1).scaleb(-DECIMALS)
_DIGITS = frozenset("0123456789")
_NUMBER = re.compile(r"[0-9 \t]*\.?[0-9 \t]*")
_WHOLE_NUMBER = re.compile(r"[0-9 \t]*")
_NAME = re.compile(r"[A-Za-z]+")
_OPERATOR = re.compile(r"[ \t]*(MOD|AND|XOR|OR|EQ|NE|GT|GE|LT|LE|[-+*/])", re.IGNORECASE)

Value: TypeAlias = "Decimal | None"
#: function that returns the value of a variable by number, or raises a `VariableFault`
Read: TypeAlias = Callable[[int], Value]


class FormulaFault(ValueError):
    """An expression that cannot be read or has no value; the text is a sentence with the remedy."""

    def __init__(self, message: str, position: int, name: str = "expression") -> None:
        self.name, self.message, self.position = name, message, position
        super().__init__(message)


class VariableFault(ValueError):
    """A variable that cannot be read or written; the text is a sentence with the remedy."""


class Number(NamedTuple):
    """A number as written."""

    value: Decimal


class Variable(NamedTuple):
    """``#n`` or ``#[n]``; `at` is the position of the ``#``, in a `Function` that of its name."""

    number: "Tree"
    at: int


class Negative(NamedTuple):
    """An operand behind a minus sign."""

    operand: "Tree"


class Chain(NamedTuple):
    """Operands joined by operators of one rank, evaluated from left to right (20-2); `rest` has their positions."""

    first: "Tree"
    rest: tuple[tuple[str, int, "Tree"], ...]


class Comparison(NamedTuple):
    """A comparison, whose value is 1 if it holds and 0 if not."""

    left: "Tree"
    operator: str
    right: "Tree"


class Function(NamedTuple):
    """A function of the bracket behind it; `second` is the other bracket of ``ATAN[ ]/[ ]``."""

    name: str
    at: int
    argument: "Tree"
    second: "Tree | None"


Tree: TypeAlias = Number | Variable | Negative | Chain | Comparison | Function


@functools.lru_cache(maxsize=4096)
def formula(text: str, start: int = 0) -> tuple[Tree, int]:
    """Return the expression that begins at `start`, and the position behind it."""
    reader = _Reader(text, start)
    return reader.comparison(), reader.position


@functools.lru_cache(maxsize=4096)
def operand(text: str, start: int = 0) -> tuple[Tree, int]:
    """Return the number, variable, bracket or function, perhaps signed, at `start`, and the position behind it."""
    reader = _Reader(text, start)
    return reader.signed_operand(), reader.position


def value_of(tree: Tree, read: Read) -> Value:
    """Return the value of an expression, rounded; None if it is a vacant variable."""
    found = _value(tree, read)
    return None if found is None else rounded(found)


def number_of(tree: Tree, read: Read) -> Decimal:
    """Return the rounded value of an expression that must have one."""
    return rounded(_number(tree, read))


def rounded(value: Decimal) -> Decimal:
    """Return a value rounded to `DECIMALS`, as variables, words and comparisons take it."""
    return value.quantize(_LAST_DECIMAL, context=ARITHMETIC) + 0


def _value(tree: Tree, read: Read) -> Value:
    match tree:
        case Number(value):
            return value
        case Variable(at=at):
            number = variable_number(tree, read)
            try:
                return read(number)
            except VariableFault as fault:
                raise FormulaFault(str(fault), at) from None
        case Negative(operand):
            return _number(operand, read).copy_negate()
        case Chain(first, rest):
            result = _number(first, read)
            for operator, at, operand in rest:
                result = _joined(operator, at, result, _number(operand, read))
            return result
        case Comparison(left, operator, right):
            return Decimal(_holds(operator, left, right, read))
        case Function(name, at, argument, second):
            given = rounded(_number(argument, read))
            try:
                if name == "ATAN":
                    return macro_functions.arc_tangent(given, Decimal(1) if second is None else _number(second, read))
                return macro_functions.FUNCTIONS[name](given)
            except FunctionFault as fault:
                raise FormulaFault(str(fault), at) from None


def _number(tree: Tree, read: Read) -> Decimal:
    found = _value(tree, read)
    if found is None:
        assert isinstance(tree, Variable)  # nothing else is vacant
        raise FormulaFault(vacant(variable_number(tree, read)), tree.at)
    return found


def vacant(number: int) -> str:
    """Return the error sentence for a variable that needs a value and has none."""
    if number == 0:
        return "#0 never has a value; it stands for a vacant variable behind = EQ and NE only"
    return f"#{number} has no value; assign one before, as in #{number}=1, or give it with --set '#{number}=1'"


def variable_number(tree: Variable, read: Read) -> int:
    """Return the number of a variable."""
    number = rounded(_number(tree.number, read))
    if number != number.to_integral_value():
        message = f"#{number.normalize():f} is no variable; its number must be whole"
        raise FormulaFault(message, tree.at)
    return int(number)


def _joined(operator: str, at: int, left: Decimal, right: Decimal) -> Decimal:
    if operator in LOGIC:
        return _bitwise(operator, at, left, right)
    if operator == "+":
        return ARITHMETIC.add(left, right)
    if operator == "-":
        return ARITHMETIC.subtract(left, right)
    if operator == "*":
        return ARITHMETIC.multiply(left, right)
    if not right:
        raise FormulaFault("a value is divided by 0; a divisor must not be 0", at)
    return ARITHMETIC.divide(left, right) if operator == "/" else ARITHMETIC.remainder(left, right)


def _bitwise(operator: str, at: int, left: Decimal, right: Decimal) -> Decimal:
    a, b = rounded(left), rounded(right)
    if a != a.to_integral_value() or b != b.to_integral_value():
        message = f"{operator} joins whole numbers and comparisons in brackets, as in [[#1 GT 2] {operator} [#2 LT 3]]"
        raise FormulaFault(message, at)
    m, n = int(a), int(b)
    return Decimal({"AND": m & n, "OR": m | n, "XOR": m ^ n}[operator])


def _holds(operator: str, left: Tree, right: Tree, read: Read) -> bool:
    if operator in ("EQ", "NE"):
        return (value_of(left, read) == value_of(right, read)) == (operator == "EQ")
    a, b = number_of(left, read), number_of(right, read)
    return {"GT": a > b, "GE": a >= b, "LT": a < b, "LE": a <= b}[operator]


class _Reader:
    """Reader of an expression from left to right."""

    def __init__(self, text: str, start: int) -> None:
        self._text, self.position, self._depth = text, start, 0

    def comparison(self) -> Tree:
        left = self._chain(SUMS)
        operator = self._operator(COMPARISONS)
        if not operator:
            return left
        right = self._chain(SUMS)
        if self._operator(COMPARISONS):
            message = "a comparison follows a comparison; put each into brackets, as in [[#1 GT 2] AND [#1 LT 5]]"
            raise FormulaFault(message, self.position - 2)
        return Comparison(left, operator, right)

    def _chain(self, operators: tuple[str, ...]) -> Tree:
        read = self.signed_operand if operators is PRODUCTS else functools.partial(self._chain, PRODUCTS)
        first, rest = read(), []
        while operator := self._operator(operators):
            at = self.position - len(operator)
            rest.append((operator, at, read()))
        return Chain(first, tuple(rest)) if rest else first

    def _operator(self, operators: tuple[str, ...]) -> str:
        match = _OPERATOR.match(self._text, self.position)
        if match is None or match[1].upper() not in operators:
            return ""
        self.position = match.end()
        return match[1].upper()

    def signed_operand(self) -> Tree:
        sign = self._next()
        if sign not in ("+", "-"):
            return self._operand()
        self.position += 1
        tree = self._operand()
        return Negative(tree) if sign == "-" else tree

    def _operand(self) -> Tree:
        character = self._next()
        if character == "[":
            return self._bracket()
        if character == "#":
            return self._variable()
        if character == "." or character in _DIGITS:
            return Number(Decimal(self._digits(_NUMBER)))
        name = _NAME.match(self._text, self.position)
        if name is not None:
            return self._function(name[0].upper())
        if not character or character in "]+-*/":
            shown = repr(character) if character else "the end"
            message = f"{shown} follows no operand; a number, a # variable or a bracket must stand before it"
            raise FormulaFault(message, self.position)
        raise self.misplaced()

    def _bracket(self) -> Tree:
        if self._depth == DEEPEST_BRACKET:
            message = f"brackets are nested more than {DEEPEST_BRACKET} deep; {DEEPEST_BRACKET} are allowed"
            raise FormulaFault(message, self.position)
        self._depth += 1
        self.position += 1
        tree = self.comparison()
        if self._next() != "]":
            raise self.misplaced()
        self._depth -= 1
        self.position += 1
        return tree

    def _variable(self) -> Variable:
        at = self.position
        self.position += 1
        if self._next() == "[":
            return Variable(self._bracket(), at)
        if self._next() in _DIGITS:
            return Variable(Number(Decimal(self._digits(_WHOLE_NUMBER))), at)
        raise FormulaFault(NO_VARIABLE_NUMBER, at)

    def _function(self, name: str) -> Tree:
        at = self.position
        if name not in macro_functions.FUNCTIONS and name != "ATAN":
            raise self.misplaced()
        self.position += len(name)
        if self._next() != "[":
            raise FormulaFault(f"{name} lacks its bracket; it is written as in {name}[#1]", at)
        argument, second = self._bracket(), None
        if name == "ATAN" and self._next() == "/":
            slash = self.position
            self.position += 1
            if self._next() == "[":
                second = self._bracket()
            else:
                self.position = slash
        return Function(name, at, argument, second)

    def _digits(self, pattern: re.Pattern[str]) -> str:
        at = self.position
        match = pattern.match(self._text, at)
        assert match is not None  # the caller has seen its first character
        self.position = match.end()
        digits = "".join(match[0].split())
        if digits == ".":
            raise FormulaFault("'.' has no digits; a number must stand here", at)
        count = len(digits) - digits.count(".")
        if count > LONGEST_NUMBER:
            raise FormulaFault(f"a number has {count} digits; {LONGEST_NUMBER} are allowed", at)
        return digits

    def _next(self) -> str:
        while self._text.startswith((" ", "\t"), self.position):
            self.position += 1
        return self._text[self.position : self.position + 1]

    def misplaced(self) -> FormulaFault:
        character = self._next()
        name = _NAME.match(self._text, self.position)
        if name is not None:
            word = name[0].upper()
            if word in BEHIND_CONDITIONS:
                return FormulaFault(f"']' is missing before {word}; a condition stands in brackets", self.position)
            close = did_you_mean(word, KNOWN)
            message = f"{shortened(word)} is no part of an expression here{close}; it has {', '.join(KNOWN)}"
            return FormulaFault(message, self.position, "not-supported")
        if character in ("#", "[", ".") or (character and character in _DIGITS):
            return FormulaFault(f"{character!r} follows an operand; + - * or / must stand between", self.position)
        if not character:
            return FormulaFault("'[' is not closed; a ']' is missing", self.position)
        if character in "=<>":
            message = f"{character!r} compares nothing here; comparisons are {', '.join(COMPARISONS)}"
            return FormulaFault(message, self.position)
        message = f"{character!r} has no place in an expression; numbers, # variables, + - * / and brackets have"
        return FormulaFault(message, self.position)
