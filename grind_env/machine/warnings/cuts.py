"""Warnings about picks, cuts and dresses, and about cuts outside the range of the process model."""

from typing import Any

import numpy as np

from grind_env.array_types import Array
from grind_env.control import Control, CycleStrokes, Infeed, Pick
from grind_env.control.motion_paths import AXES
from grind_env.machine.dress.dress_run import DressPlan
from grind_env.machine.dress.mounted_wheel import first_diameter
from grind_env.machine.job import Job
from grind_env.machine.part.compiled_strokes import Dressed
from grind_env.machine.part.feed_moves import speed_word
from grind_env.machine.part.part import SLOWED, PartRun
from grind_env.machine.warnings import texts
from grind_env.machine.warnings.texts import Notices
from grind_env.process.cost import STALL
from grind_env.process.equations import wheel_speed
from grind_env.process.stroke_types import StrokeParameters, StrokeResult, WheelState

TABLE_SPEEDS = (3000.0, 40_000.0)  #: least and highest table speed of the process model, mm/min

DEEPEST_CUT = 0.1  #: deepest cut of the process model, mm; deeper cuts are creep feed

#: least overtravel of the table beyond the part, mm: a cut of 0.01 mm is 1.7 mm long on a wheel of 300 mm
OVERTRAVEL = 2.0


class Cuts:
    """Watcher of single strokes, infeeds and dresses."""

    def __init__(self, job: Job, notices: Notices) -> None:
        self.job, self.notices = job, notices
        self.least, self.lasts = job.setup.wheel.minimum_diameter, job.times.wheel_change is None
        self._dressed = 0.0  # diameter lost by dresses, mm
        self._eaten = False  # whether a warning says that dresses use up the wheel

    def dress(self, line: int, plan: DressPlan) -> None:
        self._dressed += 2.0 * plan.passes * plan.depth
        if self.lasts and not self._eaten and first_diameter(self.job) - self._dressed < self.least:
            self._eaten = True
            text = (
                f"dressing alone takes {self._dressed:.4g} mm off the diameter of the wheel, which falls below its "
                f"least diameter, {self.least:g} mm; dress less often or less deep"
            )
            self.notices.tell(line, "diameter", text)

    def diameter(self, diameter: float) -> None:
        if self.lasts and not self._eaten and diameter < self.least:
            text = (
                f"the wheel is smaller than its least diameter, {self.least:g} mm; begin with a larger one, or give "
                "the time of a wheel change in [times] of the job"
            )
            self.notices.tell(0, "diameter", text)

    def strokes(
        self, part: PartRun, event: CycleStrokes, rows: Array, A: float, dress: DressPlan, dressed: Array
    ) -> None:
        ae, flats = rows["ae"].tolist(), rows["A"].tolist()
        shallow = max(ae) <= _deepest_within(event.feed) and rows["ds"][-1] >= self.least
        alive = min(flats) > 0.0 and max(flats) < part.p.Amax
        quiet = shallow and alive and not any(_turns_inside(part, turn) for turn in event.turns)
        made = 0
        for (upto, _), each in zip(event.dresses, map(Dressed._make, dressed.tolist()), strict=False):
            if not quiet:
                self._judge(part, event, made, rows[made:upto], A)
            self.dress(event.plan.line, dress)
            self.diameter(each.ds)
            made, A = upto, each.A
        if not quiet:
            self._judge(part, event, made, rows[made:], A)

    def _judge(self, part: PartRun, event: CycleStrokes, made: int, rows: Array, A: float) -> None:
        """Judge strokes after those that have been `made`; wear flats `A` before them."""
        Z, ae, ds, A_after = (rows[name] for name in ("Z", "ae", "ds", "A"))
        lying, line, word = part.job.part, event.plan.line, speed_word(event.plan)
        inside = [_turns_inside(part, turn) for turn in event.turns]
        turns = np.array(inside)[(made + np.arange(rows.size)) % 2] & (Z > 0.0)
        worn = _destroyed(part, np.append(A, A_after)[:-1], A_after)
        found = turns, ae > _deepest_within(event.feed), ds < self.least, worn
        for k in sorted({int(each.argmax()) for each in found if each.any()}):  # the first stroke of each subject
            if turns[k]:
                turn, axis = event.ends(made + k)[1], AXES[event.plan.axis]
                text = texts.short_stroke(turn, axis, lying.start, lying.start + lying.length)
                self.notices.tell(line, "turn", text)
            self.notices.tell(
                line, "model", _beyond_model("a stroke", ae[k], event.feed, f"cuts at {word}{event.feed:g} mm/min")
            )
            self.diameter(ds[k])
            if worn[k]:
                text = (
                    f"a stroke {ae[k]:.3g} mm deep at {word}{event.feed:g} mm/min destroys the wheel; usual are picks "
                    f"of 0.001 to 0.04 mm and {word}3000 to {word}30000"
                )
                self.notices.tell(line, "wheel", text)

    def infeed(self, part: PartRun, event: Infeed, cut: StrokeResult, before: WheelState, after: WheelState) -> None:
        speed = 60.0 * cut.Q / cut.ae if cut.ae > 0.0 else 0.0
        at = f"grinds the length of the part at {speed:.0f} mm/min, a turn per infeed"
        self.notices.tell(event.line, "model", _beyond_model("an infeed", cut.ae, speed, at))
        self.diameter(after.ds)
        if _destroyed(part, before.A, after.A):
            cause = f"an infeed {cut.ae:.3g} mm deep at F{event.feed:g} mm/min"
            self.notices.tell(event.line, "wheel", f"{cause} destroys the wheel; take smaller steps or a higher F")


