"""Warnings about cycles that grind nothing, with their likely purpose.

Successive feed moves that are strokes count as one cycle, if none is less deep than the move before.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from grind_env.array_types import Array
from grind_env.control import CyclePlan, CycleStrokes
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.control.motion_paths import AXES
from grind_env.machine.axis_roles import cross_axis, plunge_axis
from grind_env.machine.part.feed_moves import FEED
from grind_env.machine.part.part import PartRun
from grind_env.machine.part.unsimulated_cuts import Unjudged
from grind_env.machine.warnings import texts
from grind_env.machine.warnings.texts import Notices

#: share of its plunge: a cycle that goes no deeper than before and removes less only grinds what was left
NO_REMOVAL_SHARE = 0.1

#: share of the depth ground before: a cycle in the air that plunges from above this share begins another part
RESTART_SHARE = 0.5


class Cycle(NamedTuple):
    """Result of a cycle; depths are mm."""

    plan: CyclePlan
    before: float  #: depth to which the part has been ground before it
    #: coordinates of the table at the ends of its last stroke, mm; None before the first one
    ends: tuple[float, float] | None = None
    edge: float = 0.0  #: cross coordinate of the wheel in its last stroke, mm
    longest: float = 0.0  #: length of its longest stroke, mm
    highest: float = math.inf  #: depth of its highest stroke
    deepest: float = -math.inf  #: depth of its deepest stroke
    over: bool = False  #: whether a stroke has passed over the part
    crossed: bool = False  #: whether the wheel has gone across between strokes that came one by one
    removed: float = 0.0  #: depth ground off

    def after(self, event: CycleStrokes, rows: Array) -> "Cycle":
        (begin, end), plan, edge = event.ends(0), self.plan, event.cross[-1]
        Z = rows["Z"].tolist()
        return self._replace(
            ends=event.ends(len(event.begins) - 1),
            edge=edge,
            longest=max(self.longest, abs(end - begin), abs(plan.primary - plan.secondary)),
            highest=min(self.highest, *Z),
            deepest=max(self.deepest, *Z),
            over=self.over or any(rows["Lw"].tolist()),
            crossed=self.crossed or (self.ends is not None and self.edge != edge),
            removed=self.removed + sum(rows["ae"].tolist()),
        )

    @property
    def is_idle(self) -> bool:
        """Return whether the cycle has only started the table above the part, as a G81 may do for a later cycle."""
        elsewhere = self.crossed and not self.over and self.deepest > DEPTH_TOLERANCE
        return not self.plan.plunges and self.in_air and self.highest == self.deepest and not elsewhere

    @property
    def in_air(self) -> bool:
        plunge = self.deepest - self.highest
        return self.removed <= (NO_REMOVAL_SHARE * plunge if self.deepest <= self.before + DEPTH_TOLERANCE else 0.0)

    @property
    def grinds_another(self) -> bool:
        """Return whether the cycle is in the air and may be meant for another part, which is not simulated.

        Such a cycle lies beside the part, or plunges again from the unground surface. It does not spark out, repeat its
        last depth, or come down on an unground part.
        """
        again = self.before > 0.0 and self.highest < self.deepest and self.highest <= RESTART_SHARE * self.before
        return self.in_air and (again or not self.over)


class Cycles:
    """Watcher of cycles in the air; `cycle` is the cycle in force, None on a part that has had no cycle."""

    def __init__(self, notices: Notices) -> None:
        self.notices = notices
        self.cycle: Cycle | None = None
        self._forget()

    def _forget(self) -> None:
        self._in_air = False  # whether the last cycle was in the air
        self._ground = False  # whether a cycle that is not idle has ended
        self._idle: tuple[int, str] | None = None  # the first idle cycle, by its line, and what to say of it
        self._others: dict[int, str] = {}  # cycles that may grind another part, by line, and what to say of each

    def continues(self, part: PartRun, plan: CyclePlan) -> bool:
        cycle, depth = self.cycle, part.job.part.surface - plan.plunge_start
        return cycle is not None and cycle.plan.code == plan.code == FEED and depth >= cycle.deepest - DEPTH_TOLERANCE

    def begin(self, part: PartRun, plan: CyclePlan) -> None:
        """Begin a cycle on a part, or a feed move that is a stroke; successive feed moves count as one cycle."""
        on = self.cycle if self.continues(part, plan) else None
        self.cycle = Cycle(plan, part.deepest) if on is None else on._replace(plan=plan)

    def count(self, event: CycleStrokes, rows: Array) -> float:
        assert self.cycle is not None
        self.cycle = self.cycle.after(event, rows)
        return self.cycle.longest

    def end(self, part: PartRun) -> None:
        cycle, self.cycle = self.cycle, None
        if cycle is None or cycle.ends is None:
            return
        line = cycle.plan.line
        if cycle.is_idle:
            self._idle = self._idle or (line, _air(cycle, cycle.ends, part))
            return
        # only the first in a row is reported; after a stall the wheel is not meant to grind
        if cycle.in_air and not part.stalled:
            text, told = _air(cycle, cycle.ends, part), self._in_air
            if cycle.grinds_another:
                text += (
                    f"; its strokes, {texts.deep((cycle.highest, cycle.deepest))}, may be those of another part, "
                    "which is not simulated, so that this one is not judged; give every part a program and a job of "
                    "its own, or say in [[stations]] of the job where it lies"
                )
                told = told and bool(self._others)
                self._others.setdefault(line, text)
            if not told:
                self.notices.tell(line, "air", text)
        self._in_air, self._ground = cycle.in_air, True

    def unload(self) -> Sequence[Unjudged]:
        if self._idle is not None and not self._ground:
            line, text = self._idle
            self.notices.tell(line, "air", text)
        lines = sorted(self._others)
        found = [Unjudged(tuple(lines), self._others[lines[0]])] if lines else []
        self._forget()
        return found


def _air(cycle: Cycle, ends: tuple[float, float], run: PartRun) -> str:
    part, axis, what = run.job.part, cycle.plan.axis, "this feed move" if cycle.plan.code == FEED else "this cycle"
    if cycle.over:
        plunge = AXES[plunge_axis(axis)]
        lowest = f"{plunge}{part.surface - cycle.deepest:g}"
        if cycle.deepest <= DEPTH_TOLERANCE:
            return (
                f"no stroke of {what} touches the part: the lowest is at {lowest}, the surface at "
                f"{plunge}{part.surface:g}; give a depth below it, or set part.surface to where the wheel touches"
            )
        return (
            f"{what} finds nothing to grind, for the part has been ground as deep as {lowest} before; "
            "go deeper, or put M00 before it if it is to grind the next part"
        )
    low, high = sorted(ends)
    far = part.start + part.length
    if high <= part.start or low >= far:
        return texts.beside_part(what, AXES[axis], (low, high), (part.start, far))
    swept = cycle.edge, cycle.edge + run.job.setup.wheel.width
    return texts.beside_part(what, AXES[cross_axis(axis)], swept, (part.across, part.across + part.width))
