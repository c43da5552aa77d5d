"""Interruptions between motions of a program and strokes of the table: dresses and program interrupts."""

from collections import deque
from collections.abc import Callable, Generator, Iterator
from dataclasses import replace
from typing import TypeAlias

from grind_env.control import events
from grind_env.control.control_flow import TEXT_END
from grind_env.control.control_settings import Control
from grind_env.control.dress_retrace import Recorder
from grind_env.control.errors import Place
from grind_env.control.macro_variables import Notes, Variables
from grind_env.control.move_execution import Mover, MoveSection
from grind_env.control.operator_actions import Interrupt
from grind_env.control.path_geometry import split
from grind_env.control.program_reader import Program, Programs

#: function that executes a program in the middle of another one and returns how it ends
Execute: TypeAlias = Callable[[Program, Place], Generator[events.Event, None, str]]


class Interruptions:
    """Execution of dresses and program interrupts, and of motions that an interrupt may divide."""

    def __init__(
        self, mover: Mover, programs: Programs, control: Control, execute: Execute, variables: Variables
    ) -> None:
        self.mover, self.timeline, self.variables = mover, mover.timeline, variables
        self.programs, self.control, self.execute = programs, control, execute
        self.requests = deque(control.interrupts)  # program interrupts requested by time, not yet run
        # dress programs that have once left the tables of the control unchanged, with the values of the variables that
        # they have read
        self.known_dresses: dict[int, Notes] = {}
        self.changing_dress: int | None = None  # first dress program that has changed the tables; None before

    def nothing_comes_between(self, plan: events.CyclePlan) -> bool:
        """Return whether only dresses without messages can come between the strokes of a cycle.

        A dress program that has once left the tables unchanged does so again. Under G96 the wheel may turn faster after
        a dress, and below its minimum radius there is a message.
        """
        control, panel = self.control, self.control.panel
        asked = self.timeline.requested or self.requests or panel.interrupts
        stopped = panel.single_block or panel.holding is not None
        telling = self.mover.modes.surface_speed or control.minimum_radius > 0.0
        notes = self.known_dresses.get(plan.program or 0)  # variables may have changed since
        known = plan.dresses == 0 or (notes is not None and self.variables.agree(notes) and not telling)
        return not asked and not stopped and known and control.dress_amount == 0.0

    def travel(self, sections: list[MoveSection]) -> Iterator[events.Event]:
        """Move along sections; an immediate interrupt may divide a section (lathe manual 29-6)."""
        timeline, mover, left = self.timeline, self.mover, deque(sections)
        while left:
            section = left.popleft()
            path, feed = section.path, section.feed
            yield from timeline.wait(timeline.time)
            time = self._immediate(timeline.time + timeline.duration(path, feed))
            if time is not None:
                fraction = timeline.braked(path, feed, time - timeline.time)
                if fraction < 1.0:
                    path, rest = split(path, fraction)
                    left.appendleft(replace(section, path=rest))
            yield from timeline.move(mover.place, path, feed, section.source)
            if mover.recorder is not None:
                mover.recorder.note(path, feed)
            if time is not None:
                away = yield from self._interrupt(self.requests, section.goal)
                if away:
                    return

    def next_reversal(self) -> Iterator[events.Event]:
        yield from self.timeline.finish_stroke()
        yield from self.serve(0)

    def after_motion(self) -> Iterator[events.Event]:
        if self.timeline.dress_postponed and self.timeline.reciprocation is not None:
            yield from self.timeline.reach_reversal()
        if self.timeline.table_held:
            yield from self.serve(0)

    def after_block(self) -> Iterator[events.Event]:
        while (requests := self._due()) is not None:
            table = self.timeline.reciprocation
            if table is None or table.at_reversal:
                yield from self._interrupt(requests, self.mover.position)
            else:
                yield from self.next_reversal()

    def serve(self, auto: int) -> Iterator[events.Event]:
        """Run the programs due at a reversal point: auto-dresses, the operator's dress (22-11), then interrupts."""
        timeline, table = self.timeline, self.timeline.reciprocation
        if table is None:
            return
        if auto or timeline.table_held:
            number = table.plan.program
            assert number is not None  # neither a D nor a held request is accepted without P
            timeline.settle()
            for _ in range(auto):
                yield from self.dress(number, "auto")
                table.auto_dresses.end_round()
            if timeline.table_held:
                timeline.acknowledge()
                yield from self.dress(number, "operator")
        if self._due() is not None:
            timeline.settle()
            yield from self.after_block()

    def dress(self, number: int, cause: str) -> Iterator[events.Event]:
        """Execute a dress program with all axes at rest, and return them to the point of the interruption (22-11)."""
        timeline, mover, table = self.timeline, self.mover, self.timeline.reciprocation
        program = self.programs.find(number)
        assert program is not None  # the block that names it has been checked
        yield events.DressStart(timeline.time, number, cause)
        tables, values = mover.tables, self.variables.state
        self.variables.begin_notes()
        yield from self._run(program, events.Source.DRESS, returning=True)
        notes = self.variables.end_notes()
        if mover.tables != tables:
            self.changing_dress = self.changing_dress or number
        elif self.variables.state == values:
            self.known_dresses[number] = notes
        if self.control.dress_amount > 0.0:
            mover.follow_wheel(self.control.dress_amount)
        if table is not None:
            table.dresses += 1
        yield events.DressEnd(timeline.time, number, cause)
        yield from mover.turn_spindle()
        if mover.tooling.wheel_radius < self.control.minimum_radius:
            yield events.Message(timeline.time, "the wheel radius is below its minimum")

    def late_requests(self) -> Iterator[str]:
        for request in self.requests:
            yield (
                f"O{request.program}, asked for at {request.at:g} s, is not run, for the program ends at "
                f"{self.timeline.time:.1f} s; ask for it before"
            )

    def _immediate(self, finish: float) -> float | None:
        """Return the time of an immediate interrupt before `finish`, s; during reciprocation None, as it must wait."""
        timeline = self.timeline
        if self.mover.source is not events.Source.PROGRAM or timeline.reciprocation is not None or not self.requests:
            return None
        first = self.requests[0]
        return first.at if first.immediate and timeline.time < first.at < finish else None

    def _due(self) -> deque[Interrupt] | None:
        """Return the queue whose first request is due, the queue of the panel first; None if no request is due.

        An interrupt program is not interrupted.
        """
        if self.mover.source is events.Source.PROGRAM:
            for requests in (self.control.panel.interrupts, self.requests):
                if requests and requests[0].at <= self.timeline.time:
                    return requests
        return None

    def _interrupt(self, requests: deque[Interrupt], goal: events.Position) -> Generator[events.Event, None, bool]:
        """Run the first of `requests`; return whether it leaves the axes elsewhere (type 1, lathe manual 29-6).

        `goal` is the programmed end of the interrupted motion or block.
        """
        interrupt, timeline = requests.popleft(), self.timeline
        program = self.programs.find(interrupt.program)
        if program is None:
            raise self.mover.place.error(
                "program-not-found", f"the interrupt asks for O{interrupt.program}; it must be in the file or beside it"
            )
        yield events.InterruptStart(timeline.time, interrupt.program, interrupt.kind)
        moved = yield from self._run(program, events.Source.INTERRUPT, returning=interrupt.kind == 2)
        yield events.InterruptEnd(timeline.time, interrupt.program, interrupt.kind)
        yield from self.mover.turn_spindle()
        away = moved and interrupt.kind == 1
        if away:
            self.mover.detour = goal
        return away

    def _run(self, program: Program, source: events.Source, returning: bool) -> Generator[events.Event, None, bool]:
        """Execute a program within another one and restore modes and table; return whether it moved an axis.

        The radius compensation is dropped without a motion and armed again afterwards.
        """
        timeline, mover, compensation = self.timeline, self.mover, self.mover.compensation
        modes, place = mover.modes, mover.place
        table, timeline.reciprocation = timeline.reciprocation, None
        programmed, plane, detect = compensation.programmed, compensation.plane, compensation.detect
        compensation.forget()
        mover.modes = modes._replace(compensation="G40")
        recorder = mover.recorder = Recorder(timeline.position, mover.remembered)
        mover.source = source
        end = yield from self.execute(program, table.place if table else place)
        if end != "M99":
            kind = "dress" if source is events.Source.DRESS else "interrupt"
            found = "the end of its text" if end == TEXT_END else end
            raise program.last_place().error(
                f"{kind}-program",
                f"{kind} program O{program.number} comes to {found} before M99; it must return by M99",
            )
        if returning:
            yield from mover.retrace(recorder)
        compensation.forget()
        compensation.programmed, compensation.plane, compensation.detect = programmed, plane, detect
        mover.recorder, mover.source, mover.modes, mover.place = None, events.Source.PROGRAM, modes, place
        timeline.inch = modes.inch
        if table is not None:
            table.free_at = timeline.time
            timeline.reciprocation = table
        return recorder.moved
