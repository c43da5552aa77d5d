"""Warnings about moves outside the cycles: obstacles, and feeds that the machine cannot run.

Moves are judged with the cycle or the stroke that comes after them: only then it is known how the part lies.
"""

import math
from collections.abc import Iterable, Sequence

from grind_env.control import Arc, Line, Motion, Source
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE, INSTANT
from grind_env.machine.dress.dress_run import DEEPEST_INFEED
from grind_env.machine.dress.mounted_wheel import first_diameter
from grind_env.machine.dress.wheel_geometry import over_diamond
from grind_env.machine.job import Job
from grind_env.machine.part.part import PartRun
from grind_env.machine.part.unsimulated_cuts import Unjudged, list_lines
from grind_env.machine.warnings import texts
from grind_env.machine.warnings.clearance import CRASH, Depths, into_part, into_table, pass_depths
from grind_env.machine.warnings.texts import Notices, over_feed_limits

#: sources of the motions to watch: the program, and the operator's requests in between, which are only checked for
#: grinding the part
WATCHED = (Source.PROGRAM, Source.COMPENSATION, Source.INTERRUPT)


def shows_place(event: Motion) -> bool:
    """Return whether a motion leaves the wheel at a known place, as a full circle does."""
    return event.source in WATCHED and (event.start != event.end or isinstance(event, Arc))


class ObstacleWatch:
    """Watcher of moves into obstacles; it also collects feed moves that grind the part."""

    def __init__(self, job: Job, notices: Notices) -> None:
        self.job, self.notices = job, notices
        self.axis: int | None = None  # along which the last cycle reciprocates; None before the first one
        self.stroked_until = -math.inf  # time of the control at which the last stroke ended, s
        self.other_parts: Sequence[PartRun] = ()  # the parts at the other stations
        self._radius = 0.5 * first_diameter(job)  # of the wheel, mm
        self._moves: list[tuple[Motion, bool]] = []  # moves not yet judged, and whether the begin of each is known
        # feed moves that grind the part at a station, by line
        self._passes: dict[int, list[tuple[int, Depths]]] = {}

    def move(self, event: Motion, *, found: bool) -> None:
        if shows_place(event):
            self._moves.append((event, found))

    def judge(self, part: PartRun, axis: int, until: float = math.inf) -> None:
        """Judge moves that ended before `until`, s, and not beside strokes; then forget all moves."""
        self.axis = axis
        ended = [each for each in self._moves if each[0].finish <= until + INSTANT]
        self._moves = []
        self._judge(part, (each for each in ended if self.stroked_until <= each[0].begin + INSTANT), axis)

    def dress(self, part: PartRun, file: str, moves: Sequence[Motion], axis: int) -> None:
        self._judge(part, ((move, True) for move in moves), axis, file)

    def grinds(self, part: PartRun) -> bool:
        axis = self.axis
        return axis is not None and any(self._ground(part, move, axis, found) for move, found in self._moves)

    def unload(self) -> None:
        self._moves = []

    def unjudged(self, station: int) -> Sequence[Unjudged]:
        passes = self._passes.pop(station, [])
        if not passes:
            return []
        lines = sorted({line for line, _ in passes})
        low, high = zip(*(depths for _, depths in passes), strict=True)
        several = f"{len(passes)} feed moves outside a cycle take"
        moves = several if len(passes) > 1 else "a feed move outside a cycle takes"
        text = (
            f"{moves} the wheel over the part {texts.deep((min(low), max(high)))}, where it grinds "
            f"({list_lines(lines)}) and is no stroke of the program along the table, which is not simulated, so that "
            "the part is not judged; set the wheel to depth beside the part, and go straight along the table from there"
        )
        self.notices.tell(lines[0], "pass", text)
        return [Unjudged(tuple(lines), text)]

    def _judge(self, part: PartRun, moves: Iterable[tuple[Motion, bool]], axis: int, file: str | None = None) -> None:
        """Judge moves, each with whether its start is known.

        Only the first of successive collisions is reported, and for dress programs only the way out.
        """
        inside, dressed = False, 0.0
        for move, found in moves:
            grinds, below, text = False, -math.inf, ""
            for each in (part, *self.other_parts):
                depths = self._ground(each, move, axis, found)
                if depths is not None:
                    grinds = True
                    self._passes.setdefault(each.station, []).append((move.line, depths))
            if not grinds and move.source is not Source.INTERRUPT:
                below, text = self._obstacle(part, move, axis, dressed, found)
            if text and not inside:
                self.notices.tell(move.line, "crash", text, file)
            inside = grinds or bool(text) or (inside and move.source in (Source.DRESS, Source.RETRACE))
            if isinstance(move, Line) and move.source is not Source.INTERRUPT:
                dressed = max(dressed, below)
                self.notices.tell(move.line, "feed", over_feed_limits(move, axis, self.job.setup.machine), file)

    def _ground(self, part: PartRun, move: Motion, axis: int, found: bool) -> Depths | None:
        """Return the depths between which a move grinds the part, mm; None for rapids, and for moves of a dress."""
        if not isinstance(move, Line | Arc) or move.source not in WATCHED:
            return None
        return pass_depths(part, move, axis, self._radius, found=found)

    def _obstacle(self, part: PartRun, move: Motion, axis: int, dressed: float, found: bool) -> tuple[float, str]:
        """Return how far a move takes the wheel below the diamond tip, mm, and the warning about its obstacle.

        Earlier moves took it `dressed` mm below the tip.
        """
        diamond, below = self.job.diamond, -math.inf
        for each in (part, *self.other_parts):
            depth = into_part(each, move, axis, self._radius, found=found)
            if depth > CRASH + DEPTH_TOLERANCE:
                return below, texts.crash(depth, move, each.description)
        if found and (depth := into_table(part, move, axis)) > CRASH + DEPTH_TOLERANCE:
            into = f"{texts.named_move(move)} takes the wheel {depth:.3g} mm into the table"
            return below, f"{into}; end it higher, or mend part.height"
        if found and diamond is not None:
            below, _ = over_diamond(diamond.tip, move, axis, self._radius, self.job.setup.wheel.width)
            infeed = DEEPEST_INFEED if isinstance(move, Line) else CRASH
            if below > dressed + infeed + DEPTH_TOLERANCE:
                into = f"{texts.named_move(move)} takes the wheel {below - dressed:.3g} mm into the diamond"
                return below, f"{into}; lead it past the diamond, or above its tip"
        return below, ""
