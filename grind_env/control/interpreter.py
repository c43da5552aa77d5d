"""Executes part programs: blocks, subprograms, dresses and interrupts become a stream of events."""

from collections import deque
from collections.abc import Generator, Iterator
from dataclasses import replace

from grind_env.control import numbers
from grind_env.control.budget import Budget, Rounds
from grind_env.control.control import Control
from grind_env.control.decode import Command, decode
from grind_env.control.dressing import REMEMBERED, Recorder
from grind_env.control.errors import ControlError, Place
from grind_env.control.expressions import evaluated
from grind_env.control.flow import BlockStream, Call
from grind_env.control.geometry import Straight
from grind_env.control.lookahead import REFERENCE_MOVES, Barrier, Outlook, Prospect, upcoming
from grind_env.control.modes import CYCLES, Modes
from grind_env.control.motions import (
    CycleAhead,
    CyclePlan,
    DressEnd,
    DressStart,
    Event,
    Hold,
    InterruptEnd,
    InterruptStart,
    Message,
    ProgramEnd,
    ProgramStop,
    Source,
    Spindle,
)
from grind_env.control.moves import Mover
from grind_env.control.operator import Interrupt
from grind_env.control.paths import feed_rate
from grind_env.control.reader import HIGHEST_PROGRAM, Block, Program, Programs, Word, read_block
from grind_env.control.rewriting import with_words
from grind_env.control.table import Table
from grind_env.control.timeline import Timeline

DEEPEST = 4
"""Levels of subprograms, a dress program being one (lathe manual 10-15)."""

TEXT_END = "text end"

GROOVES = ("G76", "G77")


