"""An episode as a part program: the blocks that an engineer could carry to the machine.

Interpreting that program with `machine.grind` gives the record that the agent's episode was made of
(tests/envs/test_program_equality.py).
"""

import functools
import itertools
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.belief.hidden import FACTORS
from grind_env.control import Motion, ProgramEnd, Programs, ProgramStop, Source, execute, read
from grind_env.control.cycles import RULES
from grind_env.envs.episodes import Episodes
from grind_env.envs.feed_motions import infeed_of, segments
from grind_env.envs.history import History
from grind_env.envs.tape import SPARE_FACTORS, TapeRow
from grind_env.envs.tasks import CROSS_FEED, DRESS_CLEARANCE, PICK_FEED, Kind, Task, TaskError
from grind_env.errors import quoted
from grind_env.machine.dress.program import run_dress
from grind_env.machine.job import Job, Part, PartConditions, Setup, Stage, Times
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.run import GrindingRun
from grind_env.process.state import WheelState
from grind_env.process.tables import wrong

DRESS_PROGRAM = 9100
RECIPROCATING_AXIS = 0
WHEEL_CHANGES, SURFACE = History._fields.index("wheel_changes"), PartState._fields.index("Z")
KIND, STOCK = TapeRow._fields.index("kind"), TapeRow._fields.index("stock")
CLEAR = 20.0
"""mm; where the wheel crosses the part: as high as in the dress program, and above what clamps it."""
NO_COMMENT = re.compile(r"[^A-Z0-9 ,.:/+-]")
"""What is left out of a comment: parentheses, which end it, and what a control may not have."""
LONGEST_COMMENT = 80
NEAR = 1.0
"""mm; from here on the wheel comes down beside the part with a feed."""


REQUEST = "OPERATOR ASKS FOR A DRESS"
"""Comment on the dwell in which the operator's request is served."""


NO_WHEEL = WheelState(*[0.0] * len(WheelState._fields))
"""Of a block of which the text alone counts."""


class CycleBlock(NamedTuple):
    """The cycle block of one step."""

    kind: Kind
    surface: float
    """Depth at which the block began, mm."""
    stock: float
    """Depth that it had to remove, mm."""
    speed: float
    """E, mm/min."""
    executions: int = 0
    """D."""
    pre_dress: bool = False
    """Whether the block begins with a dress (G82.1)."""
    wheel: WheelState = NO_WHEEL
    """With which it began."""
    wheel_changes: int = 0
    """Wheel changes of the episode before the block."""
    own: tuple[float, ...] = ()
    """What process and gauge remembered besides the wheel as it began."""
    stroke: tuple[float, float] | None = None
    """Time of a stroke and of the rest at its end, s; None where they are those of the control."""


@functools.lru_cache(4096)
def number(value: float) -> str:
    """A word's number with a decimal point and at most three decimals, as the control reads it."""
    text = f"{value + 0.0:.3f}".rstrip("0")  # -0.0 is the same key of the cache as 0.0
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) and text not in ("0.", "-0.") else text


def coming_block(
    task: Task, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0
) -> CycleBlock:
    """The block that episode i runs next with E `speed` (mm/min), D `executions` and perhaps a pre-dress (1)."""
    row = episodes.row(i)
    kind, stock = task.kinds[int(row[KIND])], float(row[STOCK])
    surface = 0.0 if kind.starts_part else float(episodes.parts[i, SURFACE])
    (wheel, own), changes = episodes.wheel_and_own(i), int(episodes.memory[i, WHEEL_CHANGES])
    return CycleBlock(kind, surface, stock, float(speed), int(executions), pre_dress > 0.0, wheel, changes, own)


def block_text(task: Task, block: CycleBlock) -> str:
    """The cycle block as the control reads it, of a G81 with its infeeds, dwells and G80, a line each."""
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
    """The infeeds of a G81 and the dwells after them, some of which ask for a dress."""
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
    """A block as part of a program; the wheel sets out from the surface, of a G82 from the depth of its first pick."""
    text = block_text(task, block)
    if task.cycle != "G82":
        return [*approach(task, 0.0), text, *(["G80"] if task.cycle == "G83" else [])]
    first = min(block.surface + block.kind.pick, block.surface + block.stock)
    return [*approach(task, first), text, "G80"]


