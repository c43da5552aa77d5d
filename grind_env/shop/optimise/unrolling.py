"""M98 calls written out, so that every run of a cycle block in a subprogram has words of its own."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TypeAlias

from grind_env.control import Programs, read
from grind_env.control.cycles import RULES
from grind_env.control.interpreter import DEEPEST
from grind_env.control.reader import Program
from grind_env.control.source import SourceText
from grind_env.control.words import Word, read_block
from grind_env.errors import GrindError
from grind_env.shop.optimise.editing import ProgramText

MOST_LINES = 100_000

_JUMP = re.compile(r"GOTO|WHILE|\bIF\b", re.IGNORECASE)
_COMMENT = re.compile(r"\([^()]*\)")


Call: TypeAlias = tuple[SourceText, Program, int]
"""The block of an M98, what it calls, and how often."""


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
    for _ in range(DEEPEST + 1):
        calls = list(_calls(programs))
        if not calls:
            return text
        text = _written_out(programs, text, calls)
        programs = read(text.text, programs.name, programs.folder)
    raise UnrollError(f"{programs.name}: its calls nest more than {DEEPEST} levels deep, and the control takes no more")


def _written_out(programs: Programs, text: ProgramText, calls: Sequence[Call]) -> ProgramText:
    """The text with the blocks of subprograms in place of some calls of the main program, one level deep."""
    lines: list[str] = []
    done = 0
    bodies: dict[int | None, tuple[int, int]] = {}
    for source, program, times in calls:
        if program.number not in bodies:
            bodies[program.number] = _body(program)
        begin, end = bodies[program.number]
        line = text.lines[source.line - 1]
        end_of_line = line[len(line.rstrip("\r\n")) :] or "\n"
        lines += (*text.lines[done : source.line - 1], f"({source.text}){end_of_line}")
        done = source.line
        if len(lines) + (end - begin) * times + len(text.lines) - done > MOST_LINES:
            raise UnrollError(f"{programs.name} has more than {MOST_LINES} lines with its calls written out")
        lines += text.lines[begin:end] * times
    return ProgramText(text.encoding, text.mark, (*lines, *text.lines[done:]))


def _calls(programs: Programs) -> Iterator[Call]:
    """The calls of the main program whose subprogram has cycles."""
    in_line = Counter(source.line for source in programs.main.blocks)
    cycles: dict[int | None, bool] = {}
    for source in programs.main.blocks:
        words = _words(source)
        if not any(word.letter == "M" and word.whole == "98" for word in words):
            continue
        number = next((word for word in words if word.letter == "P"), None)
        program = programs.find(int(number.whole)) if number is not None and number.whole else None
        if program is None:
            continue
        if program.number not in cycles:
            cycles[program.number] = _has_cycles(programs, program)
        if not cycles[program.number]:
            continue
        place = f"{programs.name}:{source.line}"
        alone = {word.letter for word in words} <= {"M", "P", "L"} and "(" not in source.text
        if program.place.file != programs.name or not alone or source.text.startswith("/"):
            raise UnrollError(f"{place}: this call cannot be written out; let it stand alone, its program in this file")
        if in_line[source.line] > 1:
            raise UnrollError(f"{place}: this call cannot be written out; give it a line of its own")
        repeats = next((int(word.whole) for word in words if word.letter == "L" and word.whole), 1)
        yield source, program, repeats


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
