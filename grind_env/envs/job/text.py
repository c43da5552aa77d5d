"""A user's program as text: run for many parts, and with the words that an agent has chosen for its cycle blocks."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from grind_env.control import ControlError, Programs, read
from grind_env.control.rewriting import with_words
from grind_env.control.source import SourceText, readable
from grind_env.control.statements import Goto
from grind_env.control.words import Block, read_block
from grind_env.envs.job.outline import JobProgramError
from grind_env.envs.program_episode import Words

LOAD = ("G80", "M00", "G92.1", "G00 G18 G07 G71 G90 G94 G97 G40 G54")
"""What stands between two parts: the next one is loaded, and the modes are those in which a program begins (10-23)."""

MOST_PARTS = 1000
"""Parts for which a program can be run."""

_COMMENT = r"\([^()]*\)"
_END = re.compile(rf"({_COMMENT})|[Mm]0*(?:2|30)(?![\d.])")

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
        lines = _LINE.findall(readable(handle.read().decode("utf-8-sig", "surrogateescape")))
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
                "no single text says both; write its M98 calls and loops out"
            )
    for (line, column), (old, new) in sorted(changed.items(), reverse=True):
        text = lines[line - 1]
        lines[line - 1] = text[: column - 1] + new + text[column - 1 + len(old) :]
    return "".join(lines)


def batch_name(program: Path, parts: int) -> str:
    """What a program that is run for some parts is called in tables and folders: `plate_g82_x30`."""
    return f"{program.stem}_x{parts}" if parts > 1 else program.stem


def repeated(programs: Programs, parts: int) -> Programs:
    """A program that is run for many parts, as one program: an M00, at which the operator loads, in place of its end.

    The table is stopped and G92 cancelled before, as the end does; what G10 has written stays written.

    Args:
        programs: the program.
        parts: how often it is run.

    Raises:
        JobProgramError: it may come to its end in a subprogram, behind which the next part cannot begin, or it jumps
            by GOTO, which would lead from one part into another.
    """
    if parts == 1:
        return programs
    for block in programs.main.blocks:
        if _jumps(block):
            raise JobProgramError(
                f"{block.file}:{block.line}: the program jumps by GOTO and cannot be run for {parts} parts; loop by "
                "WHILE, or put what is jumped over into a subprogram"
            )
    for program in [*programs][1:]:
        for block in program.blocks:
            if _ends(block.text):
                raise JobProgramError(
                    f"{block.file}:{block.line}: the program ends in a subprogram and cannot be run for {parts} parts; "
                    "put its M30 into the main program"
                )
    blocks = [source.text for source in programs.main.blocks]
    ends = [number for number, text in enumerate(blocks) if _ends(text)]
    last = ends[0] if ends else len(blocks)
    last_block = [_END.sub(lambda match: match[1] or "", blocks[last])] if ends else []
    again = [*blocks[:last], *last_block, *LOAD]
    lines = again * (parts - 1) + blocks
    return read("\n".join([*lines, *_others(programs)]), programs.name, programs.folder)


def _others(programs: Programs) -> Iterator[str]:
    """The texts of the programs behind the main one."""
    for program in [*programs][1:]:
        yield f"O{program.number}"
        yield from (source.text for source in program.blocks)


def _jumps(source: SourceText) -> bool:
    try:
        return isinstance(read_block(source).statement, Goto)
    except ControlError:  # it is refused when it is executed
        return False


def _ends(text: str) -> bool:
    """Whether a block ends the program it stands in, and all that call it."""
    return any(match[1] is None for match in _END.finditer(text))
