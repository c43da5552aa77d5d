"""Advice as values of paramacro variables, in a file that the control runs before the blocks that read them."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from grind_env.envs.job.outline import BlockOutline
from grind_env.envs.job.simulation import JobSimulation
from grind_env.errors import GrindError
from grind_env.files import write_atomically
from grind_env.shop.advise.adviser import Advice

FIRST = 101
"""Common variable with which E and D begin where the program names none."""
_PROGRAM = re.compile(r"[Oo](\d{1,8})")


class ValuesError(GrindError):
    """Two blocks of a part that read the same variable."""


class Variables(NamedTuple):
    """Numbers of the variables that a block reads."""

    E: int
    D: int


def variables_of(block: BlockOutline, place: int) -> Variables:
    """Those that stand in the E and D words of a block; else #101 and #102, #103 and #104 for the next block, ...

    Args:
        block: of the program.
        place: of the block in its part, from 0.
    """
    found = [re.search(rf"(?<![A-Z]){letter}\s*#\s*(\d+)", block.block.source.text.upper()) for letter in "ED"]
    return Variables(
        *(int(match[1]) if match else FIRST + 2 * place + k for k, match in enumerate(found)),
    )


def check_variables(simulation: JobSimulation) -> None:
    """Refuse to write the values of several blocks at once, unless each has its own variables.

    Raises:
        ValuesError: two blocks of a part read the same one.
    """
    for part in range(simulation.parts):
        taken: dict[int, int] = {}
        numbers = [number for number, block in enumerate(simulation.blocks) if block.part == part]
        for place, number in enumerate(numbers):
            for variable in variables_of(simulation.blocks[number], place):
                if variable in taken:
                    raise ValuesError(
                        f"blocks {taken[variable] + 1} and {number + 1} of one part both read #{variable}: give each "
                        "its own variables, or advise --by block"
                    )
                taken[variable] = number


def write_values(path: Path, simulation: JobSimulation, advice: Sequence[Advice]) -> None:
    """Write assignments of E and D, whole or not at all; errors as of `write_atomically`.

    A file named `O<number>.nc` is a subprogram, which `M98 P<number>` or `G65 P<number>` runs; any other a program that
    the operator runs. E is in the units of the program.

    Args:
        path: of the file.
        simulation: of the program.
        advice: on blocks of one part.
    """
    called = _PROGRAM.fullmatch(path.stem)
    lines = [f"O{called[1]}"] if called else []
    for each in advice:
        block = simulation.blocks[each.block]
        first = next(number for number, other in enumerate(simulation.blocks) if other.part == block.part)
        variables, unit = variables_of(block, each.block - first), "INCH/MIN" if block.inch else "MM/MIN"
        lines.append(f"#{variables.E}={each.words['E']} (E, {unit}, PART {block.part + 1}, BLOCK {each.block + 1})")
        if "D" in each.words:
            lines.append(f"#{variables.D}={each.words['D']} (D)")
    text = "\n".join([*lines, "M99" if called else "M30"]) + "\n"
    write_atomically(path, lambda partial: partial.write_text(text, encoding="ascii"))