class Interpreter:
    """One execution of a part program."""

    def __init__(self, programs: Programs, control: Control) -> None:
        self.programs, self.control = programs, control
        self.budget = Budget(control.block_budget)
        self.timeline = Timeline(control, self.budget)
        self.mover = Mover(self.timeline, control, self._interruption, self._immediate)
        self.table = Table(self.timeline, self.mover, control, self._serve, self.dress, self._alone)
        self.modes = Modes()
        self.calls: list[Call] = []
        self.rounds: Rounds | None = None
        self.remembered = REMEMBERED
        self.remembered_later: int | None = None
        self.interrupts = deque(control.interrupts)
        self.spindle: float | None = None
        self.known_dresses: set[int] = set()
        self.chosen: dict[str, str] = {}
        self.place = programs.main.place

    def run(self) -> Iterator[Event]:
        """Execute the main program to its end; an M99 begins it again, once, for nothing in it could end it later."""
        begun_again = False
        while (end := (yield from self._program(Call(BlockStream(self.programs.main))))) == "M99":
            if begun_again:
                raise self.place.error("block-budget", "M99 begins the main program again without end; end it with M30")
            begun_again = True
            yield from self.table.stop()
            self.table.memory = type(self.table.memory)()
        if end == TEXT_END:
            yield from self.table.run_on()
        yield from self.table.stop()
        self.modes, self.remembered = Modes(), REMEMBERED
        yield ProgramEnd(self.timeline.time, end)

    def dress(self, number: int, cause: str) -> Iterator[Event]:
        """Execute a dress program with all axes at rest, and come back to where they stood (22-11)."""
        timeline, table = self.timeline, self.timeline.reciprocation
        yield DressStart(timeline.time, number, cause)
        tables = self._tables()
        yield from self._interrupted(number, Source.DRESS, returning=True)
        if self._tables() == tables:
            self.known_dresses.add(number)
        tooling = self.mover.tooling
        if self.control.dress_amount > 0.0:
            tooling.dressed_off(self.control.dress_amount)
            self.table.follow_wheel(self.control.dress_amount)
        if table is not None:
            table.dresses += 1
        yield DressEnd(timeline.time, number, cause)
        yield from self._turn_spindle()
        if tooling.worn_out:
            yield Message(timeline.time, "the wheel radius is below its minimum")

    # ------------------------------------------------------------------------------------------ program flow

    def _program(self, call: Call) -> Generator[Event, None, str]:
        """Execute the blocks of a program; returns M02, M30, M99 or "text end"."""
        self.calls.append(call)
        end = TEXT_END
        for source in call.stream:
            self.budget.spend(source.place)
            if source.deletable and self.control.block_delete:
                continue
            block = evaluated(read_block(source), self.control.variables)
            if self.control.announce_cycles and self._is_cycle(block):
                yield CycleAhead(self.timeline.time, block)
                block, self.chosen = evaluated(with_words(block, self.chosen), self.control.variables), {}
            command = decode(block, self.modes, self.control.number_format)
            ended = yield from self._block(command)
            if ended is not None:
                end = ended
                break
        self.calls.pop()
        return end

    def _is_cycle(self, block: Block) -> bool:
        form = self.control.number_format
        return any(word.letter == "G" and numbers.g_code(block, word, form) in CYCLES for word in block.words)

    def _block(self, command: Command) -> Generator[Event, None, str | None]:
        """Execute a block; returns how the program ends with it, None if it goes on."""
        self.modes, self.place = command.modes, command.block.place
        self.timeline.inch = command.modes.inch
        self.mover.compensation.refuse_plane(command)
        self._switch(command)
        yield from self._turn_spindle()
        end = None
        if 98 in command.m:
            end = yield from self._subprogram(command)
        else:
            yield from self._act(command)
            if self.timeline.owed and self.timeline.reciprocation is not None:
                yield from self.timeline.reach_reversal()
            if self.timeline.held:
                yield from self._serve(0)
        for number in command.m:
            if number in (0, 1):
                yield ProgramStop(self.timeline.time, f"M{number:02d}", self.place.block, self.place.line)
            elif number in (2, 30, 99):
                end = f"M{number:02d}"
        if self.control.panel.single_block:
            yield Hold(self.timeline.time, "single block")
        if self.mover.source is Source.PROGRAM:
            yield from self._delayed()
        return end

    def _switch(self, command: Command) -> None:
        """What a block changes besides modes: T, M800 and M801, and M900 to M904 (mill manual 29-7)."""
        length = self.mover.tooling.select(command)
        if length is not None:
            self.mover.work.length = length
        for number in command.m:
            if number in (800, 801):
                self.mover.compensation.detect = number == 801
            elif 900 <= number <= 904 and self.mover.recorder is None:
                self.remembered = number - 900
            elif 900 <= number <= 904:
                self.remembered_later = number - 900

    def _turn_spindle(self) -> Iterator[Event]:
        """Tell a new speed of the wheel."""
        speed = self.mover.tooling.spindle_speed(self.modes, self._no_wheel_radius)
        if speed is not None and speed != self.spindle:
            self.spindle = speed
            yield Spindle(self.timeline.time, speed)

    def _subprogram(self, command: Command) -> Generator[Event, None, str | None]:
        """M98: call a program L times; returns how the part program ends in it, None if it does not."""
        block, words = command.block, command.words
        command.allow_only("PL", "an M98 block")
        if command.code is not None:
            raise command.error("block-format", f"{command.code} stands with M98; a call needs its own block")
        if "P" not in words:
            raise command.error("missing-parameter", "M98 lacks P; it takes the number of the subprogram")
        program = self._find(block, words["P"])
        times = numbers.integer(block, words["L"], 0, 999) if "L" in words else 1
        around = self.rounds
        self.rounds = rounds = Rounds(self.budget, block.place, times, within=around)
        for left in reversed(range(times)):
            end = yield from self._call(program, block.place, Call(BlockStream(program), left))
            if end == TEXT_END:
                raise program.last_place().error(
                    "missing-return", f"subprogram O{program.number} ends without M99; it must return by M99"
                )
            if end != "M99":
                return end
            rounds.end_round()
        self.rounds = around
        return None

    def _call(self, program: Program, place: Place, call: Call) -> Generator[Event, None, str]:
        if len(self.calls) > DEEPEST:
            raise place.error(
                "nesting",
                f"O{program.number} would be level {DEEPEST + 1}; subprograms and dress programs nest at most "
                f"{DEEPEST} levels deep",
            )
        end = yield from self._program(call)
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

    def _ahead(self, outlook: Outlook) -> Iterator[Prospect | Barrier]:
        return upcoming(self.calls, outlook, self.control, self.programs.find)

    def _act(self, command: Command) -> Iterator[Event]:
        action, mover = command.action, self.mover
        if mover.recorder is not None and action in (*CYCLES, *GROOVES, "G80"):
            kind = "dress" if mover.source is Source.DRESS else "interrupt"
            raise command.error(
                f"{kind}-program", f"{action} stands in {'a' if kind == 'dress' else 'an'} {kind} program; no cycle may"
            )
        if action in CYCLES:
            if "P" in command.words:
                self._find(command.block, command.words["P"])
            mover.detour = None
            yield from self.table.cycle(command)
        elif action == "G80":
            yield from self.table.cancel(command)
        elif action in ("G00", "G01"):
            if mover.recorder is None:
                self.table.redirect(command)
            yield from mover.linear(command, self._ahead)
        elif action in ("G02", "G03"):
            yield from mover.circular(command, self._ahead)
        elif action == "G04":
            yield from mover.dwell(command)
        elif action in REFERENCE_MOVES:
            yield from mover.reference(command)
        elif action in GROOVES:
            yield from mover.groove(command)
        elif action == "G10":
            mover.work.load(command)
        elif action == "G92":
            mover.work.preset(command, mover.position)
        else:
            mover.work.cancel_preset(command)

    # ------------------------------------------------------------------------------------------ interruptions

    def _alone(self, plan: CyclePlan) -> bool:
        """Whether nothing can come between the strokes of a cycle, and its dresses have nothing to tell but their time.

        A dress program that has been executed, and has found and left the same tables, does so again. Under G96 the
        wheel may turn faster after a dress, and below its minimum radius there is a message.
        """
        control, panel = self.control, self.control.panel
        asked = self.timeline.requested or self.interrupts or panel.interrupts
        stopped = panel.single_block or panel.holding is not None
        telling = self.modes.surface_speed or control.minimum_radius > 0.0
        known = plan.dresses == 0 or (plan.program in self.known_dresses and not telling)
        return control.whole_cycles and not asked and not stopped and known and control.dress_amount == 0.0

    def _tables(self) -> tuple[object, ...]:
        """What a program can write for later ones."""
        mover, work, tooling = self.mover, self.mover.work, self.mover.tooling
        written = dict(work.offsets), work.shift, work.length, tooling.entry
        return *written, mover.passed, self.remembered

    def _serve(self, auto: int) -> Iterator[Event]:
        """The dresses due at a reversal point: auto-dresses first, then the operator's (22-11)."""
        timeline, table = self.timeline, self.timeline.reciprocation
        if table is None:
            return
        if auto or timeline.held:
            number = table.plan.program
            assert number is not None  # neither a D nor a held request is accepted without P
            timeline.settle()
            for _ in range(auto):
                yield from self.dress(number, "auto")
                table.auto_dresses.end_round()
            if timeline.held:
                timeline.acknowledge()
                yield from self.dress(number, "operator")
        if self._due() is not None:
            timeline.settle()
            yield from self._delayed()

    def _interruption(self, begin: float, finish: float) -> float | None:
        """When an immediate program interrupt comes between two times; during reciprocation it has to wait."""
        if self.mover.source is not Source.PROGRAM or self.timeline.reciprocation is not None or not self.interrupts:
            return None
        first = self.interrupts[0]
        return first.at if first.immediate and begin < first.at < finish else None

    def _due(self) -> Interrupt | None:
        """The next program interrupt that has been requested by now."""
        panel = self.control.panel
        if panel.interrupts:
            return panel.interrupts[0]
        return self.interrupts[0] if self.interrupts and self.interrupts[0].at <= self.timeline.time else None

    def _delayed(self) -> Iterator[Event]:
        """Program interrupts at the end of a block or at a reversal point."""
        while (interrupt := self._due()) is not None:
            table = self.timeline.reciprocation
            if table is None or table.at_reversal:
                yield from self._interrupt(interrupt)
            else:
                yield from self.timeline.finish_stroke()
                yield from self._serve(0)

    def _immediate(self) -> Generator[Event, None, bool]:
        return (yield from self._interrupt(self.interrupts[0]))

    def _interrupt(self, interrupt: Interrupt) -> Generator[Event, None, bool]:
        """Run a program interrupt; returns whether it leaves the axes elsewhere (type 1, lathe manual 29-6)."""
        panel = self.control.panel
        (panel.interrupts if panel.interrupts else self.interrupts).popleft()
        program = self.programs.find(interrupt.program)
        if program is None:
            raise self.place.error(
                "program-not-found", f"the interrupt asks for O{interrupt.program}; it must be in the file or beside it"
            )
        programmed = self.mover.goal or self.mover.position
        yield InterruptStart(self.timeline.time, interrupt.program, interrupt.kind)
        moved = yield from self._interrupted(interrupt.program, Source.INTERRUPT, returning=interrupt.kind == 2)
        yield InterruptEnd(self.timeline.time, interrupt.program, interrupt.kind)
        away = moved and interrupt.kind == 1
        if away:
            self.mover.detour = programmed
        return away

    def _interrupted(self, number: int, source: Source, returning: bool) -> Generator[Event, None, bool]:
        """Execute a program in the middle of another one, which finds modes and table as they were.

        The radius compensation is dropped without a motion and armed again afterwards.

        Returns:
            whether the program moved an axis.
        """
        program = self.programs.find(number)
        assert program is not None  # the block that names it has been checked
        timeline, mover, modes, place = self.timeline, self.mover, self.modes, self.place
        # what it calls is not called in every round of what it interrupts
        rounds, self.rounds = self.rounds, None
        table, timeline.reciprocation = timeline.reciprocation, None
        programmed, plane, detect = (mover.compensation.programmed, mover.compensation.plane, mover.compensation.detect)
        mover.compensation.forget()
        mover.compensation.programmed = None
        self.modes = _without_compensation(modes)
        recorder = mover.recorder = Recorder(timeline.position, self.remembered)
        mover.source = source
        end = yield from self._call(
            program, table.place if table else place, Call(BlockStream(program), interrupt=True)
        )
        if end != "M99":
            kind = "dress" if source is Source.DRESS else "interrupt"
            found = "the end of its text" if end == TEXT_END else end
            raise program.last_place().error(
                f"{kind}-program", f"{kind} program O{number} comes to {found} before M99; it must return by M99"
            )
        if returning:
            yield from self._retrace(recorder)
        self.rounds = rounds
        mover.compensation.forget()
        mover.compensation.programmed, mover.compensation.plane = programmed, plane
        mover.compensation.detect = detect
        mover.recorder, mover.source, self.modes, self.place = None, Source.PROGRAM, modes, place
        timeline.inch = modes.inch
        if self.remembered_later is not None:
            self.remembered, self.remembered_later = self.remembered_later, None
        if table is not None:
            table.free_at = timeline.time
            timeline.reciprocation = table
        return recorder.moved

    def _retrace(self, recorder: Recorder) -> Iterator[Event]:
        """The way back, asked for by the M99 of the program."""
        for leg in recorder.way_back(self.timeline.position, self._link_feed):
            path = Straight(self.timeline.position, leg.end)
            if path.length > 0.0:
                yield from self.timeline.move(self.place, path, leg.feed, Source.RETRACE)
                if self.control.panel.single_block:
                    yield Hold(self.timeline.time, "single block")

    def _link_feed(self) -> float | None:
        """Feed of a straight move under the modes in force; None for a rapid."""
        if self.modes.motion == "G00":
            return None
        modes = self.modes

        def missing() -> ControlError:
            return self.place.error("no-feedrate", f"the way back under {modes.motion} has no F; program it before")

        speed = self.mover.tooling.spindle_speed(modes, self._no_wheel_radius)
        return feed_rate(modes, speed, self.control, missing)

    def _no_wheel_radius(self) -> ControlError:
        return self.place.error("no-wheel-radius", "G96 needs the wheel radius; give entry 33 of the radius table")


def _without_compensation(modes: Modes) -> Modes:
    return modes if modes.compensation == "G40" else replace(modes, compensation="G40")
