"""A part program run on the machine: every stroke, infeed and dress that the control commands, with its physics."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

from grind_env.control import Control, Programs, execute
from grind_env.control.operator import Panel
from grind_env.errors import GrindError
from grind_env.machine.job import Job, JobError, PartConditions
from grind_env.machine.part.unjudged import UnjudgedError
from grind_env.machine.record import GrindingRecord
from grind_env.machine.run import GrindingError, GrindingRun

__all__ = ["GrindingError", "grind", "refuse_unjudged"]


def grind(
    programs: Programs,
    job: Job,
    *,
    control: Control | None = None,
    conditions: Sequence[PartConditions] = (),
) -> GrindingRecord:
    """Run a part program.

    A part begins at the start of the program and after each M00, where the operator loads the next one: the
    wheel is touched off on its true surface. At M01 the operator gauges the part, so that the wheel wear so
    far is compensated. At either, and at the end, a wheel below its least diameter is changed if the job gives the
    time for it (`Times.wheel_change`); what the new wheel costs is not counted. A program without M00 grinds one part.
    A stroke that destroys the wheel is warned of, and the wheel goes on with its wear flats at their limit.

    Args:
        programs: what `control.read` or `control.read_file` returned.
        job: part, set-up and wheel.
        control: settings of the control; those of the job's machine if None.
        conditions: how each part differs from the job, one per part; those of the job if there are none.

    Raises:
        ControlError: the program is faulty.
        DressProgramError: the dress program does not dress the wheel.
        GrindingError: the program makes no stroke or groove, or the process model has no finite numbers for one.
        JobError: there are more parts than conditions.

    Example:
        >>> from grind_env.control import read_file
        >>> from grind_env.envs.job.loading import EXAMPLE  # a part program of the package, with its job
        >>> from grind_env.machine.grind import grind
        >>> from grind_env.machine.job.file import load_job
        >>> record = grind(read_file(EXAMPLE), load_job(EXAMPLE.with_suffix(".toml")))
        >>> len(record.strokes), round(record.seconds, 1), round(record.cost_per_good_part, 2)  # strokes, s, $
        (29, 101.3, 2.46)
        >>> [round(Ra, 2) for Ra in record.strokes["Ra"][-3:].tolist()]  # um
        [0.26, 0.25, 0.23]
    """
    control, conditions = control or job.control, conditions or job.parts
    if control.panel == Panel():  # one that an operator has touched goes with its control
        control = replace(control, whole_cycles=True)
    run = GrindingRun(programs, job, control, conditions)
    execution = execute(programs, run.control)
    run.tell(execution)
    for event in execution:
        run.take(event)
        run.tell(execution)
    return run.record()


def refuse_unjudged(programs: Programs, job: Job) -> None:
    """Refuse a program that grinds what is not simulated; faults of the program are for those who grind with it.

    Who takes strokes for one part that meet two stations counts fewer parts, and would find conditions enough.

    Args:
        programs: what `control.read` or `control.read_file` returned.
        job: part, set-up and wheel.

    Raises:
        UnjudgedError: a part of it is not judged.
        JobError: there are more parts than conditions.
    """
    try:
        found = list(chain.from_iterable(grind(programs, job).unjudged))
    except JobError:
        raise
    except GrindError:
        return
    if found:
        raise UnjudgedError(f"{programs.name}:{found[0].lines[0]}: {found[0].why}")
