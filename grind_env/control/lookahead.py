"""Look-ahead in the compensation plane: coming motions, read before they are executed (15-59).

Nothing is executed here. The view ends at an unreadable block, whose error comes with its execution; only access to
system variables raises an error.
"""

import itertools
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from enum import Enum
from typing import TypeAlias

from grind_env.control import numbers
from grind_env.control.block_decoding import Command, decode
from grind_env.control.block_words import Block, Word, read_block
from grind_env.control.control_flow import BlockStream, Call, execute_statement
from grind_env.control.control_settings import ORIGIN, Control
from grind_env.control.cycles import RULES
from grind_env.control.errors import ControlError
from grind_env.control.events import Position
from grind_env.control.macro_calls import macro_call, repeats
from grind_env.control.macro_variables import DEEPEST_MACRO, Foreseen, Variables
from grind_env.control.modes import CYCLES, PLANES, WORK_SYSTEMS
from grind_env.control.motion_paths import arc_path, target
from grind_env.control.path_geometry import Path, Straight
from grind_env.control.program_reader import HIGHEST_PROGRAM, Program
from grind_env.control.program_scanner import SourceText
from grind_env.control.word_evaluation import evaluated

REFERENCE_MOVES = ("G28", "G29", "G30")
MOST_STATEMENTS = 1000  #: most successive paramacro blocks in a view; they do not count as blocks without motion
PRESET_CODES = ("G52", "G92", "G92.1")
#: local variables that G65 assigns, by number; None for a program called by M98
Arguments: TypeAlias = Mapping[int, Decimal] | None


class Barrier(Enum):
    """Reason why no motion in the plane comes next."""

    LIMIT = "more blocks without motion than compensation survives"
    CANCELLED = "the same after G40"
    COORDINATES = "the work coordinate system changes"
    END = "the program ends or cannot be read on"


@dataclass(frozen=True, slots=True)
class Prospect:
    """A motion in the plane that will come: its path, work origin and length offset in machine coordinates, mm."""

    command: Command
    path: Path
    origin: Position
    length: Position


@dataclass(frozen=True, slots=True)
class Outlook:
    """Start of the view ahead: the current block and its end; points in machine coordinates, mm."""

    command: Command
    position: Position
    origin: Position
    length: Position
    reciprocating: int | None


def in_plane(path: Path, plane: str) -> bool:
    """Return whether a path moves an axis of the plane."""
    return not isinstance(path, Straight) or any(path.start[axis] != path.end[axis] for axis in PLANES[plane])


class Lookout:
    """View of the coming motions in the order of execution.

    A new view continues the last one if this has foreseen the motion under execution and none of its blocks depends on
    a variable.
    """

    def __init__(self, control: Control, find: Callable[[int], Program | None]) -> None:
        self._control, self._find = control, find
        self._walk: _Walk | None = None  # walk of the last view, if a motion of it was taken
        self._seen: deque[Prospect | Barrier] = deque()
        self._rest: Iterator[Prospect | Barrier] = iter(())
        self._table: int | None = None

    def upcoming(self, calls: list[Call], outlook: Outlook, variables: Variables) -> Iterator[Prospect | Barrier]:
        walk, self._walk = self._walk if self._has_foreseen(outlook) else None, None
        return self._items(walk, calls, outlook, variables)

    def _has_foreseen(self, outlook: Outlook) -> bool:
        if self._walk is None or not self._walk.plain or not self._seen or outlook.reciprocating != self._table:
            return False
        first = self._seen[0]
        return (
            isinstance(first, Prospect)
            and first.command is outlook.command
            and first.path.end == outlook.position
            and (first.origin, first.length) == (outlook.origin, outlook.length)
        )

    def _items(
        self, walk: "_Walk | None", calls: list[Call], outlook: Outlook, variables: Variables
    ) -> Iterator[Prospect | Barrier]:
        if walk is None:
            walk = _Walk(calls, self._find, variables)
            self._seen.clear()
            self._rest, self._table = _upcoming(walk, outlook, self._control), outlook.reciprocating
        else:
            self._seen.popleft()
        for number in itertools.count():
            if number == len(self._seen):
                self._walk = None  # in case the view ends in an error
                item = next(self._rest, None)
                if item is None:
                    return
                self._seen.append(item)
            self._walk = walk
            yield self._seen[number]


