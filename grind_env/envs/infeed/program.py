"""Parts that are ground with a continuous infeed as program text: a G81, infeeds and dwells for each."""

from collections.abc import Sequence

from grind_env.envs.blocks.program import DRESS_PROGRAM, CycleBlock, approach, number, program_of
from grind_env.envs.blocks.requests import REQUEST
from grind_env.envs.infeed.infeed import Infeed, segments
from grind_env.envs.infeed.step import infeed_of
from grind_env.envs.tables import KindRow, kind_row
from grind_env.envs.tasks import Task


def infeed_of_block(task: Task, block: CycleBlock) -> Infeed:
    """The infeed of a block as the compiled step has it."""
    machine, kind = task.machine, KindRow(*map(float, kind_row(task, block.kind)))
    dwell, requests = machine.reversal_dwell, float(block.executions)
    infeed = infeed_of(kind, block.stock, block.speed, dwell, requests, machine.acceleration, task.infeed / 60.0)
    return infeed if block.stroke is None else infeed._replace(travel=block.stroke[0], dwell=block.stroke[1])


def block_text(task: Task, block: CycleBlock) -> str:
    """The blocks of one step as the control reads them, a line each: G81 or G81.1, infeeds and dwells, G80."""
    overrun, kind = task.setup.overrun, block.kind
    words = f"X{number(kind.length + overrun)} I{number(-overrun)} E{number(block.speed)} P{DRESS_PROGRAM}"
    lines = [f"{'G81.1' if block.pre_dress else 'G81'} {words}"]
    for k, part in enumerate(segments(infeed_of_block(task, block))):
        request = f" ({REQUEST})" if k < block.executions else ""
        lines += [f"G01 Y{number(-part.end)} F{number(task.infeed)}", f"G04 X{number(part.dwell)}{request}"]
    return "\n".join([*lines, "G80"])


def part_program(task: Task, blocks: Sequence[CycleBlock]) -> str:
    """A main program that runs the blocks, and the dress program.

    The operator asks for a dress at the start of each dwell that says so: see `blocks.requests`.
    """
    start = approach(task, 0.0)
    return program_of(task, blocks, lambda block: [*start, block_text(task, block)])
