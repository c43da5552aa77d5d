"""Control events as work of the machine: blocks of strokes, dresses, stops, removed parts."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, ClassVar

from grind_env.control import Control, CyclePlan, CycleStrokes, Programs, events
from grind_env.control.cycle_formulas import INSTANT
from grind_env.machine.dress.dress_programs import DressPrograms
from grind_env.machine.dress.dress_run import DressRun
from grind_env.machine.dress.mounted_wheel import first_diameter
from grind_env.machine.job import Job
from grind_env.machine.part.feed_moves import feed_stroke, table_axis
from grind_env.machine.part.parts_under_stroke import as_cycle_strokes, cycle_stations, sweep_of, sweep_of_plan
from grind_env.machine.part.spindle_coolant import Running
from grind_env.machine.warnings.moves import shows_place


class EventConsumer(ABC):
    """Consumer of control events of a program on the machine.

    `GrindingRun` grinds the results; the writer of a script writes them down.
    """

    def __init__(self, programs: Programs, job: Job, control: Control) -> None:
        self.programs, self.job, self.control = programs, job, control
        self.running, self.station_numbers = Running(job), range(len(job.stations))
        self.dressing = DressPrograms(programs, job, control)
        self.dressing_speed = self.running.speed  # wheel speed at the start of the last dress
        self.position = control.start
        self.axis, self.begun = 0, 0  # table axis of the last block of strokes; number of such blocks, with feed moves
        self.plan: CyclePlan | None = None  # of the last block of strokes; None before the first one
        self.has_ground = False  # whether a block or a groove has begun
        self.found = False  # whether the program has moved the wheel since an operator left it
        self.pending_stop: events.ProgramStop | None = None  # M00 that removes the part when the table stands
        self.stroked_until = self._moved_at = 0.0  # time of the control at which the last stroke or motion ended, s
        self.unloaded_at: float | None = None  # time of the job at which the part was removed, s; None during work

    def take(self, event: events.Event) -> None:
        happen = self.HAPPENINGS.get(type(event))
        if happen is not None:
            happen(self, event)
        if isinstance(event, events.Motion):
            self.position = event.end
            self.dressing.follow(event)

    def take_pending_part_off(self) -> None:
        """Take off the part of an earlier M00 with a moving table; the table now stands or a cycle takes it over."""
        stop, self.pending_stop = self.pending_stop, None
        if stop is not None:
            self.unload(self.stroked_until if self.stroked_until > stop.time + INSTANT else stop.time, stop)

    def unload(self, time: float, stop: events.ProgramStop | None = None) -> None:
        """Take the part off, unless it is off; the wheel stays `found` only if the program moved it after an M00."""
        if self.unloaded_at is None:
            self.unloaded_at = self.take_off(time, stop)
            self.found = stop is not None and self._moved_at > stop.time - INSTANT

    def _stop(self, event: events.ProgramStop) -> None:
        """Take the part off at M00, gauge the part at M01; a stop within a dress is only for the dresser.

        No part is taken from a reciprocating table: the part stays until the table stands or the next cycle begins.
        """
        if self.dressing.under_way is None:
            if not event.reciprocating:
                self.take_pending_part_off()
            if self.pending_stop is None and self.has_ground:
                if event.code == "M01":
                    self.gauge(event)
                elif event.reciprocating:
                    self.pending_stop = event
                else:
                    self.unload(event.time, event)

    def _start_cycle(self, event: events.CycleStart) -> None:
        plan, dress = event.plan, None
        if plan.program is not None:
            dress = self.dressing.run(plan.program, self.position, event)
        self._begin(event.time, plan, cycle_stations(self.job, sweep_of_plan(plan, self.position)), dress)

    def _begin(self, time: float, plan: CyclePlan, stations: Sequence[int], dress: DressRun | None) -> None:
        self.take_pending_part_off()
        self.has_ground, self.begun, self.plan, self.axis = True, self.begun + 1, plan, plan.axis
        self.begin_block(time, plan, stations, dress)

    def _move(self, move: events.Motion) -> None:
        event = self._stroke_of(move) if isinstance(move, events.Line) else None
        if event is None:
            self.move(move)
        else:
            self.position = event.start
            self._begin(move.begin, event.plan, cycle_stations(self.job, sweep_of(event)), None)
            self._stroke(event, 0)
        if shows_place(move):
            self.found, self._moved_at = True, move.begin

    def _stroke_of(self, move: events.Line) -> CycleStrokes | None:
        axis, jobs = self.along
        strokes = (feed_stroke(move, axis, job, self.plan) for job in jobs)
        return next((each for each in strokes if each is not None), None)

    def _stroke(self, event: CycleStrokes, number: int) -> None:
        self.stroked_until = event.time
        self.make_strokes(event, number)
        self.position = event.end

    @property
    def line(self) -> int:
        """Return the line of the current or last block of strokes; 0 before the first."""
        return 0 if self.plan is None else self.plan.line

    @property
    def along(self) -> tuple[int, Sequence[Job]]:
        """Return the axis along which feed moves may be strokes, and the jobs of the parts below such moves."""
        axis = self.axis if self.begun else self._first_axis
        if not self.found or axis is None:
            return self.axis, ()
        return axis, [self.job.at_station(k, axis) for k in self.station_numbers] or self.coming_jobs()

    @cached_property
    def _first_axis(self) -> int | None:
        return table_axis(self.programs, self.control, 0.5 * first_diameter(self.job))

    @abstractmethod
    def begin_block(self, time: float, plan: CyclePlan, stations: Sequence[int], dress: DressRun | None) -> None:
        """Begin a block of strokes over these stations; a feed move has no dress of its own."""

    @abstractmethod
    def make_strokes(self, event: CycleStrokes, number: int) -> None:
        """Make strokes; `number` is the number of the first stroke within its cycle, or 0."""

    @abstractmethod
    def move(self, event: events.Motion) -> None:
        """Move the wheel, or dwell, without a stroke."""

    @abstractmethod
    def gauge(self, event: events.ProgramStop) -> None:
        """Gauge the part."""

    @abstractmethod
    def take_off(self, time: float, stop: events.ProgramStop | None) -> float:
        """Take the part off; return the time of the job, s."""

    @abstractmethod
    def coming_jobs(self) -> Sequence[Job]:
        """Return the job of the part that a feed move may grind; empty if the move grinds nothing."""

    def start_dress(self, event: events.DressStart) -> None:
        self.dressing.begin(event)
        self.dressing_speed = self.running.speed

    @abstractmethod
    def end_dress(self, event: events.DressEnd) -> None: ...

    @abstractmethod
    def end(self, event: events.ProgramEnd) -> None: ...

    #: handler for each type of event; other events only move the axes
    HAPPENINGS: ClassVar[Mapping[type[Any], Callable[[Any, Any], None]]] = {
        events.CycleStart: _start_cycle,
        events.Stroke: lambda self, event: self._stroke(as_cycle_strokes(event), event.number or 0),
        CycleStrokes: lambda self, event: self._stroke(event, 1),
        **dict.fromkeys((events.Rapid, events.Line, events.Arc, events.Dwell), _move),
        events.DressStart: lambda self, event: self.start_dress(event),
        events.DressEnd: lambda self, event: self.end_dress(event),
        events.Spindle: lambda self, event: self.running.set_speed(event),
        events.Switch: lambda self, event: self.running.switch(event),
        events.ProgramStop: _stop,
        events.ProgramEnd: lambda self, event: self.end(event),
    }
