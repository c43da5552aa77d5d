"""Interpreter of part programs: blocks, subprograms, dresses and interrupts become a stream of events."""

from collections.abc import Generator, Iterator

from grind_env.control import numbers
from grind_env.control.axis_timeline import Timeline
from grind_env.control.block_decoding import Command, decode
from grind_env.control.block_words import Block, Word, read_block
from grind_env.control.control_flow import TEXT_END, BlockStream, Call, execute_statement
from grind_env.control.control_settings import Control
from grind_env.control.errors import Place
from grind_env.control.events import CycleAhead, Event, FeedAhead, Hold, Message, ProgramEnd, ProgramStop, Source
from grind_env.control.execution_limits import BlockBudget, Rounds
from grind_env.control.interruptions import Interruptions
from grind_env.control.lookahead import REFERENCE_MOVES, Barrier, Lookout, Outlook, Prospect
from grind_env.control.macro_calls import MacroCall, macro_call, repeats
from grind_env.control.macro_variables import DEEPEST_MACRO, Variables
from grind_env.control.modal_state import Modes
from grind_env.control.modes import CYCLES
from grind_env.control.move_execution import Mover
from grind_env.control.program_reader import HIGHEST_PROGRAM, Program, Programs
from grind_env.control.reciprocator import Reciprocator
from grind_env.control.system_variables import SystemVariables
from grind_env.control.word_evaluation import evaluated
from grind_env.control.word_rewriting import with_words

DEEPEST = 4  #: most levels of subprograms and dress programs; macros do not count (lathe manual 10-15)

GROOVES = ("G76", "G77")


