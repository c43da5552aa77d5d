"""The job of a task: machine, parts and set-up as `machine.grind` takes them."""

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grind_env.belief.filter_quantities import FACTORS
from grind_env.control import ProgramEnd, ProgramStop, execute, read
from grind_env.control.cycles import RULES
from grind_env.envs.blocks.task_program import DRESS_PROGRAM, CycleBlock, approach, dress_program, number, start_of
from grind_env.envs.noise_tape import SPARE_FACTORS, TapeRow
from grind_env.envs.tasks import Kind, Task, TaskError
from grind_env.machine.dress.dress_run import run_dress
from grind_env.machine.job import Job, Part, PartConditions, Setup, Stage, Times
from grind_env.message_text import quoted
from grind_env.process.toml_tables import wrong

RECIPROCATING_AXIS = 0


def check_task(task: Task, cycle: str | None = None) -> None:
    """Check that the program of a task can be run, and that its blocks have this cycle; None accepts any cycle."""
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
    """Refuse a gauging time shorter than the way of the wheel off the far end of the part and back to full depth."""
    depth = sum(each.stock for each in task.kinds)
    there = f"G00 X{number(kind.length + task.setup.overrun)} Y{number(-depth)} Z0."
    way = "\n".join([*start_of(task), there, "M01", *approach(task, depth), "M30"])
    events = execute(read(way), job(task, kind).control)
    began, ended = (event.time for event in events if isinstance(event, ProgramStop | ProgramEnd))
    least = ended - began
    if task.setup.gauge < least:
        raise wrong("setup.gauge", task.setup.gauge, f"at least {least:.1f} s, which the way takes", TaskError)


def job(task: Task, *kinds: Kind, first: float | None = None) -> Job:
    """Return the job, for `machine.grind`, of parts that are ground in blocks of these kinds in turn.

    Parts of other kinds are in `conditions`. The dress set-up time is the task's dress time less the motions of the
    dress program. The first dress begins `first` mm deep; by default, where the first block begins to cut.
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
    """Return the job of a program of these blocks, for nominal parts; its part is made from the kinds of part 1."""
    if task.cycle != "G82":
        return job(task, *task.kinds, first=0.0)
    first = next((k for k, block in enumerate(blocks) if block.kind.ends_part), len(blocks) - 1)
    return job(task, *(block.kind for block in blocks[: first + 1]))


def part_of(task: Task, kinds: Sequence[Kind], stocks: Sequence[float], material: str) -> Part:
    """Return a part with one stage for each block of these kinds; each block removes its stock, mm."""
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
    """Return the conditions of each part of an episode; `tape` has shape (blocks, fields of `TapeRow`)."""
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
    """Return factors on stroke parameters: `FACTORS` from these fields of the tape, times fixed factors of the task."""
    drawn = {name: getattr(row, field) for name, field in zip(FACTORS, fields, strict=True)}
    return {**task.factors, **{name: value * task.factors.get(name, 1.0) for name, value in drawn.items()}}
