"""Parts wider than the wheel as program text: a G83 with cross picks for each."""

from collections.abc import Sequence

from grind_env.envs.blocks.program import DRESS_PROGRAM, CycleBlock, approach, number, program_of
from grind_env.envs.tasks import CROSS_FEED, Kind, Task


def crossover(task: Task, kind: Kind) -> float:
    """Z of the G83, mm: from one edge of the wheel on the edge of the part to the other one."""
    return kind.width - task.wheel.width


def block_text(task: Task, block: CycleBlock) -> str:
    """The G83 block as the control reads it."""
    overrun, kind = task.setup.overrun, block.kind
    words = (
        "G83.1" if block.pre_dress else "G83",
        f"X{number(kind.length + overrun)}",
        f"I{number(-overrun)}",
        f"Y{number(-block.stock)}",
        f"J{number(-kind.pick)}",
        f"Z{number(crossover(task, kind))}",
        f"K{number(task.cross_pick)}",
        f"L{kind.sparkout}",
        f"F{number(CROSS_FEED)}",
        f"E{number(block.speed)}",
        f"P{DRESS_PROGRAM}",
        f"D{block.executions}",
    )
    return " ".join(words)


def part_program(task: Task, blocks: Sequence[CycleBlock]) -> str:
    """A main program that grinds the parts, and the dress program."""
    start = approach(task, 0.0)
    return program_of(task, blocks, lambda block: [*start, block_text(task, block), "G80"])
