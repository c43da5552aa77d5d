"""A part program ground from its files in one call, as `grind run` does."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from grind_env.control import Programs, read_file
from grind_env.control.options import interrupts_of
from grind_env.machine.grind import grind
from grind_env.machine.job import Job, JobError
from grind_env.machine.job.file import job_beside, load_job
from grind_env.machine.record import GrindingRecord


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
    """Grind with a part program, as `machine.grind` with the control of the job's machine.

    Args:
        program: its file, or what `control.read` or `control.read_file` returned.
        job: its file, or what `load_job` returned; the program's name with `.toml` if None.
        block_delete: whether blocks that begin with '/' are skipped.
        blocks: most blocks and strokes that the program may execute; the usual number if None.
        groove_retract: retract amount of G76 and G77, mm; 0.5 mm, or 0.02 in while G70 is in force, if None.
        variables: values of # variables at the start, as `{101: 15000}`; those of the job if None.
        dress_at: when the operator asks for a dress, s on the clock of the control.
        interrupts: programs that the operator asks for in between, as `9200@12.5`.
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
    if isinstance(job, Job):
        settings = job if machine is None else job.on(machine)
    else:
        settings = load_job(_beside(program) if job is None else job, plant=machine)
    control = replace(
        settings.control,
        block_delete=block_delete,
        groove_retract=groove_retract,
        variables=settings.variables if variables is None else variables,
        operator_dress_at=tuple(sorted(dress_at)),
        interrupts=interrupts_of(interrupts),
    )
    return grind(programs, settings, control=control if blocks is None else replace(control, block_budget=blocks))


def _beside(program: str | Path | Programs) -> Path:
    if isinstance(program, Programs):
        raise JobError(f"no job is given for {program.name}: a text has none beside it; give one")
    return job_beside(Path(program))
