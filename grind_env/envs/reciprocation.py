"""The task of `grind/Reciprocation-v0`: PowerLimited's plates with the literal G81, and its blocks as program text."""

from collections.abc import Sequence
from dataclasses import replace

from grind_env.control import Control, Motion, Programs, Source, execute
from grind_env.control.rules import motion_time
from grind_env.envs.program import DRESS_PROGRAM, CycleBlock, dress_program, job, number
from grind_env.envs.tasks import Kind, Task, read_task
from grind_env.machine.job import Job
from grind_env.machine.reciprocation import Feeding, segments

TASK = "reciprocation"
"""Name of its task file."""

INFEED = read_task(TASK).infeed
"""mm/min, of `grind/Reciprocation-v0`."""

REQUEST = "OPERATOR ASKS FOR A DRESS"
"""Comment on the dwell in which the operator's request is served."""


def shop(task: Task) -> Job:
    """The job of its parts for `machine.grind`; a dress sets out from the surface, where the infeed begins."""
    return job(task, *(replace(kind, pick=0.0) for kind in task.kinds))


def feeding(task: Task, kind: Kind, stock: float, speed: float, executions: float, pre_dress: float) -> Feeding:
    """The block that grinds `stock` mm with E `speed` (mm/min), D `executions` and perhaps a pre-dress (1)."""
    machine, dress = task.machine, task.dress
    return Feeding(
        speed=speed / 60.0,
        travel=motion_time(kind.length + 2.0 * task.setup.overrun, speed / 60.0, machine.acceleration),
        dwell=machine.reversal_dwell,
        infeed=task.infeed / 60.0,
        acceleration=machine.acceleration,
        target=stock,
        requests=executions,
        pre_dress=pre_dress,
        sparkout=kind.sparkout + 1.0,
        width=kind.width,
        length=kind.length,
        dress_passes=float(dress.passes),
        dress_feed=task.dress_feed,
        dress_depth=dress.depth,
        dress_seconds=task.dress_seconds,
    )


def block_text(task: Task, block: CycleBlock) -> str:
    """The blocks of one step as the control reads them, a line each: G81 or G81.1, infeeds and dwells, G80."""
    overrun, kind = task.setup.overrun, block.kind
    numbers = feeding(task, kind, block.stock, block.speed, float(block.executions), float(block.pre_dress))
    words = f"X{number(kind.length + overrun)} I{number(-overrun)} E{number(block.speed)} P{DRESS_PROGRAM}"
    lines = [f"{'G81.1' if block.pre_dress else 'G81'} {words}"]
    for k, part in enumerate(segments(numbers)):
        request = f" ({REQUEST})" if k < block.executions else ""
        lines += [f"G01 Y{number(-part.end)} F{number(task.infeed)}", f"G04 X{number(part.dwell)}{request}"]
    return "\n".join([*lines, "G80"])


def part_program(task: Task, blocks: Sequence[CycleBlock]) -> str:
    """A main program that runs the blocks, M00 before each further part, and the dress program.

    The operator asks for a dress at the start of each dwell that says so; `request_times` tells when that is.
    """
    lines = [f"O0001 ({task.title.upper()})", "G71 G90 G94 G19 G40", f"S{60 * task.wheel_revolutions:.0f} M03"]
    for k, block in enumerate(blocks):
        if k > 0:
            lines.append("M00 (NEXT PART, TOUCH OFF AT Y0)")
        lines += [f"G00 X{number(-task.setup.overrun)} Y0.", block_text(task, block)]
    return "\n".join([*lines, "M30", *dress_program(task), ""])


def request_times(programs: Programs, control: Control) -> tuple[float, ...]:
    """Times of the control, s, at which the operator asks for a dress; for `Control.operator_dress_at`.

    A request is made when the last motion or dwell before the dwell that says so has ended.
    """
    ahead, before = set(), 0
    for source in programs.main.blocks:
        if REQUEST in source.text:
            ahead.add(before)
        if source.text.startswith("G04") or " Y" in source.text:
            before = source.line
    control, times = replace(control), []
    for event in execute(programs, control):
        if isinstance(event, Motion) and event.source is Source.PROGRAM and event.line in ahead:
            control.request_dress()
            # just after it, not in the same moment, in which the table may turn
            times.append(event.finish + 1e-6)
    return tuple(times)
