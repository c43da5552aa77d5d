"""Executes part programs: blocks, subprograms, cycles and dressing interrupts become a stream of events."""

from collections.abc import Generator, Iterator
from dataclasses import replace

from grind_env.control import numbers
from grind_env.control.control import Budget, Control
from grind_env.control.cycles import Memory, Situation, plan_cycle, redirect
from grind_env.control.decode import Command, decode
from grind_env.control.dressing import REMEMBERED, Recorder
from grind_env.control.errors import Place
from grind_env.control.geometry import Straight
from grind_env.control.grinding import cross_grind, plunge_grind
from grind_env.control.modes import CYCLES, Modes
from grind_env.control.motions import (
    CycleEnd,
    CycleStart,
    DressEnd,
    DressStart,
    Event,
    ProgramEnd,
    ProgramStop,
    Source,
)
from grind_env.control.paths import AXES, INTEGRANDS, arc_path, dwell_seconds, feed_rate, no_feed_rate, target
from grind_env.control.reader import HIGHEST_PROGRAM, Block, Program, Programs, Word, read_block
from grind_env.control.reciprocation import Reciprocation
from grind_env.control.timeline import Timeline

DEEPEST = 4
"""Levels of subprograms, a dress program being one (lathe manual 10-15)."""

TEXT_END = "text end"


