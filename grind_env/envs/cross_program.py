"""Parts wider than the wheel as program text: a G83 with cross picks for each."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from grind_env.envs.program import DRESS_PROGRAM, CycleBlock, dress_program, job, number
from grind_env.envs.tasks import Kind, Task
from grind_env.machine.job import Job

CROSS_FEED = 1500.0
"""mm/min of plunge and cross picks; the longest pick is over before the wheel is back over the part."""


def shop(task: Task) -> Job:
    """The job of its parts for `machine.grind`; a dress program is first met where the wheel is at the surface."""
    return job(task, *(replace(kind, pick=0.0) for kind in task.kinds))


def crossover(task: Task, kind: Kind) -> float:
    """Z of the G83, mm: from one edge of the wheel on the edge of the part to the other one."""
    return kind.width - task.wheel.width


def chosen_words(block: CycleBlock) -> Mapping[str, str]:
    """Numbers of the words that an action chooses, by letter; G only where the block is to be a G83.1."""
    words = {"E": number(block.speed), "D": str(block.executions)}
    return words | {"G": "83.1"} if block.pre_dress else words


def block_text(task: Task, block: CycleBlock) -> str:
    """The G83 block as the control reads it."""
    overrun, kind, chosen = task.setup.overrun, block.kind, chosen_words(block)
    words = (
        f"G{chosen.get('G', '83')}",
        f"X{number(kind.length + overrun)}",
        f"I{number(-overrun)}",
        f"Y{number(-block.stock)}",
        f"J{number(-kind.pick)}",
        f"Z{number(crossover(task, kind))}",
        f"K{number(task.cross_pick)}",
        f"L{kind.sparkout}",
        f"F{number(CROSS_FEED)}",
        f"E{chosen['E']}",
        f"P{DRESS_PROGRAM}",
        f"D{chosen['D']}",
    )
    return " ".join(words)


def part_program(task: Task, blocks: Sequence[CycleBlock]) -> str:
    """A main program that grinds the parts, M00 before each further one, and the dress program."""
    lines = [f"O0001 ({task.title.upper()})", "G71 G90 G94 G19 G40", f"S{60 * task.wheel_revolutions:.0f} M03"]
    for k, block in enumerate(blocks):
        if k > 0:
            lines.append("M00 (NEXT PART, TOUCH OFF AT Y0)")
        lines += [f"G00 X{number(-task.setup.overrun)} Y0. Z0.", block_text(task, block), "G80"]
    return "\n".join([*lines, "M30", *dress_program(task), ""])
