"""Write a dress interval into a program: a counter of parts or blocks, and D words that read it.

A counter is a # variable above 499, which the control keeps from one run of a program to the next. It counts on from
any value that another program has left in it; then at most the first interval differs.
"""

import re
from collections.abc import Collection, Sequence
from decimal import Decimal
from typing import NamedTuple

from grind_env.control import Programs
from grind_env.control.program_scanner import SourceText
from grind_env.errors import GrindError
from grind_env.shop.dress_interval import DressInterval
from grind_env.shop.optimise.word_editing import COMMENT, Edit, ProgramText

KEPT = range(500, 1000)  #: variables that the control keeps from run to run

_NUMBER = re.compile(r"#[ \t\[]*(\d+)")
_LINE_END = re.compile(r"\r\n|\r|\n")


class Counting(NamedTuple):
    """Text of a dress interval in a program."""

    interval: DressInterval  #: dress interval to count
    due: int  #: number of the variable that is 1 where a dress is due, else 0
    counter: int  #: number of the counting variable
    before: tuple[SourceText, ...]  #: blocks before which the counting lines are written

    def word(self, executions: Decimal) -> str:
        """Return the text behind the letter of a D word."""
        return f"#{self.due}" if executions == 1 else f"[{executions:f}*#{self.due}]"

    def edits(self, text: ProgramText) -> list[Edit]:
        """Return the edits that write the counting lines before each of the blocks."""
        every, due, count = self.interval.every, f"#{self.due}", f"#{self.counter}"
        lines = (
            f"(DRESS {self.interval}: {count} COUNTS, {due} IS 1 WHERE IT IS DUE)".upper(),
            f"IF [{count} EQ #0] THEN {count}=0",
            f"{count}={count}+1",
            f"{due}=0",
            f"IF [{count} GE {every}] THEN {due}=1",
            f"IF [{count} GE {every}] THEN {count}=0",
        )
        found = _LINE_END.search(text.text)
        end = found[0] if found else "\n"
        written = "".join(f"{line}{end}" for line in lines)
        return [Edit(source.line, source.column, 0, written) for source in self.before]


def counting_of(
    interval: DressInterval, programs: Programs, blocks: Sequence[SourceText], taken: Collection[int] = ()
) -> Counting | None:
    """Return the text of a dress interval in dressing `blocks`; None if every run dresses."""
    if interval.every == 1:
        return None
    used = {int(number) for program in programs for block in program.blocks for number in _NUMBER.findall(block.text)}
    free = [number for number in KEPT if number not in used and number not in taken][:2]
    if len(free) < 2:
        raise GrindError(f"{programs.name} uses all variables of #500 to #999, and none is left to count dresses by")
    if interval.of != "block":  # runs are counted before the first block that is not empty
        blocks = [next(block for block in programs.main.blocks if COMMENT.sub("", block.text).strip())]
    return Counting(interval, free[1], free[0], tuple(dict.fromkeys(blocks)))
