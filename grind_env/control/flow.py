"""The way of execution through the blocks of programs, and the view ahead along it."""

import itertools
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from grind_env.control.reader import Program, SourceText

TEXT_END = "text end"
"""How a program ends whose text does, before an M02, M30 or M99."""


class BlockStream:
    """The blocks of one run through a program; those ahead can be looked at without being taken."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self._blocks = iter(program.blocks)
        self._ahead: deque[SourceText] = deque()

    def __iter__(self) -> Iterator[SourceText]:
        """Take the blocks one by one."""
        while self._ahead or self._draw():
            yield self._ahead.popleft()

    def ahead(self) -> Iterator[SourceText]:
        """Look at the blocks not yet taken, in order."""
        for index in itertools.count():
            if index >= len(self._ahead) and not self._draw():
                return
            yield self._ahead[index]

    def _draw(self) -> bool:
        source = next(self._blocks, None)
        if source is not None:
            self._ahead.append(source)
        return source is not None


@dataclass(slots=True)
class Call:
    """A program under execution.

    Attributes:
        stream: its blocks.
        repeats: how often it will be called again after this time (L of M98).
        interrupt: whether its M99 leads back into the middle of something: a dress or a program interrupt.
    """

    stream: BlockStream
    repeats: int = 0
    interrupt: bool = False