def _deepest_within(speed: float) -> float:
    """Return the deepest cut at a table speed, mm/min, within the limits of validity of the process model, mm."""
    low, high = TABLE_SPEEDS
    return DEEPEST_CUT if low <= speed <= high else 0.0


def _beyond_model(cut: str, depth: float, speed: float, at: str) -> str | None:
    """Return the warning about a cut outside the model, made at the speed `at`; None if it is inside."""
    low, high = TABLE_SPEEDS
    if depth <= _deepest_within(speed):
        return None
    if not low <= speed <= high:
        return f"{cut} {at}; the process model holds from {low:g} to {high:g} mm/min"
    return f"{cut} cuts {depth:.2f} mm deep; the process model holds up to {DEEPEST_CUT:g} mm"


def _turns_inside(run: PartRun, turn: float) -> bool:
    part = run.job.part
    return part.start - OVERTRAVEL < turn < part.start + part.length + OVERTRAVEL


def _destroyed(part: PartRun, before: Any, after: Any) -> Any:
    """Return whether cuts have brought the wear flats of the wheel to a limit; `worn_flat_area` holds them there."""
    limit = part.p.Amax
    return (before > 0.0) & (before < limit) & ((after <= 0.0) | (limit <= after))


class Overload:
    """Watcher of the spindle: warns of its worst stroke or infeed when the cycle or grooving ends; `word` is E or F."""

    def __init__(self, notices: Notices) -> None:
        self.notices, self.word = notices, "E"
        self._line, self._torque = 0, 0.0  # of the worst stroke; 0 without one
        self._said = "", ""

    def add(self, rows: Array, p: StrokeParameters) -> None:
        worst = rows[int(rows["torque"].argmax())]
        line, torque, limit = int(worst["line"]), float(worst["torque"]), 0.001 * p.power
        if torque <= SLOWED * p.rs:
            return
        if line != self._line:
            self.end()
        if torque <= self._torque:
            return
        number = int(worst["number"])
        if worst["groove"] > 0:
            made, remedy = "in an infeed", "take smaller steps or a lower F"
        else:
            made = f"in stroke {number}" if number else "in a stroke"
            remedy = "lower J or E" if self.word == "E" else f"go less deep or lower {self.word}"
        if torque >= STALL:
            subject = "stall"
            told = (
                f"stalls, which has {limit:.1f} kW: the wheel retracts, the part is scrap, {p.stall_time:g} s are lost"
            )
        else:
            usual = wheel_speed(float(worst["ds"]), p.n, p.vs_set)
            subject, told = "spindle", f"slows to {worst['vs']:.1f} of {usual:.1f} m/s at its {limit:.1f} kW"
        self._line, self._torque = line, torque
        self._said = subject, f"{made} the spindle {told}; {remedy}, or dress before"

    def end(self) -> None:
        if self._torque > 0.0:
            self.notices.tell(self._line, *self._said)
        self._torque = 0.0


class Picks:
    """Watcher of picks that are unfinished when the wheel is over the middle of the part; whole cycles have none."""

    def __init__(self, control: Control, notices: Notices) -> None:
        self.control, self.notices = control, notices
        self._pick: Pick | None = None
        self._last: CycleStrokes | None = None

    def pick(self, event: Pick) -> None:
        if self._last is not None and self._last.begins[0] > event.begin:  # a whole stroke went by
            self.notices.tell(event.line, "pick", texts.slow_pick(event, self._last, self.control))
        self._pick = event

    def strokes(self, event: CycleStrokes) -> None:
        pick, self._last = self._pick, event
        if pick is not None and pick.begin < event.begins[0]:
            middle = event.begins[0] + 0.5 * (event.seconds[0] - self.control.reversal_dwell)
            if pick.finish > middle:
                self.notices.tell(event.plan.line, "pick", texts.slow_pick(pick, event, self.control))
            self._pick = None
