"""The machines of the study: members of every family, each with every program, and the machine that is the model."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from agents.budgets import STUDY_MACHINES
from grind_env import examples
from grind_env.envs.job.loading import load_simulation
from grind_env.envs.job.simulation import JobSimulation
from grind_env.machine.job import Job
from grind_env.machine.job.file import load_job
from grind_env.plants import FAMILIES, find_plant
from grind_env.plants.names import MODEL

PROGRAMS = {
    "plate": examples.path("plate_g82.nc"),
    "rail": examples.path("rail_g83.nc"),
    "die": Path(__file__).with_name("parts") / "die_g82.nc",
}
"""Part programs by their names in tables; each has its job beside it."""
FAMILY_NAMES = (MODEL.name, *(each.name for each in FAMILIES))
KEPT_OUT = ("bursts", "graded")
"""Families on which nothing of the package was tuned."""


class Machine(NamedTuple):
    """A machine, and the program that it grinds."""

    plant: str
    program: str

    def __str__(self) -> str:
        return f"{self.program} on {self.plant}"

    @property
    def family(self) -> str:
        """Name of the family."""
        return self.plant.partition(":")[0]

    @property
    def path(self) -> Path:
        """File of the program."""
        return PROGRAMS[self.program]

    def job(self) -> Job:
        """What is ground on it."""
        return load_job(self.path.with_suffix(".toml"), plant=find_plant(self.plant))

    def simulation(self, parts: int) -> JobSimulation:
        """Episodes of so many parts on it."""
        plant = None if self.plant == MODEL.name else self.plant
        return load_simulation(str(self.path), None, parts, 1.0, "measured", plant=plant)


def machines(
    families: Sequence[str] = FAMILY_NAMES, seeds: int = STUDY_MACHINES, programs: Sequence[str] = tuple(PROGRAMS)
) -> list[Machine]:
    """The machines of the study: of each family those with the seeds from 1, each with every program."""
    plants = [name for family in families for name in _members(family, seeds)]
    return [Machine(plant, program) for program in programs for plant in plants]


def _members(family: str, seeds: int) -> list[str]:
    return [family] if family == MODEL.name else [f"{family}:{seed}" for seed in range(1, seeds + 1)]
