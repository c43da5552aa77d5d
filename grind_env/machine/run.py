"""The machine under a part program, one event of the control at a time.

This module decides and computes nothing that the control or the process model knows: it only brings their events and
relations together, and keeps the clock of the job.
"""

import math
from collections.abc import Sequence

import numpy as np

from grind_env.control import (
    Arc,
    Control,
    CycleStart,
    DressEnd,
    DressStart,
    Event,
    Infeed,
    Line,
    Message,
    Motion,
    Pick,
    ProgramEnd,
    Programs,
    ProgramStop,
    Rapid,
    Stroke,
)
from grind_env.errors import GrindError
from grind_env.machine.advice import BEYOND_NUMBERS, called_dress
from grind_env.machine.axes import cross_axis, plunge_axis
from grind_env.machine.compiled import dress_wheel
from grind_env.machine.dress_program import (
    DressPlan,
    is_dress_program,
    measure_dress,
    plain_calls,
    plan_dress,
    require_same,
)
from grind_env.machine.grooving import infeed_depth
from grind_env.machine.job import Job, JobError
from grind_env.machine.mounting import first_wheel, is_worn_out, new_wheel
from grind_env.machine.part import PartConditions, PartRun, Pass
from grind_env.machine.record import DRESS_ROW, PART_ROW, STROKE_ROW, WHEEL_FIELDS, GrindingRecord
from grind_env.machine.watch import Watch
from grind_env.process.state import WheelState


class GrindingError(GrindError):
    """A program that grinds nothing, or on a job whose numbers are beyond those of the process model."""


