"""The way of the wheel outside the cycles, judged with what comes after it: only a cycle shows how the part lies."""

import math
from collections.abc import Iterable, Iterator, Sequence

from grind_env.control import Arc, Motion
from grind_env.control.rules import INSTANT
from grind_env.machine import advice
from grind_env.machine.job import Job
from grind_env.machine.obstacles import WATCHED, FeedPass, ground_by, judged_moves
from grind_env.machine.part import PartRun
from grind_env.machine.unjudged import Unjudged, lines_said
from grind_env.machine.watch.notices import Notices


class Way:
    """Tells of moves into what stands in their way, and keeps those that grind the part.

    Attributes:
        axis: along which the last cycle reciprocates; None before the first one.
        stroked_until: time of the control at which the last stroke ended, s.
    """

    def __init__(self, job: Job, notices: Notices) -> None:
        self.job, self.notices = job, notices
        self.axis: int | None = None
        self.stroked_until = -math.inf
        self._moves: list[Motion] = []  # not yet judged
        self._found = False  # where the wheel stands before them
        self._passes: list[FeedPass] = []  # over the part

    def move(self, event: Motion) -> None:
        """The program moves the axes."""
        if event.source in WATCHED and (event.start != event.end or isinstance(event, Arc)):  # a full circle
            self._moves.append(event)

    def judge(self, part: PartRun, axis: int, until: float = math.inf) -> None:
        """Judge moves that have ended by a time, s, but those beside strokes, and forget the others."""
        self.axis = axis
        self._moves = [move for move in self._moves if move.finish <= until + INSTANT]
        self._tell(part, self._outside(), axis)
        self._moves = []

    def dress(self, part: PartRun, file: str, moves: Sequence[Motion], axis: int) -> None:
        """A dress program of a file has been executed, with its way back."""
        self._tell(part, ((move, True) for move in moves), axis, file)

    def grinds(self, part: PartRun) -> bool:
        """Whether the moves since the last part was taken off grind this one, which has had no cycle."""
        if self.axis is None:
            return False
        moves = enumerate(self._moves)
        return any(ground_by(part, self.job, move, self.axis, k > 0) is not None for k, move in moves)

    def unload(self) -> Sequence[Unjudged]:
        """The part is taken off; the moves that have ground it, which is told."""
        passes, self._passes, self._moves, self._found = self._passes, [], [], False
        if not passes:
            return []
        lines = sorted({each.line for each in passes})
        low, high = zip(*(each.depths for each in passes), strict=True)
        text = advice.unsimulated_passes(lines_said(lines), len(passes), (min(low), max(high)))
        self.notices.tell(lines[0], "pass", text)
        return [Unjudged(tuple(lines), text)]

    def _outside(self) -> Iterator[tuple[Motion, bool]]:
        """The moves that no stroke has run beside, and whether it is known where each of them begins."""
        for move in self._moves:
            if self.stroked_until <= move.begin + INSTANT:
                yield move, self._found
            self._found = True

    def _tell(self, part: PartRun, moves: Iterable[tuple[Motion, bool]], axis: int, file: str | None = None) -> None:
        for found in judged_moves(part, self.job, moves, axis):
            if isinstance(found, FeedPass):
                self._passes.append(found)
            else:
                self.notices.tell(*found, file)
