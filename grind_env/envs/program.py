"""An episode as a part program: the blocks that an engineer could carry to the machine.

Interpreting that program with `machine.grind` gives the record that the agent's episode was made of
(tests/envs/test_program.py).
"""

from collections.abc import Sequence
from typing import NamedTuple

from grind_env.envs.tasks import DRESS_CLEARANCE, Kind, Task

DRESS_PROGRAM = 9100
PICK_FEED = 60.0
"""mm/min; a pick is over long before the wheel is back at the middle of the part."""


class Block(NamedTuple):
    """A cycle block that was run."""

    kind: Kind
    surface: float
    """Depth at which the block began, mm."""
    stock: float
    """Depth that it had to remove, mm."""
    speed: float
    """E, mm/min."""
    executions: int
    """D."""


def number(value: float) -> str:
    """A word's number with a decimal point and at most three decimals, as the control reads it."""
    text = f"{value:.3f}".rstrip("0")
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) and text not in ("0.", "-0.") else text


def cycle_block(task: Task, block: Block) -> str:
    """The G82 block."""
    overrun, kind = task.setup.overrun, block.kind
    words = (
        f"X{number(kind.length + overrun)}",
        f"I{number(-overrun)}",
        f"Y{number(-(block.surface + block.stock))}",
        f"J{number(-kind.pick)}",
        f"L{kind.sparkout + 1}",
        f"F{number(PICK_FEED)}",
        f"E{number(block.speed)}",
        f"P{DRESS_PROGRAM}",
        f"D{block.executions}",
    )
    return "G82 " + " ".join(words)


def part_program(task: Task, blocks: Sequence[Block]) -> str:
    """A main program that runs the blocks, M00 before each further part, and the dress program."""
    lines = ["O0001 (" + task.title.upper() + ")", "G71 G90 G94 G19 G40", f"S{60 * task.wheel_revolutions:.0f} M03"]
    for k, block in enumerate(blocks):
        if block.kind.starts_part and k > 0:
            lines.append("M00 (NEXT PART, TOUCH OFF AT Y0)")
        first = min(block.surface + block.kind.pick, block.surface + block.stock)
        lines += [
            f"G00 X{number(-task.setup.overrun)} Y{number(-first)}",
            cycle_block(task, block),
            "G80",
        ]
    return "\n".join([*lines, "M30", *dress_program(task), ""])


def dress_program(task: Task) -> list[str]:
    """A dress program of the task's passes, lead and depth, for a dresser above the table."""
    travel = task.wheel.width + DRESS_CLEARANCE
    lines = [f"O{DRESS_PROGRAM} (DRESS)", "G91 G01"]
    for k in range(task.dress.passes):
        lines.append(f"Y{number(-task.dress.depth)} F100.")
        lines.append(f"Z{number(travel if k % 2 == 0 else -travel)} F{number(60.0 * task.dress_feed)}")
    return [*lines, "M99"]
