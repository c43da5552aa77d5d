"""Expressions in place of numbers: ``X[#12+6]``, ``G[#1]``, ``X-#2``, ``E#101`` (10-7, 10-23)."""

from decimal import Decimal, DecimalException

from grind_env.control.block_words import Block, Word
from grind_env.control.errors import ControlError
from grind_env.control.macro_formulas import FormulaFault, Read, number_of, operand
from grind_env.control.macro_variables import Variables

MORE_DIGITS = "has more digits than the control can hold; use smaller numbers"


def evaluated(block: Block, variables: Variables) -> Block:
    """Return the block with its expressions replaced by their values; the block itself if it has none.

    A value counts as written with a decimal point. The words still print as they were written.
    """
    if not block.has_expressions:
        return block
    words = tuple(_evaluated(block, word, variables.read) for word in block.words)
    return block if words == block.words else block._replace(words=words)


def foreseen(block: Block) -> Block:
    """Return the block with its constant expressions replaced by their values."""
    if not block.has_expressions:
        return block
    return block._replace(words=tuple(_foreseen(block, word) for word in block.words))


def fault_in(block: Block, fault: FormulaFault, first: int) -> ControlError:
    """Return the error for a fault in the part of the block's text that begins at position `first`."""
    return block.place.error(fault.name, fault.message, block.source.column + first + fault.position)


class _UnknownError(Exception):
    """A variable whose value is known only at execution."""


def _foreseen(block: Block, word: Word) -> Word:
    def unknown(number: int) -> Decimal | None:
        raise _UnknownError

    try:
        return _evaluated(block, word, unknown)
    except _UnknownError:
        return word


def _evaluated(block: Block, word: Word, read: Read) -> Word:
    if not word.expression:
        return word
    first = word.column + 1 - block.source.column
    try:
        tree, end = operand(word.expression)
        assert not word.expression[end:].strip()  # the word ends with its bracket or variable
        value = number_of(tree, read)
    except FormulaFault as fault:
        raise fault_in(block, fault, first) from None
    except DecimalException:
        raise block.error("expression", f"the value of {word.letter} {MORE_DIGITS}", word) from None
    whole, _, decimals = f"{value.copy_abs():f}".partition(".")
    return word._replace(sign="-" if value < 0 else "", whole=whole, point=True, decimals=decimals.rstrip("0"))