class GrindingRun:
    """State of a run; feed `take` every event of the execution.

    Attributes:
        wheel: as it is now; None before the first cycle, which mounts it.
        wheel_changes: how often a new one has been put in its place.
        part: on the machine.
        unloaded_at: time of the job at which the part was taken off, s; None while it is worked on.
        plans: what the dress programs met so far do, by O number.
        strokes: rows of the record so far (`record.STROKE_ROW`), like the next two.
        dresses: `record.DRESS_ROW`.
        parts: `record.PART_ROW`; a part has its row once it is taken off.
        stages: as of the record, a row with each of `parts`.
    """

    def __init__(self, programs: Programs, job: Job, control: Control, conditions: Sequence[PartConditions]) -> None:
        self.programs, self.job, self.control, self.conditions = programs, job, control, conditions
        self.position, self.axis = control.start, 0
        self.delay = 0.0  # of the job's clock after the control's: loading, set-up of dresses
        self.wheel: WheelState | None = None
        self.wheel_changes = 0
        self.plan: DressPlan | None = None  # of the cycle in force or before
        self.plans: dict[int, DressPlan] = {}
        self.checked: set[int] = set()
        self.dress_began = 0.0
        self.dress_motions: list[Motion] | None = None
        self.watch = Watch(programs.name, job, control)
        self.strokes: list[tuple[object, ...]] = []
        self.dresses: list[tuple[object, ...]] = []
        self.parts: list[tuple[object, ...]] = []
        self.stages: list[tuple[tuple[str, ...], ...]] = []
        self.part = self._load(0.0)
        self.unloaded_at: float | None = None

    @property
    def wheel_radius(self) -> float:
        """Of the wheel as it is now, before the first cycle as the job mounts it, mm."""
        start = self.job.setup.wheel.diameter if self.job.wheel.diameter is None else self.job.wheel.diameter
        return 0.5 * (start if self.wheel is None else self.wheel.ds)

    def record(self) -> GrindingRecord:
        """The record of all events taken."""
        return GrindingRecord(
            np.array(self.strokes, STROKE_ROW),
            np.array(self.dresses, DRESS_ROW),
            np.array(self.parts, PART_ROW),
            tuple(self.stages),
            tuple(self.watch.warnings),
        )

    def take(self, event: Event) -> None:
        """Let an event of the control happen."""
        match event:
            case CycleStart():
                self._start_cycle(event)
            case DressStart():
                self.dress_began, self.dress_motions = event.time, []
            case DressEnd():
                self._dress(event)
            case Stroke():
                self._stroke(event)
            case Infeed():
                self._infeed(event)
            case Pick():
                self.watch.pick(event)
            case ProgramStop():
                self._stop(event)
            case ProgramEnd():
                self._end(event)
            case Message():
                self.watch.message(event)
            case Rapid() | Line() | Arc():
                self.watch.move(event)
            case _:
                pass
        if isinstance(event, Motion):
            self.position = event.end
            if self.dress_motions is not None:
                self.dress_motions.append(event)

    # ------------------------------------------------------------------------------------- parts and clock

    def clock(self, time: float) -> float:
        """The time of the job at a time of the control, s; it adds what the program does not state, such as loading."""
        return time + self.delay

    def _load(self, began: float) -> PartRun:
        """Put the next part on the machine and touch the wheel off on it."""
        number = len(self.parts) + 1
        conditions = PartConditions()
        if self.conditions:
            if number > len(self.conditions):
                raise JobError(
                    f"{self.programs.name} grinds more parts than the {len(self.conditions)} that have "
                    "conditions; give conditions for every part or for none"
                )
            conditions = self.conditions[number - 1]
        self._gauge()
        part = PartRun(number, self.job, conditions, began, new_wheel=self.wheel_changes > 0)
        self.watch.part = part
        return part

    def _begin_cutting(self, time: float) -> None:
        """End the loading of the part; what is not cut after an M00 is no part."""
        if self.unloaded_at is not None:
            self.part, self.unloaded_at = self._load(self.unloaded_at), None
        if not self.part.cutting:
            self.part.cutting = True
            self.delay += max(self.part.began + self.job.times.load - self.clock(time), 0.0)

    def _stop(self, event: ProgramStop) -> None:
        if self.dress_motions is not None:  # the operator looks after the dresser and not after the part
            return
        if event.code == "M00" and self.part.cutting:
            self._unload(event.time)
        elif event.code == "M01":
            self.part.end_stage()
            self._change_worn_wheel()
            self._gauge()

    def _end(self, event: ProgramEnd) -> None:
        if not self.strokes:
            raise GrindingError(
                f"{self.programs.name} makes no stroke and no groove; G81, G82 or G83 sets the table going, "
                "G76 or G77 cuts grooves"
            )
        self._unload(event.time)
        for line, number in plain_calls(self.programs, block_delete=self.control.block_delete):
            if number in self.plans or is_dress_program(
                self.programs, number, self.job, self.control, self.position, self.axis
            ):
                self.watch.warn(line, "call", called_dress(number))

    def _unload(self, time: float) -> None:
        """Take the part off the machine, unless that has been done."""
        if self.unloaded_at is None:
            self._change_worn_wheel()
            self.unloaded_at = self.clock(time)
            self.watch.unload()
            self.parts.append(self.part.row(self.unloaded_at - self.part.began))
            self.stages.append(tuple(self.part.passed))

    # --------------------------------------------------------------------------------------- wheel and dress

    def _start_cycle(self, event: CycleStart) -> None:
        plan = event.plan
        if plan.program is not None and plan.program not in self.plans:
            self.plans[plan.program] = plan_dress(
                self.programs, plan.program, self.job, self.control, self.position, plan.axis
            )
        self._begin_cutting(event.time)
        self.watch.start_cycle(plan, self.part.deepest)
        if plan.program is not None:
            self.plan = self.plans[plan.program]
        if self.wheel is None:
            self.wheel = first_wheel(self.job, self.plan, self.part.p)
        if plan.plunge_axis is not None:
            self.part.deepest = max(self.part.deepest, self.part.job.part.surface - plan.depth_target)
        self.axis = plan.axis

    def _change_worn_wheel(self) -> None:
        if self.wheel is not None and is_worn_out(self.job, self.wheel):
            self.wheel = new_wheel(self.job, self.wheel, self.plan, self.part.p)
            self.wheel_changes += 1
            self.part.change_wheel()
            self.delay += self.job.times.wheel_change or 0.0

    def _gauge(self) -> None:
        """The operator measures the part: the wheel wear becomes known and is compensated."""
        if self.wheel is not None:
            self.wheel = self.wheel._replace(W=0.0)

    def _dress(self, event: DressEnd) -> None:
        plan, wheel = self.plans[event.program], self._wheel()
        self._compare(plan, event.program)
        time = self.clock(self.dress_began)
        self.wheel, removed = dress_wheel(wheel, float(plan.passes), plan.feed, plan.depth, self.part.p)
        self.part.dress(removed)
        self.delay += plan.seconds - (event.time - self.dress_began)
        self.dresses.append(
            (
                self.part.number,
                len(self.strokes),
                time,
                event.cause,
                event.program,
                plan.seconds,
                self.wheel.ds,
                removed,
            )
        )
        self.watch.diameter(self.wheel.ds)

    def _compare(self, plan: DressPlan, program: int) -> None:
        """Compare the first execution of a dress program with its plan."""
        motions, self.dress_motions = self.dress_motions or [], None
        if program in self.checked:
            return
        self.checked.add(program)
        require_same(measure_dress(motions, program, self.job, self.axis), plan, program)

    def _wheel(self) -> WheelState:
        assert self.wheel is not None  # a cycle has mounted it
        return self.wheel

    # ----------------------------------------------------------------------------------------------- strokes

    def _stroke(self, event: Stroke) -> None:
        self._begin_cutting(event.begin)
        part, axis = self.part, event.axis
        Z = part.job.part.surface - event.middle[plunge_axis(axis)]
        ends = event.start[axis], event.end[axis]
        edge = event.middle[cross_axis(axis)]
        before = self._wheel()
        self.watch.before_stroke(event)
        wheel, done = part.grind(before, Z, event.feed / 60.0, ends, edge)
        self.wheel = wheel
        self._write(event, event.cycle.line, event.number or 0, 0, event.feed, Z, done, wheel)
        self.watch.stroke(event, Z, done, before, wheel)

    def _infeed(self, event: Infeed) -> None:
        """A groove infeed; it wears the wheel only if the job grooves with the wheel."""
        self._begin_cutting(event.begin)
        before = first_wheel(self.job, None, self.part.p) if self.wheel is None else self.wheel
        wheel, done = self.part.infeed(before, event)
        Z = infeed_depth(event, self.part.job.part.surface)
        self._write(event, event.line, 0, event.groove, event.feed, Z, done, wheel)
        if self.job.setup.grooving_wheel:
            self.wheel = wheel
            self.watch.infeed(event, done.stroke, before, wheel)

    def _write(
        self, event: Motion, line: int, number: int, groove: int, feed: float, Z: float, done: Pass, wheel: WheelState
    ) -> None:
        """Add the row of a stroke or an infeed (`record.STROKE_ROW`), if it has one: no factor of a job is 1e300."""
        if not math.isfinite(sum(wheel) + sum(done.stroke)):
            raise GrindingError(f"{self.programs.name}:{line}: {BEYOND_NUMBERS}")
        self.strokes.append(
            (
                self.part.number,
                line,
                number,
                groove,
                self.clock(event.begin),
                event.seconds,
                feed,
                Z,
                done.b,
                done.Lw,
                *done.stroke,
                *(getattr(wheel, name) for name in WHEEL_FIELDS),
            )
        )
