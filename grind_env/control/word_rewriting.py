"""Change of words in the text of a block."""

import re
from collections.abc import Mapping

from grind_env.control.block_words import Block, read_block

#: a word with a number, without the blanks behind it
_NUMBER = re.compile(r"[A-Za-z][ \t]*[+-]?[ \t]*[0-9. \t]*[0-9.]")


def with_words(block: Block, values: Mapping[str, str]) -> Block:
    """Return the block with the given numbers, by letter of the word; a missing word is added at the end."""
    for letter, value in values.items():
        text, word = block.source.text, next((word for word in block.words if word.letter == letter), None)
        if word is None:
            text = f"{text} {letter}{value}"
        else:
            begin = word.column - block.source.column
            match = _NUMBER.match(text, begin)
            end = match.end() if match else begin + 1 + len(word.expression.rstrip())
            text = f"{text[:begin]}{letter}{value}{text[end:]}"
        block = read_block(block.source._replace(text=text))
    return block