def approach(task: Task, depth: float) -> list[str]:
    """Over the part and down beside it to a depth, mm, from wherever the operator has left the wheel."""
    return [
        f"G00 Y{number(CLEAR)} (CLEAR OF THE PART)",
        f"G00 X{number(-task.setup.overrun)} Z0. (BESIDE IT)",
        f"G00 Y{number(NEAR)}",
        f"G01 Y{number(0.0 - depth)} F{number(PICK_FEED)}",  # not -depth, which may be -0.0
    ]


def start_of(task: Task) -> list[str]:
    """The first blocks of a main program: its number, its modes, wheel and coolant on."""
    title = NO_COMMENT.sub(" ", task.title.upper())[:LONGEST_COMMENT]
    speed = f"S{60 * task.wheel_revolutions:.0f}"
    return [f"O0001 ({title})", "G71 G90 G94 G19 G40", f"{speed} M03", "M08"]


def program_of(task: Task, blocks: Sequence[CycleBlock]) -> str:
    """A main program of the lines of each block, M00 before each further part, and the dress program.

    Where the episode changed the wheel, the operator does so at that M00 or M01.
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
    """A dress program of the task's passes, lead and depth: the diamond stands on the table, beside the part."""
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


def check_task(task: Task, cycle: str | None = None) -> None:
    """Check that the program of a task can be run, and that its blocks have the cycle asked for; None asks for none."""
    try:
        job(task, task.kinds[0])
        for kind in task.kinds:
            if not kind.starts_part:
                _check_gauging(task, kind)
    except TaskError as error:
        raise TaskError(error.message, error.key, error.found, error.legal, task.file) from None
    if cycle is None:
        return
    if not isinstance(cycle, str) or cycle not in RULES:
        raise TaskError(f"cycle is {quoted(cycle)}, but must be one of {', '.join(RULES)}")
    if cycle != task.cycle:
        raise TaskError(f"cycle is {cycle!r}, but the blocks of {task.name} are {task.cycle}: leave it out")


def _check_gauging(task: Task, kind: Kind) -> None:
    """Refuse a time to gauge a part that is over before the wheel is back, from its farther end, on the whole depth."""
    depth = sum(each.stock for each in task.kinds)
    there = f"G00 X{number(kind.length + task.setup.overrun)} Y{number(-depth)} Z0."
    way = "\n".join([*start_of(task), there, "M01", *approach(task, depth), "M30"])
    events = execute(read(way), job(task, kind).control)
    began, ended = (event.time for event in events if isinstance(event, ProgramStop | ProgramEnd))
    least = ended - began
    if task.setup.gauge < least:
        raise wrong("setup.gauge", task.setup.gauge, f"at least {least:.1f} s, which the way takes", TaskError)


def job(task: Task, *kinds: Kind, first: float | None = None) -> Job:
    """The job of parts that are ground in blocks of these kinds, one after the other, for `machine.grind`.

    Parts of other kinds have theirs in their `conditions`. The dress set-up time is what the task counts for a dress
    beyond the motions of the dress program, which the wheel first meets `first` mm deep, or else where the first block
    begins to cut.
    """
    setup = Setup(
        wheel=task.wheel,
        dresser=task.dresser,
        fluid=task.fluid,
        machine=task.machine,
        wheel_speed=task.setup.wheel_speed,
    )
    change = None if task.wheel_change is None else task.wheel_change.seconds
    times = Times(load=task.setup.load, gauge=task.setup.gauge, dress_setup=0.0, wheel_change=change)
    part = part_of(task, kinds, [kind.stock for kind in kinds], kinds[-1].material)
    bare = Job(part=part, setup=setup, times=times)
    depth = min(kinds[0].pick, kinds[0].stock) if first is None else first
    position = (-task.setup.overrun, -depth, 0.0)
    programs = read("\n".join(["M30", *dress_program(task)]))
    motions = run_dress(programs, DRESS_PROGRAM, bare, bare.control, position, RECIPROCATING_AXIS).plan
    beyond = task.dress_seconds - motions.seconds
    if beyond < 0.0:
        least = task.dress.setup - beyond
        raise wrong("dress.setup", task.dress.setup, f"at least {least:.1f} s, which its way takes", TaskError)
    return replace(bare, times=replace(times, dress_setup=beyond))


