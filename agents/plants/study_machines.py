"""Machines of the study: members of every family with every program, and the model itself."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from agents.command_defaults import STUDY_MACHINES
from grind_env import examples
from grind_env.control import Programs, read
from grind_env.control.program_reader import called_files
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.loading import load_simulation
from grind_env.files import read_text
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import load_job
from grind_env.plants import find_plant
from grind_env.plants.plant_names import MODEL, PUBLIC_FAMILIES
from grind_env.toml import files_named

PARTS = 60  #: number of parts in a batch


class StudyProgram(NamedTuple):
    """Part program for one part, and its job; tables and cached files have its name."""

    name: str
    path: Path
    job: Path

    @property
    def text(self) -> str:
        return read_text(self.path)

    def read(self, text: str) -> Programs:
        return read(text, self.path.name, self.path.parent)

    @property
    def files(self) -> list[Path]:
        return [self.path, *called_files(self.path), *files_named(self.job)]


SHIPPED = (
    ("plate", examples.path("plate_g82.nc")),
    ("rail", examples.path("rail_g83.nc")),
    ("die", Path(__file__).with_name("parts") / "die_g82.nc"),
)
#: part programs of the study by their names
PROGRAMS = {name: StudyProgram(name, path, path.with_suffix(".toml")) for name, path in SHIPPED}
FAMILY_NAMES = (MODEL.name, *(each.name for each in PUBLIC_FAMILIES))
KEPT_OUT = ("bursts", "graded")  #: families on which nothing of the package was tuned


class StudyMachine(NamedTuple):
    """Machine, and the program that it grinds."""

    plant: str
    program: StudyProgram

    def __str__(self) -> str:
        return f"{self.program.name} on {self.plant}"

    @property
    def family(self) -> str:
        return self.plant.partition(":")[0]

    def job(self) -> Job:
        return load_job(self.program.job, plant=find_plant(self.plant), calibrated=False)

    def simulation(self, parts: int) -> JobSimulation:
        plant = None if self.plant == MODEL.name else self.plant
        return load_simulation(str(self.program.path), str(self.program.job), parts, 1.0, "measured", plant=plant)


def machines(
    families: Sequence[str] = FAMILY_NAMES,
    seeds: int = STUDY_MACHINES,
    programs: Sequence[StudyProgram] = tuple(PROGRAMS.values()),
) -> list[StudyMachine]:
    """Return the machines of the study: the seeds from 1 on of each family, each with every program."""
    members = {family: [f"{family}:{seed}" for seed in range(1, seeds + 1)] for family in families}
    plants = [name for family in families for name in (members | {MODEL.name: [MODEL.name]})[family]]
    return [StudyMachine(plant, program) for program in programs for plant in plants]
