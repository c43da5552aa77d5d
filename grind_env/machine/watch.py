"""When a run warns: of each subject once in each block. The texts are in `advice.py`."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grind_env.control import (
    Arc,
    Control,
    CyclePlan,
    CycleStrokes,
    Infeed,
    Message,
    Motion,
    Pick,
    ProgramStop,
    Stroke,
)
from grind_env.control.rules import DEPTH_TOLERANCE, INSTANT, depth_after_pick, picks_to
from grind_env.machine import advice
from grind_env.machine.axes import AXES, cross_axis, plunge_axis
from grind_env.machine.dress_program import DressPlan
from grind_env.machine.job import Job
from grind_env.machine.limits import beyond_picks, beyond_table
from grind_env.machine.mounting import first_diameter
from grind_env.machine.obstacles import WATCHED, FeedPass, ground_by, judged_moves
from grind_env.machine.part import SLOWED, PartRun
from grind_env.machine.passes import Extremes
from grind_env.machine.record import Table
from grind_env.machine.running import Running, Told
from grind_env.machine.unjudged import Unjudged, lines_said
from grind_env.process import state
from grind_env.process.cost import STALL
from grind_env.process.equations import wheel_speed
from grind_env.process.state import WheelState

SHARE = 0.1
"""Of the plunge of a cycle: one that takes less off, no deeper than was ground before, grinds what that has left."""

OVERTRAVEL = 2.0
"""mm; by which a table has to go beyond the part at least: a cut of 0.01 mm is 1.7 mm long on a wheel of 300 mm."""

ANEW = 0.5
"""Of the depth ground before a cycle: one that plunges from above that share and finds nothing begins another part."""

SIZED = 0.001
"""mm; stock that nobody leaves on a part that is taken off, and by which depths are the same to one who gauges."""


def plunges_of(plan: CyclePlan) -> int:
    """The plunges that a cycle makes to its depth."""
    picks, reversal, depth = 0, 0, 0.0
    if not plan.primary_pick > 0.0:
        return 0
    while depth < plan.depth:
        reversal += 1
        deeper = depth_after_pick(reversal, depth, plan.depth, plan.primary_pick, plan.secondary_pick)
        picks, depth = picks + (deeper > depth), deeper
    return picks


@dataclass(slots=True)
class _Cycle:
    """What a cycle has come to.

    Attributes:
        plan: its parameters.
        before: depth to which the part has been ground before it, mm.
        stroke: its last one.
        longest: length of its longest stroke, mm.
        highest: depth of its highest stroke, mm.
        deepest: depth of its deepest stroke, mm.
        over: whether one has passed over the part.
        crossed: whether the wheel has gone across between strokes that came one by one.
        removed: depth ground off, mm.
    """

    plan: CyclePlan
    before: float
    stroke: Stroke | None = None
    longest: float = 0.0
    highest: float = math.inf
    deepest: float = -math.inf
    over: bool = False
    crossed: bool = False
    removed: float = 0.0

    @property
    def is_idle(self) -> bool:
        """Whether it has only set the table going above what there is to grind, as a G81 may do for a later cycle."""
        elsewhere = self.crossed and not self.over and self.deepest > DEPTH_TOLERANCE
        return not self.plan.plunges and self.in_air and self.highest == self.deepest and not elsewhere

    @property
    def in_air(self) -> bool:
        """Whether its strokes have found nothing to grind."""
        plunge = self.deepest - self.highest
        return self.removed <= (SHARE * plunge if self.deepest <= self.before + DEPTH_TOLERANCE else 0.0)

    @property
    def grinds_another(self) -> bool:
        """Whether it is a cycle in the air that may be meant for another part, which is not simulated.

        It lies beside the part, or plunges anew as if nothing had been ground. One that sparks out, or repeats what was
        the last of its depth, is none; nor is one that comes down on a part before it has been ground.
        """
        again = self.before > 0.0 and self.highest < self.deepest and self.highest <= ANEW * self.before
        return self.in_air and (again or not self.over)


@dataclass(frozen=True, slots=True)
class _Overload:
    """The worst stroke or infeed of a block for the spindle, which has slowed or stalled in it.

    Attributes:
        line: of the block.
        torque: over that at which the spindle stalls.
        subject: of the warning.
        text: of the warning.
    """

    line: int
    torque: float
    subject: str
    text: str


class Watch:
    """Observes a run and collects its warnings.

    Attributes:
        part: on the machine.
        warnings: sentences so far.
    """

    def __init__(self, program: str, job: Job, control: Control) -> None:
        self.program, self.job, self.control = program, job, control
        self.part: PartRun | None = None
        self.warnings: list[str] = []
        self._warned: set[tuple[str, str, int]] = set()
        self._pick: Pick | None = None
        self._stroke: Stroke | None = None
        self._cycle: _Cycle | None = None
        self._overload: _Overload | None = None  # not yet told
        self._in_air = False  # the last cycle
        self._judged = False  # a cycle that is not idle
        self._idle: tuple[int, str] | None = None  # the first idle cycle, by its line, and what to say of it
        self._moves: list[Motion] = []  # not yet judged
        self._found = False  # where the wheel stands before them
        self._axis: int | None = None  # along which the last cycle reciprocates
        self._told = Told()
        self._dressed = 0.0  # off the diameter of the wheel, mm
        self._eaten = False  # by them, as has been told
        self._pending: list[tuple[int, str, str]] = []  # of the part that M00 took off, unless M01 was meant
        self._taken_off: tuple[int, float, float] | None = None  # line of that M00, depth and stock left, mm
        self._muted = False  # until the part is off: what is wrong with it follows from what has been told
        self._passes: list[FeedPass] = []  # over the part
        self._others: dict[int, str] = {}  # cycles that may grind another part, by line, and what to say of each

    def warn(self, line: int, subject: str, text: str) -> None:
        """Warn once of each subject in each block; line 0 is the program as a whole."""
        self._warn(self.program, line, subject, text)

    def _warn(self, file: str, line: int, subject: str, text: str) -> None:
        if (subject, file, line) not in self._warned and not self._muted:
            self._warned.add((subject, file, line))
            self.warnings.append(f"{file}:{line}: {text}" if line else f"{file}: {text}")

    def message(self, event: Message) -> None:
        """Pass on what the control tells the operator."""
        self.warnings.append(f"{self.program}: the control says: {event.text}")

    def move(self, event: Motion) -> None:
        """The program moves the axes; whether it keeps clear shows with the cycle or the stroke that comes after."""
        if event.source in WATCHED and (event.start != event.end or isinstance(event, Arc)):  # a full circle
            self._moves.append(event)

    def start_cycle(self, plan: CyclePlan, deepest: float) -> None:
        """A cycle takes over: picks and strokes before it have no bearing on its own.

        Args:
            plan: its parameters.
            deepest: depth of the strokes before it, mm.
        """
        self._end_cycle()
        self._judge_stop(plan)
        self._axis = plan.axis
        self._judge_moves(plan.axis)
        self._pick = self._stroke = None
        self._cycle = _Cycle(plan, deepest)
        self._judge_plan(plan)

    def _judge_plan(self, plan: CyclePlan) -> None:
        """Warn of what the words of a cycle ask for in vain."""
        beyond = beyond_picks(plan, self.job.setup.machine)
        if beyond is not None:
            self.warn(plan.line, "feed", beyond)
        most = max(plan.primary_pick, plan.secondary_pick)
        if plan.dresses and most > 0.0 and plan.dresses > picks_to(plan.depth, most):
            plunges = plunges_of(plan)
            if plan.dresses > plunges:
                self.warn(plan.line, "dresses", advice.many_dresses(plan.dresses, plunges))

    def _judge_stop(self, plan: CyclePlan) -> None:
        """Whether the M00 before a cycle was meant to gauge the part, on which the cycle goes on."""
        if self._taken_off is not None and plan.plunge_axis is not None:
            assert self.part is not None
            line, depth, left = self._taken_off
            if self.part.job.part.surface - plan.plunge_start > depth - SIZED:
                self.warn(line, "stop", advice.taken_off(plan.line, depth, left))
                self._pending.clear()
                self._muted = True
        self._tell_pending()

    def _tell_pending(self) -> None:
        for line, subject, text in self._pending:
            self.warn(line, subject, text)
        self._pending.clear()
        self._taken_off = None

    def runs(self, line: int, running: Running, diameter: float) -> None:
        """The wheel, of a diameter, mm, is about to grind in the block of a line: how it turns, and the coolant."""
        for subject, text in self._told.of(running, diameter):
            self.warn(line, subject, text)

    def dress(self, line: int, plan: DressPlan, count: int) -> None:
        """So many dresses are made in the block of a line: whether these alone make the wheel too small."""
        least = self.job.setup.wheel.minimum_diameter
        for _ in range(count):
            self._dressed += 2.0 * plan.passes * plan.depth
            too_small = first_diameter(self.job) - self._dressed < least and self.job.times.wheel_change is None
            if too_small and not self._eaten:
                self._eaten = True
                self.warn(line, "diameter", advice.eaten_wheel(self._dressed, least))

    def dress_moves(self, file: str, moves: Sequence[Motion], axis: int) -> None:
        """A dress program of a file has been executed, with its way back."""
        self._judge_way(file, ((move, True) for move in moves), axis)

    def missed(self, file: str, line: int, text: str) -> None:
        """A dress program of a file has missed the diamond in a pass."""
        self._warn(file, line, "diamond", text)

    def pick(self, event: Pick) -> None:
        """A pick has been made."""
        if self._stroke is not None and self._stroke.begin > event.begin:  # a whole stroke went by
            self.warn(event.line, "pick", advice.slow_pick(event, self._stroke, self.control))
        self._pick = event

    def before_stroke(self, event: Stroke) -> None:
        """A stroke is about to be ground; moves while the table reciprocates are infeeds."""
        if self._moves:
            self._moves = [move for move in self._moves if move.finish <= event.begin + INSTANT]
            self._judge_moves(event.axis)

    def stroke(self, event: Stroke, made: Extremes, before: WheelState, after: WheelState) -> None:
        """A stroke has been made; what it has come to, and the wheel before and after it."""
        assert self.part is not None and self._cycle is not None
        pick = self._pick
        if pick is not None and pick.begin < event.begin:
            if pick.finish > advice.middle_time(event, self.control):
                self.warn(event.cycle.line, "pick", advice.slow_pick(pick, event, self.control))
            self._pick = None
        plan, length = event.cycle, abs(event.end[event.axis] - event.start[event.axis])
        self._judge_speed(plan, event.feed, length, event.inch)
        self._judge_stroke(event, made.deepest, made.removed, before.A, after.A, after.ds)
        self._count(event, made)

    def spindle(self, rows: Table) -> None:
        """Strokes or infeeds of a block have been made, dtype `record.STROKE_ROW`, in which the spindle perhaps slowed.

        The cycle, or the grooving, ends with a word about the worst of them.
        """
        assert self.part is not None
        worst, p = rows[int(rows["torque"].argmax())], self.part.p
        line, torque, limit = int(worst["line"]), float(worst["torque"]), 0.001 * p.power
        if torque <= SLOWED * p.rs:
            return
        if self._overload is not None and self._overload.line != line:
            self._tell_overload()
        if self._overload is not None and torque <= self._overload.torque:
            return
        number, groove = int(worst["number"]), int(worst["groove"]) > 0
        if torque >= STALL:
            text = advice.stalled_spindle(number, limit, p.stall_time, groove=groove)
            self._overload = _Overload(line, torque, "stall", text)
        else:
            speed = wheel_speed(float(worst["ds"]), p.n, p.vs_set)
            text = advice.slowed_spindle(number, float(worst["vs"]), speed, limit, groove=groove)
            self._overload = _Overload(line, torque, "spindle", text)

    def _tell_overload(self) -> None:
        overload, self._overload = self._overload, None
        if overload is not None:
            self.warn(overload.line, overload.subject, overload.text)

    def _judge_speed(self, plan: CyclePlan, feed: float, length: float, inch: bool) -> None:
        """Warn of a feed that the table does not make, in a stroke of that length, mm, or in a longer one before."""
        assert self._cycle is not None
        self._cycle.longest = longest = max(self._cycle.longest, length, abs(plan.primary - plan.secondary))
        beyond = beyond_table(feed, longest, self.control.acceleration, self.job.setup.machine, inch)
        if beyond is not None:
            self.warn(plan.line, "speed", beyond)

    def _count(self, last: Stroke, made: Extremes) -> None:
        """Count strokes of the cycle, up to its last one so far."""
        assert self._cycle is not None
        cycle, self._stroke = self._cycle, last
        if cycle.stroke is not None:
            cross = cross_axis(last.axis)
            cycle.crossed = cycle.crossed or cycle.stroke.middle[cross] != last.middle[cross]
        cycle.stroke = last
        cycle.highest, cycle.deepest = min(cycle.highest, made.highest), max(cycle.deepest, made.deepest)
        cycle.over, cycle.removed = cycle.over or made.ground > -math.inf, cycle.removed + made.removed

    def strokes(
        self,
        event: CycleStrokes,
        rows: Table,
        extremes: Extremes,
        before: WheelState,
        after: WheelState,
        dress: DressPlan,
        dressed: Table,
    ) -> None:
        """The strokes of a whole cycle have been made.

        Args:
            event: the cycle.
            rows: theirs, dtype `record.STROKE_ROW`.
            extremes: what they have come to.
            before: the wheel before the first one.
            after: the wheel after the last one.
            dress: what each dress between them does.
            dressed: what each has come to, shape (dresses, fields of `Dressed`); none where they miss the diamond.
        """
        assert self.part is not None and self._cycle is not None
        plan, least = event.plan, self.job.setup.wheel.minimum_diameter
        shallow = extremes.most <= advice.deepest_within(event.feed) and after.ds >= least
        alive = extremes.sharpest > 0.0 and extremes.dullest < self.part.p.Amax
        inside = self._turns_inside(plan.secondary) or self._turns_inside(plan.primary)
        self._judge_speed(plan, event.feed, abs(plan.primary - event.start[plan.axis]), event.inch)
        if inside or not (shallow and alive):
            made, A = 0, before.A
            for (upto, _), (dressed_A, ds, _) in zip(event.dresses, dressed.tolist(), strict=False):
                self._judge_strokes(event, made, rows[made:upto], A)
                self.dress(plan.line, dress, 1)
                self.diameter(ds)
                made, A = upto, dressed_A
            self._judge_strokes(event, made, rows[made:], A)
        else:
            self.dress(plan.line, dress, len(dressed))
        self._pick = None
        self._count(event.stroke(rows.size), extremes)

    def _judge_strokes(self, event: CycleStrokes, made: int, rows: Table, A: float) -> None:
        """Warn of strokes of a whole cycle after those that it has `made`; wear flats `A` before them."""
        Z, ae, ds, A_after = rows["Z"], rows["ae"], rows["ds"], rows["A"]
        A_before = np.append(A, A_after)[:-1]
        inside = self._turns_inside(event.plan.primary), self._turns_inside(event.plan.secondary)
        turns = np.array(inside)[(made + np.arange(rows.size)) % 2] & (Z > 0.0)
        least = self.job.setup.wheel.minimum_diameter
        found = turns, ae > advice.deepest_within(event.feed), ds < least, self._destroyed(A_before, A_after)
        for k in sorted({int(each.argmax()) for each in found if each.any()}):  # of each subject the first tells
            self._judge_stroke(event.stroke(made + k + 1), Z[k], ae[k], A_before[k], A_after[k], ds[k])

    def _judge_stroke(self, event: Stroke, Z: float, ae: float, A_before: float, A: float, ds: float) -> None:
        """Warn of a stroke at depth `Z` that took `ae` off, mm; wear flats before and after it, and diameter after."""
        assert self.part is not None
        part, line, turn = self.part.job.part, event.cycle.line, event.end[event.axis]
        if Z > 0.0 and self._turns_inside(turn):
            text = advice.short_stroke(turn, AXES[event.axis], part.start, part.start + part.length)
            self.warn(line, "turn", text)
        outside = advice.outside_model(event.feed, ae)
        if outside is not None:
            self.warn(line, "model", outside)
        self.diameter(ds)
        if self._destroyed(A_before, A):
            self.warn(line, "wheel", advice.destroying_stroke(ae, event.feed))

    def _turns_inside(self, turn: float) -> bool:
        """Whether a reversal point, mm, lies over the part, or too near its end."""
        assert self.part is not None
        part = self.part.job.part
        return part.start - OVERTRAVEL < turn < part.start + part.length + OVERTRAVEL

    def infeed(self, event: Infeed, cut: state.StrokeResult, before: WheelState, after: WheelState) -> None:
        """A grooving wheel has made an infeed; the wheel before and after it."""
        outside = advice.groove_outside_model(cut)
        if outside is not None:
            self.warn(event.line, "model", outside)
        self.diameter(after.ds)
        if self._destroyed(before.A, after.A):
            self.warn(event.line, "wheel", advice.destroying_infeed(cut.ae, event.feed))

    def _destroyed(self, before: Any, after: Any) -> Any:
        """Whether cuts have brought the wear flats of the wheel to a limit; `worn_flat_area` keeps them there."""
        assert self.part is not None
        limit = self.part.p.Amax
        return (before > 0.0) & (before < limit) & ((after <= 0.0) | (limit <= after))

    def diameter(self, diameter: float) -> None:
        """Warn if the wheel is below its least diameter, mm, unless the job changes worn wheels."""
        least = self.job.setup.wheel.minimum_diameter
        if diameter < least and self.job.times.wheel_change is None and not self._eaten:
            self.warn(0, "diameter", advice.worn_wheel(least))

    def stroked_on(self, stop: ProgramStop) -> None:
        """The table has gone on after an M00 that takes the part off; told unless M01 was meant."""
        self._pending.append((stop.line, "stop", advice.stroked_on()))

    def unload(self, stop: ProgramStop | None = None) -> None:
        """The part is taken off the machine, at a stop or at the end of the program."""
        assert self.part is not None
        cycle, part = self._cycle, self.part
        self._end_cycle()
        if cycle is not None:
            self._judge_moves(cycle.plan.axis)
            left = part.stock - max(part.deepest, 0.0)
            if part.deepest > 0.0 and part.strokes:
                if 0.0 < part.job.part.tolerance < 1000.0 * left:
                    self._pending.append((cycle.plan.line, "stock", advice.stock_left(part.deepest, part.stock)))
                if stop is not None and min(left, part.deepest) > SIZED and not self._muted:
                    self._taken_off = stop.line, part.deepest, left
        elif self._axis is not None and not part.infeeds:
            self._judge_moves(self._axis)
        if self._idle is not None and not self._judged:
            self.warn(self._idle[0], "air", self._idle[1])
        if len(part.passed) < len(part.job.part.stages):
            text = advice.unended_stages(len(part.job.part.stages), len(part.passed))
            self._pending.append((0, "stages", text))
        if part.missed:
            self.warn(0, "missed", advice.missed_surface(part.job.part.surface))
        self._leave_unjudged()
        self._moves.clear()
        self._found = self._in_air = self._judged = False
        self._idle = None
        if self._muted:
            self._pending.clear()
        self._muted = False

    def grind_next(self, part: PartRun) -> bool:
        """Whether the moves since the last part was taken off grind the next one, which has had no cycle."""
        if self._axis is None:
            return False
        moves = enumerate(self._moves)
        return any(ground_by(part, self.job, move, self._axis, k > 0) is not None for k, move in moves)

    def _leave_unjudged(self) -> None:
        """Tell what has ground the part and is not simulated, and why nobody can judge it."""
        assert self.part is not None
        found = []
        if self._passes:
            lines = sorted({each.line for each in self._passes})
            low, high = zip(*(each.depths for each in self._passes), strict=True)
            text = advice.unsimulated_passes(lines_said(lines), len(self._passes), (min(low), max(high)))
            self.warn(lines[0], "pass", text)
            found.append(Unjudged(tuple(lines), text))
        if self._others:
            lines = sorted(self._others)
            found.append(Unjudged(tuple(lines), self._others[lines[0]]))
        self.part.unjudged = tuple(found)
        self._passes, self._others = [], {}

    def end(self) -> None:
        """The program is over."""
        self._tell_pending()

    def _end_cycle(self) -> None:
        """Judge the cycle as a whole."""
        cycle, self._cycle = self._cycle, None
        self._tell_overload()
        if cycle is None or cycle.stroke is None:
            return
        if cycle.is_idle:
            self._idle = self._idle or (cycle.plan.line, self._air(cycle, cycle.stroke))
            return
        assert self.part is not None
        # of the first one in a row; above a part on which the spindle has stalled the wheel is not meant to grind
        if cycle.in_air and not self.part.stalled:
            text, line, told = self._air(cycle, cycle.stroke), cycle.plan.line, self._in_air
            if cycle.grinds_another:
                text, told = advice.unsimulated_cycle(text, (cycle.highest, cycle.deepest)), told and bool(self._others)
                self._others.setdefault(line, text)
            if not told:
                self.warn(line, "air", text)
        self._in_air, self._judged = cycle.in_air, True

    def _air(self, cycle: _Cycle, stroke: Stroke) -> str:
        assert self.part is not None
        part, axis = self.part.job.part, stroke.axis
        if cycle.over:
            plunge = AXES[plunge_axis(axis)]
            if cycle.deepest <= DEPTH_TOLERANCE:
                return advice.above_surface(plunge, part.surface - cycle.deepest, part.surface)
            return advice.ground_before(plunge, part.surface - cycle.deepest)
        ends = sorted((stroke.start[axis], stroke.end[axis]))
        far = part.start + part.length
        if ends[1] <= part.start or ends[0] >= far:
            return advice.beside_part(AXES[axis], (ends[0], ends[1]), (part.start, far))
        edge, cross = stroke.middle[cross_axis(axis)], AXES[cross_axis(axis)]
        width = self.job.setup.wheel.width
        return advice.beside_part(cross, (edge, edge + width), (part.across, part.across + part.width))

    def _judge_moves(self, axis: int) -> None:
        """Warn of moves into what stands in their way, unless the table has reciprocated beside them."""
        self._judge_way(self.program, self._outside(), axis)
        self._moves.clear()

    def _judge_way(self, file: str, moves: Iterable[tuple[Motion, bool]], axis: int) -> None:
        """Warn of moves, each with whether it is known where it begins."""
        assert self.part is not None
        for found in judged_moves(self.part, self.job, moves, axis):
            if isinstance(found, FeedPass):
                self._passes.append(found)
            else:
                self._warn(file, *found)

    def _outside(self) -> Iterator[tuple[Motion, bool]]:
        """The moves that no stroke has run beside, and whether it is known where each of them begins."""
        last = self._stroke
        for move in self._moves:
            if last is None or last.finish <= move.begin + INSTANT:
                yield move, self._found
            self._found = True
