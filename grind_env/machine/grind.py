"""Grind a part program: every stroke, infeed and dress that the control commands, with its physics."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

from grind_env.control import Control, Programs, execute, read_file
from grind_env.control.cli_options import interrupts_of
from grind_env.control.operator_actions import Panel
from grind_env.errors import GrindError
from grind_env.machine.job import Job, JobError
from grind_env.machine.job.job_file import job_of
from grind_env.machine.part.unsimulated_cuts import UnjudgedError
from grind_env.machine.program_run import GrindingError, GrindingRun
from grind_env.machine.record import GrindingRecord

__all__ = ["GrindingError", "grind", "grind_file", "refuse_unjudged"]


def grind(programs: Programs, job: Job, *, control: Control | None = None) -> GrindingRecord:
    """Run a part program and return its record.

    A part begins at the start of the program and after each M00, at which the operator loads the next part and touches
    off the wheel on its true surface. At M01 the operator gauges the part, which compensates the wheel wear so far. At
    both, and at the end, a wheel below its least diameter is changed if the job gives a time for it
    (`Times.wheel_change`); the price of the new wheel is not counted. A program without M00 grinds one part. A stroke
    that destroys the wheel gives a warning, and the wheel continues with its wear flats at their limit.

    Args:
        programs: result of `control.read` or `control.read_file`.
        job: part, set-up and wheel.
        control: settings of the control; those of the job's machine if None.

    Raises:
        ControlError: the program is faulty.
        DressProgramError: the dress program does not dress the wheel.
        GrindingError: the program makes no stroke or groove, or the process model has no finite numbers for one.
        JobError: the program has more parts than the job has conditions.

    Example:
        >>> from grind_env.control import read_file
        >>> from grind_env.envs.job.loading import EXAMPLE  # a part program of the package, with its job
        >>> from grind_env.machine.grind import grind
        >>> from grind_env.machine.job.job_file import load_job
        >>> record = grind(read_file(EXAMPLE), load_job(EXAMPLE.with_suffix(".toml")))
        >>> len(record.strokes), round(record.seconds, 1), round(record.cost_per_good_part, 2)  # strokes, s, $
        (29, 101.3, 2.46)
        >>> [round(Ra, 2) for Ra in record.strokes["Ra"][-3:].tolist()]  # um
        [0.26, 0.25, 0.23]
    """
    control = control or job.control
    if control.panel == Panel():  # a copy would lose what an operator set on the panel
        control = replace(control, whole_cycles=True)
    run = GrindingRun(programs, job, control)
    execution = execute(programs, run.control)
    run.tell(execution)
    for event in execution:
        run.take(event)
        run.tell(execution)
    return run.record()


def grind_file(
    program: str | Path | Programs,
    job: str | Path | Job | None = None,
    *,
    block_delete: bool = False,
    blocks: int | None = None,
    groove_retract: float | None = None,
    variables: Mapping[int, float] | None = None,
    dress_at: Sequence[float] = (),
    interrupts: Sequence[str] = (),
    plant: str | None = None,
) -> GrindingRecord:
    """Run a part program as `machine.grind` does, with the control of the job's machine, and return its record.

    Args:
        program: its file, or the result of `control.read` or `control.read_file`.
        job: its file, or the result of `load_job`; the program's name with `.toml` if None.
        block_delete: whether blocks that begin with '/' are skipped.
        blocks: most blocks and strokes to execute; the usual number if None.
        groove_retract: retract amount of G76 and G77, mm; 0.5 mm, or 0.02 in while G70 is in force, if None.
        variables: values of # variables at the start, as `{101: 15000}`; those of the job if None.
        dress_at: times at which the operator requests a dress, s on the clock of the control.
        interrupts: programs requested by the operator, as `9200@12.5`.
        plant: name of the machine, as `meter:7` (`grind_env.plants`); that of the job if None.

    Raises:
        JobError: there is no such job, or it is faulty.
        PlantError: there is no such machine.
        ControlError: the program is faulty, or an interrupt cannot be read.
        GrindError: as of `machine.grind`.
    """
    programs = program if isinstance(program, Programs) else read_file(program)
    machine = None
    if plant is not None:
        from grind_env.plants import find_plant

        machine = find_plant(plant, modules=True)
    if job is None and isinstance(program, Programs):
        raise JobError(f"no job is given for {program.name}: a text has none beside it; give one")
    settings = job_of(Path(programs.name if isinstance(program, Programs) else program), job, plant=machine)
    control = replace(
        settings.control,
        block_delete=block_delete,
        groove_retract=groove_retract,
        variables=settings.variables if variables is None else variables,
        operator_dress_at=tuple(sorted(dress_at)),
        interrupts=interrupts_of(interrupts),
    )
    return grind(programs, settings, control=control if blocks is None else replace(control, block_budget=blocks))


def refuse_unjudged(programs: Programs, job: Job) -> None:
    """Refuse a program with grinding that is not simulated; other faults of the program are left to its later run.

    A caller that counts strokes over two stations as strokes on one part would miss the `JobError`.

    Args:
        programs: result of `control.read` or `control.read_file`.
        job: part, set-up and wheel.

    Raises:
        UnjudgedError: a part of the program is not judged.
        JobError: the program has more parts than the job has conditions.
    """
    try:
        found = list(chain.from_iterable(grind(programs, job).unjudged))
    except JobError:
        raise
    except GrindError:
        return
    if found:
        raise UnjudgedError(f"{programs.name}:{found[0].lines[0]}: {found[0].why}")
