"""The part program of an episode of a task, ready to run on a machine.

`machine.grind` runs this program to the same record as the episode (tests/envs/test_program_equality.py).
"""

import functools
import re
from collections.abc import Sequence
from typing import NamedTuple

from grind_env.envs.programmed_infeed import infeed_of, segments
from grind_env.envs.tasks import CROSS_FEED, DRESS_CLEARANCE, PICK_FEED, Kind, Task
from grind_env.process.stroke_types import WheelState

DRESS_PROGRAM = 9100
CLEAR = 20.0  #: height at which the wheel crosses the part, mm: the height in the dress program, above the clamps
#: characters that are left out of a comment: parentheses, which end it, and characters that a control may lack
NO_COMMENT = re.compile(r"[^A-Z0-9 ,.:/+-]")
LONGEST_COMMENT = 80
NEAR = 1.0  #: height below which the wheel comes down beside the part with a feed, mm


REQUEST = "OPERATOR ASKS FOR A DRESS"  #: comment on the dwell in which the operator's request is served


#: placeholder for the wheel of a block of which only the text is needed
NO_WHEEL = WheelState(*[0.0] * len(WheelState._fields))


class CycleBlock(NamedTuple):
    """The cycle block of one step."""

    kind: Kind
    surface: float  #: depth at which the block began, mm
    stock: float  #: depth that it had to remove, mm
    speed: float  #: E, mm/min
    executions: int = 0  #: D
    pre_dress: bool = False  #: whether the block begins with a dress (G82.1)
    wheel: WheelState = NO_WHEEL  #: wheel at the start of the block
    wheel_changes: int = 0  #: wheel changes of the episode before the block
    extra_state: tuple[float, ...] = ()  #: memory of process and gauge at the start, without the wheel
    #: time of a stroke and of the rest at its end, s; None for the times of the control
    stroke: tuple[float, float] | None = None


@functools.lru_cache(4096)
def number(value: float) -> str:
    """Return a word's number with a decimal point and at most three decimals, as the control reads it."""
    text = f"{value + 0.0:.3f}".rstrip("0")  # -0.0 is the same key of the cache as 0.0
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) and text not in ("0.", "-0.") else text


def block_text(task: Task, block: CycleBlock) -> str:
    """Return the text of a cycle block; a G81 includes its infeeds, dwells and G80, a line each."""
    overrun, kind = task.setup.overrun, block.kind
    table = f"X{number(kind.length + overrun)} I{number(-overrun)}"
    speed = f"E{number(block.speed)} P{DRESS_PROGRAM}"
    code = f"{task.cycle}.1" if block.pre_dress else task.cycle
    if task.cycle == "G81":
        return "\n".join([f"{code} {table} {speed}", *_infeeds(task, block), "G80"])
    depth = f"Y{number(-(block.surface + block.stock))} J{number(-kind.pick)}"
    if task.cycle == "G83":
        across = f"Z{number(kind.width - task.wheel.width)} K{number(task.cross_pick)} L{kind.sparkout}"
        return f"{code} {table} {depth} {across} F{number(CROSS_FEED)} {speed} D{block.executions}"
    return f"{code} {table} {depth} L{kind.sparkout + 1} F{number(PICK_FEED)} {speed} D{block.executions}"


def _infeeds(task: Task, block: CycleBlock) -> list[str]:
    """Return the infeeds of a G81 and the dwells after them, some of which ask for a dress."""
    machine, rate, stroke = task.machine, task.infeed / 60.0, task.stroke_length(block.kind)
    numbers = block.stock, block.speed, machine.reversal_dwell, float(block.executions), machine.acceleration, rate
    infeed = infeed_of(stroke, float(block.kind.sparkout), *numbers)
    if block.stroke is not None:
        infeed = infeed._replace(travel=block.stroke[0], dwell=block.stroke[1])
    lines = []
    for k, part in enumerate(segments(infeed)):
        request = f" ({REQUEST})" if k < block.executions else ""
        lines += [f"G01 Y{number(-part.end)} F{number(task.infeed)}", f"G04 X{number(part.dwell)}{request}"]
    return lines


def lines_of(task: Task, block: CycleBlock) -> list[str]:
    """Return the lines of a block and the approach before it: to the surface, for a G82 to its first pick."""
    text = block_text(task, block)
    if task.cycle != "G82":
        return [*approach(task, 0.0), text, *(["G80"] if task.cycle == "G83" else [])]
    first = min(block.surface + block.kind.pick, block.surface + block.stock)
    return [*approach(task, first), text, "G80"]


def approach(task: Task, depth: float) -> list[str]:
    """Return the lines that move the wheel from any place over the part and down beside it to a depth, mm."""
    return [
        f"G00 Y{number(CLEAR)} (CLEAR OF THE PART)",
        f"G00 X{number(-task.setup.overrun)} Z0. (BESIDE IT)",
        f"G00 Y{number(NEAR)}",
        f"G01 Y{number(0.0 - depth)} F{number(PICK_FEED)}",  # not -depth, which may be -0.0
    ]


def start_of(task: Task) -> list[str]:
    """Return the first blocks of a main program: its number, its modes, wheel and coolant on."""
    title = NO_COMMENT.sub(" ", task.title.upper())[:LONGEST_COMMENT]
    speed = f"S{60 * task.wheel_revolutions:.0f}"
    return [f"O0001 ({title})", "G71 G90 G94 G19 G40", f"{speed} M03", "M08"]


def program_of(task: Task, blocks: Sequence[CycleBlock]) -> str:
    """Return a main program with the lines of each block, M00 before each further part, and the dress program.

    Where the episode changed the wheel, the comment of the M00 or M01 tells the operator to change it.
    """
    lines = start_of(task)
    for k, block in enumerate(blocks):
        if k > 0:
            change = "CHANGE THE WHEEL, " if block.wheel_changes > blocks[k - 1].wheel_changes else ""
            if block.kind.starts_part:
                lines.append(f"M00 ({change}RETRACT, LOAD THE NEXT PART, TOUCH OFF AT Y0)")
            else:
                lines.append(f"M01 ({change}RETRACT, GAUGE THE PART)")
        lines += lines_of(task, block)
    return "\n".join([*lines, "M09", "M05", "M30", *dress_program(task), ""])


def dress_program(task: Task) -> list[str]:
    """Return a dress program of the task's passes, lead and depth: the diamond stands on the table, beside the part."""
    travel = task.wheel.width + DRESS_CLEARANCE
    lines = [
        f"O{DRESS_PROGRAM} (DRESS)",
        "G90 G94",
        f"G00 Y{number(CLEAR)} (OFF THE PART)",
        f"G00 X{number(-task.setup.overrun - 90.0)} Z{number(-travel)} (BESIDE THE DIAMOND)",
        "G00 Y10. (WHEEL FACE AT THE DIAMOND)",
    ]
    for k in range(task.dress.passes):
        lines.append(f"G91 G01 Y{number(-task.dress.depth)} F60.")
        lines.append(f"Z{number(travel if k % 2 == 0 else -travel)} F{number(60.0 * task.dress_feed)}")
    return [*lines, f"G90 G00 Y{number(CLEAR)}", "M99"]
