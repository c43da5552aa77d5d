"""Grinding that is not simulated: feed moves over the part that are no strokes, and strokes in the air.

Strokes in the air may be meant for another part.

A part with such grinding is not judged: its true result is unknown, and it never counts as good.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from grind_env.errors import GrindError

MOST_RUNS = 4  #: largest number of ranges of lines in a message; otherwise only the first and the last line are named


class UnjudgedError(GrindError):
    """A program that grinds what is not simulated, so that nothing can be said of its parts."""


class Unjudged(NamedTuple):
    """Why a part is not judged."""

    lines: tuple[int, ...]  #: lines of the program, ascending
    why: str  #: what these lines do, and the remedy


def runs(numbers: Sequence[int]) -> str:
    """Return ascending numbers as text; three or more successive numbers become a range."""
    rows: list[list[int]] = []
    for number in numbers:
        if rows and number == rows[-1][-1] + 1:
            rows[-1].append(number)
        else:
            rows.append([number])
    return ", ".join(f"{row[0]} to {row[-1]}" if len(row) > 2 else ", ".join(map(str, row)) for row in rows)


def list_lines(lines: Iterable[int]) -> str:
    """Return lines as text, such as `lines 3, 7 to 12`."""
    numbers = sorted(set(lines))
    if len(numbers) == 1:
        return f"line {numbers[0]}"
    text = runs(numbers)
    return f"lines {text if text.count(',') < MOST_RUNS else f'{numbers[0]} to {numbers[-1]}'}"