def job_of(task: Task, blocks: Sequence[CycleBlock]) -> Job:
    """The job of a program of these blocks, for nominal parts; the kinds of the first part give it its own."""
    if task.cycle != "G82":
        return job(task, *task.kinds, first=0.0)
    first = next((k for k, block in enumerate(blocks) if block.kind.ends_part), len(blocks) - 1)
    return job(task, *(block.kind for block in blocks[: first + 1]))


def part_of(task: Task, kinds: Sequence[Kind], stocks: Sequence[float], material: str) -> Part:
    """A part that is ground in blocks of these kinds, each a stage of its own, which take these stocks, mm, off it."""
    kind, depths = kinds[-1], list(itertools.accumulate(stocks))
    stages = tuple(
        Stage(
            stock=depth,
            roughness_limit=earlier.roughness_limit,
            tolerance=earlier.tolerance,
            rise_allowance=earlier.rise_allowance,
        )
        for earlier, depth in zip(kinds[:-1], depths, strict=False)
    )
    return Part(
        material=task.catalogue.material(material),
        length=kind.length,
        width=kind.width,
        height=kind.height,
        stock=depths[-1],
        roughness_limit=kind.roughness_limit,
        tolerance=kind.tolerance,
        scrap_cost=kind.scrap,
        rise_allowance=kind.rise_allowance,
        stages=stages,
    )


def conditions(task: Task, tape: NDArray[np.float64]) -> list[PartConditions]:
    """What each part of an episode was like; `tape` has shape (blocks, fields of `TapeRow`)."""
    parts: list[list[TapeRow]] = []
    for row in (TapeRow(*values) for values in tape.tolist()):
        if task.kinds[int(row.kind)].starts_part:
            parts.append([])
        parts[-1].append(row)
    return [
        PartConditions(
            part=part_of(
                task,
                [task.kinds[int(row.kind)] for row in rows],
                [row.stock for row in rows],
                task.materials[int(rows[0].material)],
            ),
            factors=_factors(task, rows[0], FACTORS),
            new_wheel_factors=_factors(task, rows[0], SPARE_FACTORS) if task.wheel_change else None,
        )
        for rows in parts
    ]


def _factors(task: Task, row: TapeRow, fields: tuple[str, ...]) -> dict[str, float]:
    """Factors on the stroke parameters `FACTORS`, from these fields of the tape, with those fixed in the task."""
    drawn = {name: getattr(row, field) for name, field in zip(FACTORS, fields, strict=True)}
    return {**task.factors, **{name: value * task.factors.get(name, 1.0) for name, value in drawn.items()}}


def request_times(programs: Programs, job: Job) -> tuple[float, ...]:
    """Times of the control, s, at which the operator asks for a dress; for `Control.operator_dress_at`.

    A request is made when the last motion or dwell before the dwell that says so has ended.
    """
    ahead, before = set(), 0
    for source in programs.main.blocks:
        if REQUEST in source.text:
            ahead.add(before)
        if source.text.startswith("G04") or " Y" in source.text:
            before = source.line
    if not ahead:
        return ()
    control, times = replace(job.control), []
    execution = execute(programs, control)
    run = None if job.process.before is None else GrindingRun(programs, job, control)
    for event in execution:
        if run is not None:  # the table has a speed of its own
            run.take(event)
            run.tell(execution)
        if isinstance(event, Motion) and event.source is Source.PROGRAM and event.line in ahead:
            control.request_dress()
            # just after it, not in the same moment, in which the table may turn
            times.append(event.finish + 1e-6)
    return tuple(times)
