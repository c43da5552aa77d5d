"""The programs that somebody asks for: those of the study by their names, and files."""

from collections.abc import Sequence
from pathlib import Path

from agents.plants.log import DRESSED, FEEDS
from agents.plants.machines import PROGRAMS, StudyProgram
from agents.plants.variants import batch
from grind_env.errors import GrindError, did_you_mean, quoted
from grind_env.files import is_file
from grind_env.machine.job.file import job_beside, load_job


def programs_of(names: Sequence[str] | None, job: str | None) -> list[StudyProgram]:
    """Return programs by their names or files; those of the study if there are none."""
    names = list(dict.fromkeys(names or PROGRAMS))
    files = [name for name in names if name not in PROGRAMS]
    if job is not None and len(files) != 1:
        raise GrindError(f"--job is of one --program that is a file, and {len(files) or 'none'} of them are named")
    programs = [PROGRAMS[name] if name in PROGRAMS else _of_file(name, job) for name in names]
    if len({each.name for each in programs}) < len(programs):
        raise GrindError("--program: two programs have the same name; rename one, for what is kept goes by it")
    return programs


def _of_file(name: str, job: str | None) -> StudyProgram:
    path = Path(name)
    if not is_file(path):
        raise GrindError(
            f"--program is {quoted(name)}{did_you_mean(name, PROGRAMS)}: choose {', '.join(PROGRAMS)}, or name a file"
        )
    program = StudyProgram(path.stem, path.resolve(), (job_beside(path) if job is None else Path(job)).resolve())
    if load_job(program.job).uncertainty is not None:
        raise GrindError(f"{program.job.name} is calibrated, and the study does that itself: name a job that is not")
    batch(program, FEEDS, DRESSED)
    return program
