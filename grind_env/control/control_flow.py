"""The order in which blocks are executed: jumps and loops, calls, and the view ahead."""

import bisect
import functools
import itertools
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal, DecimalException
from typing import NamedTuple

from grind_env.control.block_words import Block
from grind_env.control.macro_formulas import FormulaFault, Tree, VariableFault, number_of, value_of, variable_number
from grind_env.control.macro_statements import Assign, End, Goto, Then, While, end_of, label_of
from grind_env.control.macro_variables import ALARM, Variables
from grind_env.control.program_reader import Blocks, Program
from grind_env.control.program_scanner import SourceText
from grind_env.control.word_evaluation import MORE_DIGITS, fault_in

TEXT_END = "text end"  #: end of a program whose text ends before an M02, M30 or M99
MOST_BLOCKS = 20_000  #: most blocks of a program that jumps; its blocks are kept in memory


class BlockStream:
    """The blocks of one run through a program; blocks ahead can be read without being taken."""

    def __init__(self, program: Program, index: int = 0, blocks: Iterator[SourceText] | None = None) -> None:
        self.program, self.index = program, index
        self._blocks = iter(program.blocks) if blocks is None else blocks
        self._ahead: deque[SourceText] = deque()

    def __iter__(self) -> Iterator[SourceText]:
        while self._ahead or self._draw():
            self.index += 1
            yield self._ahead.popleft()

    def ahead(self) -> Iterator[SourceText]:
        for index in itertools.count(self.index):
            if index - self.index >= len(self._ahead) and not self._draw():
                return
            yield self._ahead[index - self.index]

    def view(self) -> "BlockStream":
        return BlockStream(self.program, self.index, self.ahead())

    def jump(self, index: int) -> None:
        kept = _block_texts(self.program.blocks)
        self._ahead.clear()
        self.index, self._blocks = index, (kept[number] for number in range(index, len(kept)))

    def _draw(self) -> bool:
        source = next(self._blocks, None)
        if source is not None:
            self._ahead.append(source)
        return source is not None


class Loop(NamedTuple):
    """A loop under execution: its number and the indices of its first and its last block."""

    number: int
    begin: int
    end: int


class Round(NamedTuple):
    """State of the variables at a jump back."""

    values: tuple[object, int]  #: values of all variables, and the number of reads of system variables so far
    span: int  #: number of jumps for which the state is kept
    left: int  #: number of these jumps still to come


@dataclass(slots=True)
class Call:
    """A program under execution."""

    stream: BlockStream  #: blocks of the program
    repeats: int = 0  #: number of further calls after this one (L of M98 and G65)
    interrupt: bool = False  #: whether it is a dress or interrupt program, whose M99 leads back into another program
    # local variables that G65 assigns, by number; None for a program that G65 has not called
    arguments: Mapping[int, Decimal] | None = None
    loops: list[Loop] = field(default_factory=list)  #: loops under execution, the innermost last
    # state of the variables at earlier jumps back, by the index of their blocks
    rounds: dict[int, "Round"] = field(default_factory=dict)

    def view(self) -> "Call":
        return Call(self.stream.view(), self.repeats, self.interrupt, self.arguments, list(self.loops))


class Landmarks(NamedTuple):
    """Targets of jumps in a program; indices ascend."""

    labels: Mapping[int, Sequence[int]]  #: indices of the blocks with an N number
    ends: Mapping[int, Sequence[int]]  #: indices of the blocks END 1, END 2 and END 3


def execute_statement(block: Block, call: Call, variables: Variables) -> None:
    """Execute a paramacro statement: assign a variable, or choose the block that comes next."""
    here = call.stream.index
    match block.statement:
        case Assign():
            _assign(block, block.statement, variables)
        case Then(condition, assign):
            if _holds(block, condition, variables):
                _assign(block, assign, variables)
        case Goto(condition, label):
            if condition is None or _holds(block, condition, variables):
                _go_to(block, _number(block, label, variables), call)
        case While():
            _loop(block, block.statement, call, variables)
        case End(number):
            if not call.loops or call.loops[-1].number != number:
                raise block.error("jump", f"END {number} ends no loop that has begun; DO {number} must come before it")
            call.stream.jump(call.loops[-1].begin)
    if call.stream.index < here:
        _refuse_endless(block, here, call, variables)


