"""Load a part program and its job from files."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from grind_env import examples
from grind_env.control import read_file
from grind_env.envs.arguments import check_file, check_number, check_parts, is_full
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.repeated_program import MOST_PARTS, batch_name, repeated
from grind_env.envs.plant_options import plants_of
from grind_env.errors import GrindError
from grind_env.files import beside
from grind_env.machine.job import JobError
from grind_env.machine.job.job_file import load_job

MOST_SPREAD = 2.0  #: highest factor on all that is random

EXAMPLE = examples.path("plate_g82.nc")  #: default program of the environment


def load_simulation(
    program: str | None,
    job: str | None,
    parts: int,
    spread: float,
    observation: str,
    variables: Mapping[int, float] = {},
    plant: str | None = None,
) -> JobSimulation:
    """Return the simulation of a program file; arguments as for `envs.ids.job.make`, but `variables` by number."""
    check_file("program", program)
    check_file("job", job)
    check_number("spread", spread, 0.0, MOST_SPREAD)
    check_parts(parts, MOST_PARTS)
    full = is_full(observation)
    path = EXAMPLE if program is None else Path(program)
    programs = read_file(path)
    batch = repeated(programs, parts, variables)
    plants = plants_of(plant)
    loaded = load_job(beside(path, ".toml") if job is None else job, plant=None if plants is None else plants.first)
    settings, plants = replace(loaded, variables=variables), plants or plants_of(None, loaded.plant)
    if settings.parts:
        message = "the job says how each part differs, but here lots and stocks are drawn; leave [[parts]] out of it"
        raise JobError(message, "parts")
    file = "" if path.resolve().parent == EXAMPLE.parent.resolve() else str(path)
    try:
        return JobSimulation(
            batch, settings, spread, full=full, name=batch_name(path, parts), file=file, plants=plants, once=programs
        )
    except GrindError:
        JobSimulation(programs, settings, spread)  # its error names the line of the file, not of the batch
        raise
