"""Advice as paramacro variables, in a file that the control runs before the blocks that read them."""

import re
from collections.abc import Sequence
from pathlib import Path

from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import BlockOutline, JobChoice
from grind_env.envs.program_episode import Words
from grind_env.files import write_atomically
from grind_env.machine.part.feed_moves import speed_word
from grind_env.shop.advise.adviser import Advice, AdviceError

FIRST = 101  #: first common variable for E and D in a program that names no variables
_PROGRAM = re.compile(r"[Oo](\d{1,8})")


def variables_of(block: BlockOutline, place: int) -> tuple[int, int]:
    """Return the numbers of the variables in the E and D words of a block (F of a feed move that is a stroke).

    Without variables: #101 and #102, #103 and #104 for the next block, ... by its `place` in the part, from 0.
    """
    found = []
    for k, letter in enumerate((speed_word(block.plan), "D")):
        match = re.search(rf"(?<![A-Z]){letter}\s*(?:#\s*(\d+)|\[)", block.block.source.text.upper())
        if match and not match[1]:
            raise AdviceError(
                f"line {block.block.source.line}: {letter} is an expression, for which no value can be written: "
                f"let it be a variable, such as {letter}#{FIRST + k}"
            )
        found.append(int(match[1]) if match else FIRST + 2 * place + k)
    return found[0], found[1]


def check_free(simulation: JobSimulation, path: Path) -> None:
    """Refuse to write variables that the program sets itself, or uses for something else."""
    called = _PROGRAM.fullmatch(path.stem)
    written = int(called[1]) if called else -1
    programs = simulation.programs
    others = [each for each in programs if each is not programs.find(written)]
    lines = [source for each in others for source in each.blocks]
    for number, block in _of_first_part(simulation):
        # checked block by block: with --rows block, several blocks may read the same variables
        for letter, variable in zip((speed_word(block.plan), "D"), variables_of(block, number), strict=True):
            own = re.compile(rf"(?<![A-Z]){letter}\s*#\s*{variable}(?!\d)")
            said = own.search(block.block.source.text.upper()) is not None
            for source in lines:
                text = re.sub(r"\([^()]*\)", "", source.text.upper())
                sets = re.search(rf"#\s*{variable}\s*=", text)
                uses = re.search(rf"#\s*{variable}(?!\d)", own.sub("", text))
                if sets or (uses and not said):
                    raise AdviceError(
                        f"line {source.line}: the program {'sets' if sets else 'uses'} #{variable} itself, which would "
                        f"be written for {letter} of its line {block.block.source.line}: let that say {letter}# with a "
                        "number that is free"
                    )


def check_variables(simulation: JobSimulation) -> None:
    """Refuse to write the values of several blocks at once, unless each has its own variables."""
    taken: dict[int, int] = {}
    for number, block in _of_first_part(simulation):
        for variable in variables_of(block, number):
            if variable in taken:
                raise AdviceError(
                    f"blocks {taken[variable] + 1} and {number + 1} of one part both read #{variable}: give each "
                    "its own variables, or advise --rows block"
                )
            taken[variable] = number


def _of_first_part(simulation: JobSimulation) -> list[tuple[int, BlockOutline]]:
    return [each for each in enumerate(simulation.blocks) if each[1].part == simulation.blocks[0].part]


def write_values(path: Path, simulation: JobSimulation, advice: Sequence[Advice]) -> None:
    """Write assignments of E and D of all blocks of a part atomically; errors as in `write_atomically`.

    A block without advice has E and D of the program, so that the part program runs from the beginning. E is in the
    units of the program. A file named `O<number>.nc` is a subprogram, which `M98 P<number>` or `G65 P<number>` runs;
    the operator runs any other file.
    """
    values, first = dict[int, str](), dict[int, int]()
    for number, block in enumerate(simulation.blocks):
        if first.setdefault(block.part, number) == 0:
            own = block.words(JobChoice(block.plan.feed, int(block.plan.dresses)))
            values |= _assignments(block, number, own, "AS PROGRAMMED")
    for each in advice:
        block = simulation.blocks[each.block]
        source = f"PART {block.part + 1}, BLOCK {each.block + 1}"
        values |= _assignments(block, each.block - first[block.part], each.words, source)
    called = _PROGRAM.fullmatch(path.stem)
    text = "\n".join([*([f"O{called[1]}"] if called else []), *values.values(), "M99" if called else "M30"]) + "\n"
    write_atomically(path, lambda partial: partial.write_text(text, encoding="ascii"))


def _assignments(block: BlockOutline, place: int, words: Words, source: str) -> dict[int, str]:
    (E, D), unit = variables_of(block, place), "INCH/MIN" if block.inch else "MM/MIN"
    letter = speed_word(block.plan)
    lines = {E: f"#{E}={words[letter]} ({letter}, {unit}, {source})"}
    return lines | ({D: f"#{D}={words['D']} (D)"} if "D" in words else {})
