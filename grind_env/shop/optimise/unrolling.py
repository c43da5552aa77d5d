"""M98 calls written out, so that every run of a cycle block in a subprogram has words of its own."""

import re
from collections.abc import Sequence

from grind_env.control import Programs, read
from grind_env.control.cycles import RULES
from grind_env.control.reader import Program
from grind_env.control.source import SourceText
from grind_env.control.words import Word, read_block
from grind_env.errors import GrindError
from grind_env.shop.optimise.editing import ProgramText

MOST_LINES = 100_000

_JUMP = re.compile(r"GOTO|WHILE|\bIF\b", re.IGNORECASE)
_COMMENT = re.compile(r"\([^()]*\)")


class UnrollError(GrindError):
    """Calls that cannot be written out."""


def unrolled(programs: Programs, text: ProgramText) -> ProgramText:
    """The text with the blocks of subprograms in place of their calls, as far as these hold cycle blocks.

    Args:
        programs: what the text says.
        text: of the file.

    Raises:
        UnrollError: a call cannot be written out.
    """
    while (call := _next_call(programs)) is not None:
        source, program, times = call
        begin, end = _body(program)
        line = text.lines[source.line - 1]
        end_of_line = line[len(line.rstrip("\r\n")) :] or "\n"
        said = f"({source.text}){end_of_line}"
        lines = (*text.lines[: source.line - 1], said, *text.lines[begin:end] * times, *text.lines[source.line :])
        if len(lines) > MOST_LINES:
            raise UnrollError(f"{programs.name} has more than {MOST_LINES} lines with its calls written out")
        text = ProgramText(text.encoding, text.mark, lines)
        programs = read(text.text, programs.name, programs.folder)
    return text


def _next_call(programs: Programs) -> tuple[SourceText, Program, int] | None:
    """The first call of the main program whose subprogram has cycles, and how often it is made."""
    for source in programs.main.blocks:
        words = _words(source)
        if not any(word.letter == "M" and word.whole == "98" for word in words):
            continue
        number = next((word for word in words if word.letter == "P"), None)
        program = programs.find(int(number.whole)) if number is not None and number.whole else None
        if program is None or not _has_cycles(programs, program):
            continue
        place = f"{programs.name}:{source.line}"
        alone = {word.letter for word in words} <= {"M", "P", "L"} and "(" not in source.text
        if program.place.file != programs.name or not alone or source.text.startswith("/"):
            raise UnrollError(f"{place}: this call cannot be written out; let it stand alone, its program in this file")
        if sum(each.line == source.line for each in programs.main.blocks) > 1:
            raise UnrollError(f"{place}: this call cannot be written out; give it a line of its own")
        repeats = next((int(word.whole) for word in words if word.letter == "L" and word.whole), 1)
        return source, program, repeats
    return None


def _body(program: Program) -> tuple[int, int]:
    """The lines of a subprogram before its M99, from 0, as a slice."""
    sources = list(program.blocks)
    end = next((source for source in sources if _ends(source)), None)
    place = f"{program.place.file}:{program.place.line}"
    if end is None or len(_words(end)) > 1 or any(_JUMP.search(_COMMENT.sub("", each.text)) for each in sources):
        raise UnrollError(f"{place}: O{program.number} cannot be written out; it must run straight on to its M99")
    return program.place.line, end.line - 1


def _has_cycles(programs: Programs, program: Program, depth: int = 8) -> bool:
    """Whether a program, or one that it calls, has a cycle block."""
    for source in program.blocks:
        words = _words(source)
        if any(word.letter == "G" and f"G{word.whole}" in RULES for word in words):
            return True
        if depth and any(word.letter == "M" and word.whole == "98" for word in words):
            number = next((int(word.whole) for word in words if word.letter == "P" and word.whole), 0)
            called = programs.find(number)
            if called is not None and _has_cycles(programs, called, depth - 1):
                return True
    return False


def _ends(source: SourceText) -> bool:
    return any(word.letter == "M" and word.whole == "99" for word in _words(source))


def _words(source: SourceText) -> Sequence[Word]:
    try:
        return read_block(source).words
    except GrindError:  # never executed, or the run says so
        return ()
