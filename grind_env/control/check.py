"""Reads every block of a program and executes it, to report what is wrong or what it does."""

from dataclasses import dataclass, field

from grind_env.control.control import Control
from grind_env.control.decode import recognise
from grind_env.control.errors import ControlError
from grind_env.control.execution import execute
from grind_env.control.expressions import evaluated
from grind_env.control.motions import CycleEnd, Message, Motion
from grind_env.control.reader import Programs, read_block


@dataclass(slots=True)
class Report:
    """What a check found.

    Attributes:
        programs: number of programs read.
        blocks: number of blocks in them.
        motions: number of motions made.
        seconds: time of the execution, s.
        cycles: every cycle executed, with its strokes and dresses.
        messages: what the control told the operator.
        errors: the first error of reading and the first of execution, once if they are the same.
    """

    programs: int = 0
    blocks: int = 0
    motions: int = 0
    seconds: float = 0.0
    cycles: list[CycleEnd] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    errors: list[ControlError] = field(default_factory=list)


def check(programs: Programs, control: Control | None = None) -> Report:
    """Execute the main program and read every block, those included that are not reached."""
    report = Report()
    executed = _execution_error(programs, control, report)
    for program in programs:
        report.programs += 1
        report.blocks += len(program.blocks)
    read = _reading_error(programs, control or Control())
    report.errors = [error for error in (read, executed) if error is not None]
    if read is not None and executed is not None and str(read) == str(executed):
        report.errors.pop()
    return report


def _reading_error(programs: Programs, control: Control) -> ControlError | None:
    try:
        for program in programs:
            for source in program.blocks:
                recognise(evaluated(read_block(source), control.variables), control.number_format)
    except ControlError as error:
        return error
    return None


def _execution_error(programs: Programs, control: Control | None, report: Report) -> ControlError | None:
    try:
        for event in execute(programs, control):
            if isinstance(event, Motion):
                report.motions += 1
                report.seconds = max(report.seconds, event.finish)
            elif isinstance(event, CycleEnd):
                report.cycles.append(event)
            elif isinstance(event, Message):
                report.messages.append(event.text)
    except ControlError as error:
        return error
    return None
