"""Bracket expressions and # variables (block-grammar 1.1)."""

from collections.abc import Mapping

from grind_env.control.reader import Block


def evaluated(block: Block, variables: Mapping[int, float]) -> Block:
    """The block with its expressions replaced by their values."""
    return block