def _refuse_endless(block: Block, here: int, call: Call, variables: Variables) -> None:
    """Raise an error at a jump back with the values of an earlier jump: the program would repeat without end.

    The earlier jump is chosen as in Brent's cycle detection, so cycles of any length are found.
    """
    now, known = (variables.state, variables.system_reads), call.rounds.get(here)
    if known is not None and known.values == now:
        message = "the program goes round here without end, for its variables come back to what they were"
        raise block.error("block-budget", f"{message}; change one that a condition asks for")
    if known is None or known.left == 0:
        span = 1 if known is None else 2 * known.span
        call.rounds[here] = Round(now, span, span - 1)
    else:
        call.rounds[here] = known._replace(left=known.left - 1)


def _assign(block: Block, assign: Assign, variables: Variables) -> None:
    target, value = assign
    try:
        number, found = variable_number(target, variables.read), value_of(value, variables.read)
        if number == ALARM:
            shown = "" if found is None else f" {found.normalize():f}"
            said = block.comment or "it says no reason"
            raise block.error("alarm", f"the program stops itself with alarm{shown}: {said}")
        variables.write(number, found)
    except VariableFault as fault:
        raise fault_in(block, FormulaFault(str(fault), target.at), 0) from None
    except FormulaFault as fault:
        raise fault_in(block, fault, 0) from None
    except DecimalException:
        raise block.error("expression", f"a value {MORE_DIGITS}") from None


def _holds(block: Block, condition: Tree, variables: Variables) -> bool:
    return _number(block, condition, variables) != 0


def _number(block: Block, tree: Tree, variables: Variables) -> Decimal:
    try:
        return number_of(tree, variables.read)
    except FormulaFault as fault:
        raise fault_in(block, fault, 0) from None
    except DecimalException:
        raise block.error("expression", f"a value {MORE_DIGITS}") from None


def _go_to(block: Block, label: Decimal, call: Call) -> None:
    stream = call.stream
    found = landmarks(stream.program.blocks, block).labels.get(int(label), ()) if label == int(label) else ()
    if not found:
        message = f"GOTO leads to N{label.normalize():f}, with which no block of this program begins; label one so"
        raise block.error("jump", message)
    behind = bisect.bisect_left(found, stream.index)
    target = found[behind] if behind < len(found) else found[0]
    call.loops = [loop for loop in call.loops if loop.begin <= target <= loop.end]
    stream.jump(target)


def _loop(block: Block, loop: While, call: Call, variables: Variables) -> None:
    stream, number = call.stream, loop.number
    begin, around = stream.index - 1, call.loops[-1] if call.loops else None
    again = around is not None and around.begin == begin
    if again:
        end = call.loops.pop().end
    else:
        ends = landmarks(stream.program.blocks, block).ends.get(number, ())
        behind = bisect.bisect_right(ends, begin)
        if behind == len(ends):
            raise block.error("jump", f"the loop DO {number} has no END {number} behind it; end it with one")
        end = ends[behind]
        if any(other.number == number for other in call.loops):
            raise block.error("jump", f"DO {number} stands within another DO {number}; number the inner one otherwise")
        if around is not None and end > around.end:
            message = f"DO {number} ends behind the END {around.number} around it; let END {number} come first"
            raise block.error("jump", message)
    if loop.condition is None or _holds(block, loop.condition, variables):
        call.loops.append(Loop(number, begin, end))
    else:
        stream.jump(end + 1)


@functools.lru_cache(maxsize=16)
def _landmarks(blocks: Blocks) -> Landmarks:
    labels: dict[int, list[int]] = {}
    ends: dict[int, list[int]] = {}
    for index, source in enumerate(_block_texts(blocks)):
        for marks, number in ((labels, label_of(source.text)), (ends, end_of(source.text))):
            if number is not None:
                marks.setdefault(number, []).append(index)
    return Landmarks(labels, ends)


def landmarks(blocks: Blocks, block: Block) -> Landmarks:
    """Return the possible targets of a block's jump."""
    if len(blocks) > MOST_BLOCKS:
        message = f"the program has {len(blocks)} blocks, but jumps and loops are for up to {MOST_BLOCKS}"
        raise block.error("jump", f"{message}; put the loop into a subprogram")
    return _landmarks(blocks)


@functools.lru_cache(maxsize=16)
def _block_texts(blocks: Blocks) -> tuple[SourceText, ...]:
    return tuple(blocks)
