"""The strokes of an episode of `grind/Stroke-v0` as program text; `rules` says how the program keeps pace."""

from collections.abc import Sequence
from typing import NamedTuple

from grind_env.envs.blocks.program import DRESS_PROGRAM, approach, end_of, next_part, number, start_of
from grind_env.envs.blocks.requests import REQUEST
from grind_env.envs.strokes.episodes import StrokeEpisodes
from grind_env.envs.strokes.rules import Pace, TableRun, depth_of, last_dwell, next_turn, pick_before, setting_out
from grind_env.envs.strokes.step import StrokeMemory
from grind_env.envs.tape import TapeRow
from grind_env.envs.tasks import Kind, Task
from grind_env.process.process import Drive
from grind_env.process.state import WheelState

MADE, STOCK = StrokeMemory._fields.index("made"), TapeRow._fields.index("stock")
DRIVE = [StrokeMemory._fields.index(name) for name in Drive._fields]


class StrokeBlock(NamedTuple):
    """One stroke, and what the program does before it."""

    kind: Kind
    part: int
    """Number of its part, from 0."""
    stock: float
    """Of that part, mm."""
    stroke: int
    """Its number on the part, from 0."""
    speed: float
    """E, mm/min."""
    executions: int
    """D, 1 for a dress before it."""
    before: Pace
    """In the stroke before it; of the first on a part it says nothing."""
    drive: Drive
    """What the table makes of its commands on the part, once its first stroke has shown it."""
    wheel: WheelState
    """With which it began."""
    own: tuple[float, ...]
    """What process and gauge remembered besides."""


def coming_stroke(task: Task, episodes: StrokeEpisodes, i: int, speed: float, executions: float) -> StrokeBlock:
    """The stroke that episode i makes next with E `speed` (mm/min) and D `executions`."""
    made, part, pace = int(episodes.strokes[i, MADE]), int(episodes.block[i]), Pace(*episodes.paces[i].tolist())
    stock, state = float(episodes.row(i)[STOCK]), episodes.wheel_and_own(i)
    drive = Drive(*episodes.strokes[i, DRIVE].tolist()) if made else Drive(1.0, task.machine.reversal_dwell)
    return StrokeBlock(task.kinds[0], part, stock, made, float(speed), int(executions), pace, drive, *state)


def block_text(task: Task, block: StrokeBlock) -> str:
    """What the control reads for a stroke, a line each; for the last one on a part up to G80."""
    lines, pace = _up_to(task, block)
    if block.stroke + 1 == task.strokes(block.kind, block.stock):
        lines += _stop(task, block, pace)
    return "\n".join(lines)


def part_program(task: Task, blocks: Sequence[StrokeBlock]) -> str:
    """A main program of the strokes, the last of which is in progress at its end, and the dress program.

    The operator asks for a dress at the start of each dwell that says so; `blocks.requests` tells when
    that is.
    """
    lines = [block_text(task, block) for block in blocks]
    if blocks and lines[-1].splitlines()[-1] != "G80":
        lines += _stop(task, blocks[-1], _up_to(task, blocks[-1])[1])
    return "\n".join([*start_of(task), *lines, *end_of(task)])


def _up_to(task: Task, block: StrokeBlock) -> tuple[list[str], Pace]:
    """The lines that lead to a stroke, and the pace in it."""
    kind, dress = block.kind, block.executions > 0
    depth = depth_of(block.stroke, block.stock, kind.pick)
    if block.stroke == 0:
        overrun = task.setup.overrun
        words = f"X{number(kind.length + overrun)} I{number(-overrun)} E{number(block.speed)} P{DRESS_PROGRAM}"
        load = [next_part()] if block.part > 0 else []
        return [*load, *approach(task, depth), f"{'G81.1' if dress else 'G81'} {words}"], setting_out(
            block.drive.share * block.speed
        )
    pick = pick_before(block.stroke, block.stock, kind.pick)
    turn = next_turn(table_of(task, block.drive), block.before, pick, block.drive.share * block.speed, dress)
    down = f"Y{number(-depth)} " if pick > 0.0 else ""
    lines = [f"G04 X{number(turn.dwell)}", f"G01 {down}E{number(block.speed)}"]
    if dress:
        lines.append(f"G04 X{number(turn.request)} ({REQUEST})")
    return lines, turn.pace


def _stop(task: Task, block: StrokeBlock, pace: Pace) -> list[str]:
    return [f"G04 X{number(last_dwell(table_of(task, block.drive), pace))}", "G80"]


def table_of(task: Task, drive: Drive) -> TableRun:
    """How the table of a task goes."""
    return TableRun(task.stroke_length(task.kinds[0]), task.machine.acceleration, drive.dwell)
