"""Check of a part program: every block is read, the program is executed, and errors or effects are reported."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

from grind_env.control.block_decoding import recognise
from grind_env.control.block_words import read_block
from grind_env.control.control_settings import Control
from grind_env.control.errors import ControlError
from grind_env.control.events import CycleEnd, Message, Motion, Stroke
from grind_env.control.program_execution import execute
from grind_env.control.program_reader import Programs
from grind_env.control.trace_records import error_record
from grind_env.control.word_evaluation import foreseen

#: most errors of reading that are reported: a file that is no part program may have one in each line
MOST_ERRORS = 1000


@dataclass(slots=True)
class Report:
    """Findings of a check."""

    programs: int = 0  #: number of programs read
    blocks: int = 0  #: number of blocks in them
    motions: int = 0  #: number of motions
    seconds: float = 0.0  #: time of the execution, s; with a job the time of the parts, loading and dresses included
    cycles: list[CycleEnd] = field(default_factory=list)  #: every cycle executed, with its strokes and dresses
    between: int = 0  #: strokes of the table after a G82 or G83, until the next cycle or G80
    messages: list[str] = field(default_factory=list)  #: messages of the control to the operator
    #: with a job, parts of the program without the expected effect on its machine
    warnings: list[str] = field(default_factory=list)
    #: every error of reading (at most `MOST_ERRORS`), and the error that ended the execution, by place
    errors: list[ControlError] = field(default_factory=list)
    stopped: ControlError | None = None  #: error that ended the execution; None if it reached the end or did not start
    executed: bool = True  #: whether the program was executed; False for faulty program names


def check(programs: Programs, control: Control | None = None, faults: Sequence[ControlError] = ()) -> Report:
    r"""Execute the main program and read every block, including those that are not reached.

    Args:
        programs: the programs of a file.
        control: settings of the control; the defaults if None.
        faults: errors in program names, from `read_file`; with any, the program is not executed.

    Example:
        >>> from grind_env.control import check, read
        >>> program = "G71 G94 G90 G19 F60. E12000.\nG00 X-30. Y0\nG82 X230. I-30. Y-.04 J-.01 L2\nM30"
        >>> report = check(read(program))
        >>> report.errors, round(report.seconds, 2)
        ([], 10.85)
    """
    report = Report(executed=not faults)
    if report.executed:
        report.stopped = _execution_error(programs, control, report)
    for program in programs:
        report.programs += 1
        report.blocks += len(program.blocks)
    # an error of reading may also have ended the execution: it is reported once
    ended = [] if report.stopped is None else [report.stopped]
    read = islice(_reading_errors(programs, control or Control()), MOST_ERRORS)
    found = {str(error): error for error in (*read, *faults, *ended)}
    report.errors = sorted(
        found.values(), key=lambda error: (error.file != programs.name, error.file, error.line or 0, error.column or 0)
    )
    return report


def ended_at(report: Report) -> str:
    """Return a sentence on where the execution has ended, if there are further errors; else an empty text."""
    error = report.stopped
    if len(report.errors) < 2:
        return ""
    if not report.executed:
        return "the program was not executed; check it again once its program names are mended"
    if error is None:
        return ""
    return f"the program was not executed further than {error.file}:{error.line}; check it again once that is mended"


def _reading_errors(programs: Programs, control: Control) -> Iterator[ControlError]:
    for program in programs:
        try:
            for source in program.blocks:
                try:
                    recognise(foreseen(read_block(source)), control.number_format)
                except ControlError as error:
                    yield error
        except ControlError as error:
            yield error


def _execution_error(programs: Programs, control: Control | None, report: Report) -> ControlError | None:
    try:
        for event in execute(programs, control):
            if isinstance(event, Motion):
                report.motions += 1
                report.seconds = max(report.seconds, event.finish)
                if isinstance(event, Stroke) and event.number is None and event.cycle.plunges:
                    report.between += 1
            elif isinstance(event, CycleEnd):
                report.cycles.append(event)
            elif isinstance(event, Message):
                report.messages.append(event.text)
    except ControlError as error:
        return error
    return None


def report_record(report: Report, file: str) -> dict[str, Any]:
    """Return a report on a file in JSON types."""
    return {
        "programs": report.programs,
        "blocks": report.blocks,
        "motions": report.motions,
        "seconds": report.seconds,
        "cycles": [
            {
                "code": cycle.plan.code + (".1" if cycle.plan.pre_dress else ""),
                "block": cycle.plan.block,
                "line": cycle.plan.line,
                "strokes": cycle.strokes,
                "dresses": cycle.dresses,
            }
            for cycle in report.cycles
        ],
        "strokes_between": report.between,
        "messages": report.messages,
        "warnings": report.warnings,
        "errors": [error_record(error, file) for error in report.errors],
        "stopped": None if report.stopped is None else error_record(report.stopped, file),
    }


def summary(report: Report) -> str:
    """Return a report without errors as text: a line for the whole, and one for each cycle."""
    lines = [
        f"{_count(report.programs, 'program')}, {_count(report.blocks, 'block')}, "
        f"{_count(report.motions, 'motion')}, {report.seconds:.2f} s"
    ]
    lines += [
        f"line {cycle.plan.line}: {cycle.plan.code}{'.1' if cycle.plan.pre_dress else ''}, "
        f"{_count(cycle.strokes, 'stroke')}, {_count(cycle.dresses, 'dress', 'dresses')}"
        for cycle in report.cycles
    ]
    if report.between:
        lines.append(f"{_count(report.between, 'stroke')} between cycles, for the table goes on")
    told = [f"warning: {warning}" for warning in report.warnings] or report.messages  # warnings include the messages
    return "\n".join(lines + told)


def _count(number: int, singular: str, plural: str = "") -> str:
    return f"{number} {singular if number == 1 else plural or singular + 's'}"