def _upcoming(walk: "_Walk", outlook: Outlook, control: Control) -> Iterator[Prospect | Barrier]:
    modes, position, origin, length, gap = outlook.command.modes, outlook.position, outlook.origin, outlook.length, 0
    obeyed = 0
    walk.follow(outlook.command)
    for source in walk:
        if gap > control.non_motion_blocks:
            break
        gap += 1
        if source.deletable and control.block_delete:
            continue
        try:
            block = evaluated(walk.read(source), walk.variables)
            if walk.obeys(block):
                gap, obeyed = gap - 1, obeyed + 1
                if obeyed > MOST_STATEMENTS:
                    break
                continue
            command = decode(block, modes, control.number_format)
            if command.tool is not None:
                new = control.length_offset(command.tool[1])
                x, y, z = (at + to - before for at, to, before in zip(origin, new, length, strict=True))
                origin, length = (x, y, z), new
            moved = None if 98 in command.m else _motion(command, position, origin, outlook.reciprocating)
            walk.follow(command)
        except ControlError:
            if walk.foreseen.asked:
                raise
            break
        if command.modes.work_system != modes.work_system or _shifts(command):
            yield Barrier.COORDINATES
            return
        if command.action in CYCLES and RULES[command.action.partition(".")[0]].plunges:
            break
        modes = command.modes
        if moved is not None:
            position = moved.end
            if in_plane(moved, modes.plane):
                yield Prospect(command, moved, origin, length)
                gap = obeyed = 0
            elif command.action in REFERENCE_MOVES:
                break
        if walk.ended:
            break
    if gap <= control.non_motion_blocks:
        yield Barrier.END
    else:
        yield Barrier.CANCELLED if modes.compensation == "G40" else Barrier.LIMIT


def _shifts(command: Command) -> bool:
    """Return whether a block moves the origin of the active work system (lathe 11-8); G10 may load another system."""
    if command.code != "G10":
        return command.code in PRESET_CODES
    number = command.words.get("P")
    return number is None or number.whole.lstrip("0") == str(1 + WORK_SYSTEMS.index(command.modes.work_system))


def _motion(command: Command, position: Position, origin: Position, table: int | None) -> Path | None:
    if command.action in ("G02", "G03"):
        return arc_path(command, position, origin)
    if command.action in ("G00", "G01", *REFERENCE_MOVES):
        return Straight(position, target(command, position, ORIGIN if command.in_machine else origin, table))
    return None


class _Walk:
    """Iterator over the blocks ahead, through calls and returns."""

    def __init__(self, calls: list[Call], find: Callable[[int], Program | None], variables: Variables) -> None:
        self._levels = [call.view() for call in calls]
        self.foreseen = Foreseen()
        self._find, self.variables = find, variables.ahead(self.foreseen)
        self.ended, self.plain = False, True  # no block is left; no block so far depends on a variable

    def __iter__(self) -> Iterator[SourceText]:
        while not self.ended:
            source = next(iter(self._levels[-1].stream), None)
            if source is None:
                self.ended = True
            else:
                yield source

    def read(self, source: SourceText) -> Block:
        block = read_block(source)
        self.plain &= block.is_plain
        return block

    def obeys(self, block: Block) -> bool:
        if block.statement is not None:
            execute_statement(block, self._levels[-1], self.variables)
        elif block.calls_macro:
            _, program, times, arguments = macro_call(block)
            self._call(block, program, times, arguments)
        return block.statement is not None or block.calls_macro

    def follow(self, command: Command) -> None:
        words = command.words
        if 98 in command.m and "P" in words:
            self._call(command.block, words["P"], repeats(command.block, words), None)
        elif 99 in command.m:
            call = self._levels.pop()
            if call.arguments is not None:
                self.variables.leave()
            if call.repeats > 0 or not (self._levels or call.interrupt):
                self._enter(call.stream.program, max(call.repeats - 1, 0), call.arguments)
            elif call.interrupt:
                self.ended = True
        elif 2 in command.m or 30 in command.m:
            self.ended = True

    def _call(self, block: Block, word: Word, times: int, arguments: Arguments) -> None:
        program = self._find(numbers.integer(block, word, 1, HIGHEST_PROGRAM))
        if program is None:
            self.ended = True
        elif times > 0:
            self._enter(program, times - 1, arguments)

    def _enter(self, program: Program, repeats: int, arguments: Arguments) -> None:
        if arguments is not None:
            if self.variables.level == DEEPEST_MACRO:
                self.ended = True
                return
            self.variables.enter(arguments)
        self._levels.append(Call(BlockStream(program), repeats, arguments=arguments))