class Interpreter:
    """One execution of a part program."""

    def __init__(self, programs: Programs, control: Control) -> None:
        self.programs, self.control = programs, control
        self.budget = Budget(control.block_budget)
        self.timeline = Timeline(control, self.budget)
        self.modes = Modes()
        self.memory = Memory()
        self.level = 0
        self.remembered = REMEMBERED
        self.remembered_later: int | None = None
        self.recorder: Recorder | None = None
        self.place = programs.main.place

    def run(self) -> Iterator[Event]:
        """Execute the main program to its end."""
        while (end := (yield from self._program(self.programs.main))) == "M99":
            yield from self._stop_reciprocation()
            self.memory = Memory()
        if end == TEXT_END:
            yield from self._let_reciprocate()
        yield from self._stop_reciprocation()
        yield ProgramEnd(self.timeline.time, end)

    def dress(self, number: int, cause: str) -> Iterator[Event]:
        """Execute a dress program with all axes at rest, and come back to where they stood (22-11)."""
        program = self.programs.find(number)
        assert program is not None  # the cycle block has been checked
        timeline, modes = self.timeline, self.modes
        table, timeline.reciprocation = timeline.reciprocation, None
        self.recorder = Recorder(timeline.position, self.remembered)
        yield DressStart(timeline.time, number, cause)
        end = yield from self._call(program, table.place if table else program.place)
        if end != "M99":
            found = "the end of its text" if end == TEXT_END else end
            raise program.last_place().error(
                "dress-program", f"dress program O{number} comes to {found} before M99; it must return by M99"
            )
        yield from self._retrace(self.recorder)
        self.recorder, self.modes = None, modes
        timeline.inch = modes.inch
        if self.remembered_later is not None:
            self.remembered, self.remembered_later = self.remembered_later, None
        if table is not None:
            table.dresses += 1
            table.free_at = timeline.time
            timeline.reciprocation = table
        yield DressEnd(timeline.time, number, cause)

    # ------------------------------------------------------------------------------------------ program flow

    def _program(self, program: Program) -> Generator[Event, None, str]:
        """Execute the blocks of a program; returns M02, M30, M99 or "text end"."""
        for source in program.blocks:
            self.budget.spend(source.place)
            if source.deletable and self.control.block_delete:
                continue
            command = decode(read_block(source), self.modes)
            self.modes, self.place = command.modes, command.block.place
            self.timeline.inch = command.modes.inch
            self._retrace_count(command)
            if 98 in command.m:
                end = yield from self._subprogram(command)
                if end is not None:
                    return end
            else:
                yield from self._act(command)
                if self.timeline.held:
                    yield from self._serve(0)
            for number in command.m:
                if number in (0, 1):
                    place = command.block.place
                    yield ProgramStop(self.timeline.time, f"M{number:02d}", place.block, place.line)
                elif number in (2, 30, 99):
                    return f"M{number:02d}"
        return TEXT_END

    def _subprogram(self, command: Command) -> Generator[Event, None, str | None]:
        """M98: call a program L times; returns how the part program ends in it, None if it does not."""
        block, words = command.block, command.words
        command.allow_only("PL", "an M98 block")
        if command.code is not None:
            raise command.error("block-format", f"{command.code} stands with M98; a call needs its own block")
        if "P" not in words:
            raise command.error("missing-parameter", "M98 lacks P, the number of the subprogram")
        program = self._find(block, words["P"])
        for _ in range(numbers.integer(block, words["L"], 0, 999) if "L" in words else 1):
            end = yield from self._call(program, block.place)
            if end == TEXT_END:
                raise program.last_place().error(
                    "missing-return", f"subprogram O{program.number} ends without M99; it must return by M99"
                )
            if end != "M99":
                return end
        return None

    def _call(self, program: Program, place: Place) -> Generator[Event, None, str]:
        if self.level == DEEPEST:
            raise place.error(
                "nesting",
                f"O{program.number} would be level {DEEPEST + 1}; subprograms and dress programs nest at most "
                f"{DEEPEST} levels deep",
            )
        self.level += 1
        end = yield from self._program(program)
        self.level -= 1
        return end

    def _find(self, block: Block, word: Word) -> Program:
        number = numbers.integer(block, word, 1, HIGHEST_PROGRAM)
        program = self.programs.find(number)
        if program is None:
            raise block.error(
                "program-not-found",
                f"{word} names no program; O{number} must be in the file or beside it",
                word,
            )
        return program

    def _retrace_count(self, command: Command) -> None:
        """M900 to M904; within a dress program they hold from the next dress on (mill manual 29-7)."""
        for number in command.m:
            if 900 <= number <= 904 and self.recorder is None:
                self.remembered = number - 900
            elif 900 <= number <= 904:
                self.remembered_later = number - 900

    def _act(self, command: Command) -> Iterator[Event]:
        action = command.action
        if action in CYCLES or action == "G80":
            if self.recorder is not None:
                raise command.error("dress-program", f"{action} stands in a dress program; no cycle may")
            yield from self._cycle(command) if action in CYCLES else self._cancel(command)
        elif action == "G04":
            here = self.timeline.position
            yield from self.timeline.move(
                command.block.place, Straight(here, here), None, self._source, dwell_seconds(command)
            )
        elif action in ("G00", "G01"):
            yield from self._linear(command)
        else:
            yield from self._circular(command)

    # --------------------------------------------------------------------------------------------- motions

    @property
    def _source(self) -> Source:
        return Source.PROGRAM if self.recorder is None else Source.DRESS

    def _linear(self, command: Command) -> Iterator[Event]:
        """G00 or G01; words of the reciprocating axis and E change its reciprocation (16-9, PD-7)."""
        timeline, table = self.timeline, self.timeline.reciprocation
        command.allow_only("XYZ" if table is None else "XYZ" + INTEGRANDS[table.axis], f"this {command.action} block")
        if command.reciprocation_feed is not None and self.recorder is None:
            self.memory = replace(self.memory, feed=command.reciprocation_feed)
        if table is not None:
            self.memory = redirect(command, self.memory, table, self.control.maximum_feed)
        end = target(command, timeline.position, None if table is None else table.axis)
        path = Straight(timeline.position, end)
        if path.length == 0.0:
            return
        feed = None if command.action == "G00" else self._feed(command)
        yield from timeline.move(command.block.place, path, feed, self._source)
        if self.recorder is not None:
            self.recorder.linear(end, feed)

    def _circular(self, command: Command) -> Iterator[Event]:
        path = arc_path(command, self.timeline.position)
        if path is None:
            return
        table = self.timeline.reciprocation
        if table is not None and path.moves(table.axis):
            raise command.error(
                "axis-conflict",
                f"{command.action} moves {AXES[table.axis]}, which reciprocates; program G80 before the arc",
            )
        yield from self.timeline.move(command.block.place, path, self._feed(command), self._source)
        if self.recorder is not None:
            self.recorder.circular()

    def _feed(self, command: Command) -> float:
        return feed_rate(command.modes, self.control, no_feed_rate(command))

    # ------------------------------------------------------------------------------------ cycles and dressing

    def _cycle(self, command: Command) -> Iterator[Event]:
        """Plan a G81, G82 or G83, let it take over the table, and work it off (G81 goes on by itself)."""
        timeline, table = self.timeline, self.timeline.reciprocation
        situation = Situation(
            timeline.position,
            None if table is None else table.axis,
            0.0 if table is None else table.secondary,
            self.control.maximum_feed,
        )
        plan, memory = plan_cycle(command, self.memory, situation)
        if "P" in command.words:
            self._find(command.block, command.words["P"])
        while table is not None and not table.at_secondary:
            yield from timeline.finish_stroke()
            yield from self._serve(0)
        yield from self._end_reciprocation_cycle()
        self.memory = memory
        place = command.block.place
        if table is None:
            start = timeline.position[plan.axis]
            table = Reciprocation(plan, place, plan.primary, plan.secondary, plan.feed, start, timeline.time)
            timeline.reciprocation = table
        else:
            table.take_over(plan, place)
        yield CycleStart(timeline.time, plan)
        if plan.pre_dress and plan.program is not None:
            yield from self.dress(plan.program, "pre")
        if plan.code == "G81":
            return
        grind = plunge_grind if plan.code == "G82" else cross_grind
        table.in_cycle = True
        yield from grind(plan, timeline, self._serve)
        timeline.settle()
        table.in_cycle = False
        yield CycleEnd(timeline.time, plan, table.count, table.dresses)

    def _serve(self, auto: int) -> Iterator[Event]:
        """The dresses due at a reversal point: auto-dresses first, then the operator's (22-11)."""
        timeline, table = self.timeline, self.timeline.reciprocation
        if table is None or not (auto or timeline.held):
            return
        number = table.plan.program
        assert number is not None  # neither a D nor a held request is accepted without P
        timeline.settle()
        for _ in range(auto):
            yield from self.dress(number, "auto")
        if timeline.held:
            timeline.acknowledge()
            yield from self.dress(number, "operator")

    def _retrace(self, recorder: Recorder) -> Iterator[Event]:
        """The way back, asked for by the M99 of the dress program."""
        for leg in recorder.way_back(self.timeline.position, self._link_feed):
            path = Straight(self.timeline.position, leg.end)
            if path.length > 0.0:
                yield from self.timeline.move(self.place, path, leg.feed, Source.RETRACE)

    def _link_feed(self) -> float | None:
        """Feed of a straight move under the modes in force; None for a rapid."""
        if self.modes.motion == "G00":
            return None
        missing = self.place.error("no-feedrate", f"the way back under {self.modes.motion} has no F; program it before")
        return feed_rate(self.modes, self.control, missing)

    def _cancel(self, command: Command) -> Iterator[Event]:
        """G80: stop at the next reversal point (PD-1)."""
        command.allow_only("", "a G80 block")
        yield from self._stop_reciprocation()

    def _let_reciprocate(self) -> Iterator[Event]:
        """The strokes of a G81 that the end of the text leaves running (ruling 11)."""
        table = self.timeline.reciprocation
        while table is not None and table.plan.code == "G81" and table.count < self.control.strokes:
            yield from self.timeline.finish_stroke()
            yield from self._serve(0)

    def _stop_reciprocation(self) -> Iterator[Event]:
        """Finish the stroke in progress and let the table stand (PD-1, ruling 1)."""
        table = self.timeline.reciprocation
        if table is not None and not table.at_reversal:
            yield from self.timeline.finish_stroke()
            yield from self._serve(0)
        yield from self._end_reciprocation_cycle()
        self.timeline.reciprocation = None

    def _end_reciprocation_cycle(self) -> Iterator[Event]:
        table = self.timeline.reciprocation
        if table is not None and table.plan.code == "G81":
            yield CycleEnd(self.timeline.time, table.plan, table.count, table.dresses)
