"""A part program with the words that an agent has chosen for its cycle blocks."""

import re
from collections.abc import Sequence

from grind_env.control import Programs
from grind_env.control.rewriting import with_words
from grind_env.control.words import Block
from grind_env.envs.job.outline import JobProgramError
from grind_env.envs.program_episode import Words

_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n|\Z)")


def with_words_chosen(programs: Programs, chosen: Sequence[tuple[Block, Words]]) -> str:
    """The text of the main program's file with other numbers in the words of blocks that have been run.

    Args:
        programs: the program.
        chosen: blocks as they were read, each with numbers by letter.

    Raises:
        JobProgramError: a block stands in another file, or was run twice with different words.
    """
    with programs.main.blocks.text.open() as handle:
        lines = _LINE.findall(handle.read().decode("utf-8-sig"))
    changed: dict[tuple[int, int], tuple[str, str]] = {}
    for block, words in chosen:
        source = block.source
        if source.file != programs.name:
            raise JobProgramError(
                f"{source.file}:{source.line}: the cycle block is in another file than {programs.name}; put all "
                "programs into one file to have them with the words chosen"
            )
        text = with_words(block, words).source.text
        if changed.setdefault((source.line, source.column), (source.text, text))[1] != text:
            raise JobProgramError(
                f"{source.file}:{source.line}: the cycle block has run more than once with different words, so that "
                "no single text says both; write its M98 calls out"
            )
    for (line, column), (old, new) in sorted(changed.items(), reverse=True):
        text = lines[line - 1]
        lines[line - 1] = text[: column - 1] + new + text[column - 1 + len(old) :]
    return "".join(lines)