class Interpreter:
    """One execution of a part program."""

    def __init__(self, programs: Programs, control: Control) -> None:
        self.programs, self.control = programs, control
        self.budget = BlockBudget(control.block_budget)
        self.timeline = Timeline(control, self.budget)
        self.mover = Mover(self.timeline, control, programs.main.place)
        self.system = SystemVariables(self.mover)
        self.variables = Variables(control.variables, self.system)
        self.interruptions = Interruptions(self.mover, programs, control, self._execute_between, self.variables)
        self.table = Reciprocator(self.mover, self.interruptions, control)
        self.lookout = Lookout(control, programs.find)
        self.calls: list[Call] = []
        self.rounds: Rounds | None = None
        self.over = False
        self.chosen: dict[str, str] = {}

    def run(self) -> Iterator[Event]:
        """Execute the main program to its end; an M99 begins it again, a second M99 is an error."""
        begun_again = False
        while (end := (yield from self._program(Call(BlockStream(self.programs.main))))) == "M99":
            if begun_again:
                raise self.mover.place.error(
                    "block-budget", "M99 begins the main program again a second time; end it with M30"
                )
            begun_again = True
            yield from self.table.stop()
            self.table.memory = type(self.table.memory)()
        self.over = True
        if end == TEXT_END:
            yield from self.table.run_on()
        yield from self.table.stop()
        self.mover.modes = Modes()
        for text in (*self.variables.unread(), *self.timeline.late_requests(), *self.interruptions.late_requests()):
            yield Message(self.timeline.time, text)
        yield ProgramEnd(self.timeline.time, end)

    def _program(self, call: Call) -> Generator[Event, None, str]:
        self.calls.append(call)
        end = TEXT_END
        for source in call.stream:
            self.budget.spend(source.place)
            if source.deletable and self.control.block_delete:
                continue
            block = read_block(source)
            if block.statement is not None:
                execute_statement(block, call, self.variables)
                continue
            block = evaluated(block, self.variables)
            if block.calls_macro:
                ended = yield from self._macro(macro_call(block))
            else:
                if self.control.announce_cycles and self._is_cycle(block):
                    yield CycleAhead(self.timeline.time, block)
                    block = self._as_chosen(block)
                command = decode(block, self.mover.modes, self.control.number_format)
                if self.control.announce_feeds and (goal := self.mover.feed_end(command)) is not None:
                    yield FeedAhead(self.timeline.time, block, self.timeline.position, goal)
                    command = decode(self._as_chosen(block), self.mover.modes, self.control.number_format)
                ended = yield from self._block(command)
            if ended is not None:
                end = ended
                break
        self.calls.pop()
        return end

    def _as_chosen(self, block: Block) -> Block:
        words, self.chosen = self.chosen, {}
        return evaluated(with_words(block, words), self.variables)

    def _is_cycle(self, block: Block) -> bool:
        form = self.control.number_format
        return any(word.letter == "G" and numbers.g_code(block, word, form) in CYCLES for word in block.words)

    def _block(self, command: Command) -> Generator[Event, None, str | None]:
        self.mover.begin_block(command)
        yield from self.mover.report_clamped_feed(command)
        yield from self.mover.report_cut_decimals(command)
        yield from self.mover.turn_spindle()
        yield from self.mover.switch(command, on=True)
        end = None
        if 98 in command.m:
            end = yield from self._subprogram(command)
        else:
            yield from self._act(command)
            yield from self.interruptions.after_motion()
        yield from self.mover.switch(command, on=False)
        place = self.mover.place
        for number in command.m:
            if number in (0, 1):
                reciprocating = self.timeline.reciprocation is not None
                yield ProgramStop(self.timeline.time, f"M{number:02d}", place.block, place.line, reciprocating)
            elif number in (2, 30, 99):
                end = f"M{number:02d}"
        if self.control.panel.single_block:
            yield Hold(self.timeline.time, "single block")
        yield from self.interruptions.after_block()
        return end

    def _subprogram(self, command: Command) -> Generator[Event, None, str | None]:
        """M98: call a program L times; return how the part program ends in it, None if it goes on."""
        block, words = command.block, command.words
        command.allow_only("PL", "an M98 block")
        if command.code is not None:
            raise command.error("block-format", f"{command.code} stands with M98; a call needs its own block")
        if "P" not in words:
            raise command.error("missing-parameter", "M98 lacks P; it takes the number of the subprogram")
        return (yield from self._repeatedly(MacroCall(block, words["P"], repeats(block, words), None)))

    def _macro(self, call: MacroCall) -> Generator[Event, None, str | None]:
        place, variables = call.block.place, self.variables
        self.mover.place = place
        if variables.level == DEEPEST_MACRO:
            raise place.error(
                "nesting", f"G65 would be level {DEEPEST_MACRO + 1}; macros nest {DEEPEST_MACRO} levels deep"
            )
        return (yield from self._repeatedly(call))

    def _repeatedly(self, called: MacroCall) -> Generator[Event, None, str | None]:
        """Call a program as often as a block says; return how the part program ends in it, None if it goes on."""
        block, place = called.block, called.block.place
        program = self._find(block, called.program)
        around = self.rounds
        self.rounds = rounds = Rounds(self.budget, place, called.times, within=around)
        for left in reversed(range(called.times)):
            call = Call(BlockStream(program), left, arguments=called.arguments)
            if called.arguments is not None:
                self.variables.enter(called.arguments)
            end = yield from self._call(program, place, call)
            if called.arguments is not None:
                self.variables.leave()
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
        subprograms = [each for each in self.calls if each.arguments is None]
        if call.arguments is None and len(subprograms) > DEEPEST:
            raise place.error(
                "nesting",
                f"O{program.number} would be level {DEEPEST + 1}; subprograms and dress programs nest at most "
                f"{DEEPEST} levels deep",
            )
        return (yield from self._program(call))

    def _execute_between(self, program: Program, place: Place) -> Generator[Event, None, str]:
        # its subprograms are not repeated with the rounds of the interrupted program
        rounds, self.rounds = self.rounds, None
        end = yield from self._call(program, place, Call(BlockStream(program), interrupt=True))
        self.rounds = rounds
        return end

    def _find(self, block: Block, word: Word) -> Program:
        number = numbers.integer(block, word, 1, HIGHEST_PROGRAM)
        program = self.programs.find(number)
        if program is None:
            raise block.error(
                "program-not-found", f"{word} names no program; O{number} must be in the file or beside it", word
            )
        return program

    def _ahead(self, outlook: Outlook) -> Iterator[Prospect | Barrier]:
        return self.lookout.upcoming(self.calls, outlook, self.variables)

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
            yield from self.interruptions.travel(mover.linear(command, self._ahead))
        elif action in ("G02", "G03"):
            yield from self.interruptions.travel(mover.circular(command, self._ahead))
        elif action == "G04":
            yield from mover.dwell(command)
        elif action in REFERENCE_MOVES:
            yield from self.interruptions.travel(mover.reference(command))
        elif action in GROOVES:
            yield from mover.groove(command)
        elif action == "G10":
            mover.work.load(command)
        elif action == "G52":
            mover.work.set_local(command)
        elif action == "G92":
            mover.work.preset(command, mover.position)
        else:
            mover.work.cancel_preset(command)
