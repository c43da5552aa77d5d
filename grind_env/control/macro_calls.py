"""The words of a G65 block: the macro that it calls, how often, and with which arguments (D: type I)."""

from collections.abc import Mapping
from decimal import Decimal
from typing import NamedTuple

from grind_env.control import numbers
from grind_env.control.block_words import Block, Word

MOST_REPEATS = 999

#: local variables that the letters of a G65 block assign
ARGUMENT_VARIABLES = {
    **{"A": 1, "B": 2, "C": 3, "I": 4, "J": 5, "K": 6, "D": 7, "E": 8, "F": 9, "H": 11, "M": 13, "Q": 17},
    **{"R": 18, "S": 19, "T": 20, "U": 21, "V": 22, "W": 23, "X": 24, "Y": 25, "Z": 26},
}


class MacroCall(NamedTuple):
    """A call of the program in a P word; `arguments` are local variables by number, None for M98."""

    block: Block
    program: Word
    times: int
    arguments: Mapping[int, Decimal] | None


def macro_call(block: Block) -> MacroCall:
    """Return the call of a G65 block whose expressions have been evaluated."""
    words: dict[str, Word] = {}
    for word in block.words:
        if word.letter in words:
            raise block.error(
                "block-format", f"{word} repeats the letter {word.letter}; G65 takes each letter once", word
            )
        words[word.letter] = word
    if "P" not in words:
        raise block.error("missing-parameter", "G65 lacks P; it takes the number of the macro program")
    if "O" in words:
        raise block.error("block-format", f"{words['O']} is no argument of G65; {' '.join(ARGUMENT_VARIABLES)} are")
    arguments = {
        ARGUMENT_VARIABLES[letter]: Decimal(f"{word.sign}{word.whole or '0'}.{word.decimals}")
        for letter, word in words.items()
        if letter not in "GPL"
    }
    return MacroCall(block, words["P"], repeats(block, words), arguments)


def repeats(block: Block, words: Mapping[str, Word]) -> int:
    """Return how often a call is executed: the value of L, or 1."""
    return numbers.integer(block, words["L"], 0, MOST_REPEATS) if "L" in words else 1
