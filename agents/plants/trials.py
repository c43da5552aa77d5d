"""Cells of the study, and the inputs that decide the result of a cell."""

import hashlib
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from statistics import mean

from agents.evaluation_cache import RUNS, sources
from agents.plants.study_machines import PARTS, StudyMachine
from agents.provenance import ROOT

QUESTIONS = {"calibrate": "power_errors", "optimise": "optimising", "advise": "advising", "robust": "robust_agent"}
"""Module of `agents.plants` that answers each question."""
DECIDING, DATA = ("agents.benchmark.agent_training", "agents.plants.", "grind_env."), ROOT / "grind_env" / "process"
"""Prefixes of the modules whose code decides the results, and folder of the catalogue."""
HOURS = {"calibrate": 0.005, "optimise": 0.027, "advise": 0.001, "robust": 0.002}
"""Measured time of a cell of each question on one core, h; `robust` also trains agents, for minutes each."""

Found = Mapping[str, float]


@dataclass(frozen=True)
class PlantsTrial:
    """Question about a machine, number of batches that judge deciders, and folder of the agents of `robust`."""

    question: str
    machine: StudyMachine
    episodes: int = 1
    runs: Path = field(default=RUNS, repr=False, compare=False)

    def __str__(self) -> str:
        return f"{self.question}: {self.machine}"


def answer(cell: PlantsTrial) -> Found:
    """Return the results of a cell, with its CPU time, s."""
    before = time.process_time()
    return dict(_answer(cell)) | {"cpu_seconds": time.process_time() - before}


def _answer(cell: PlantsTrial) -> Found:
    if cell.question == "calibrate":
        from agents.plants.power_errors import calibrate_on

        return calibrate_on(cell.machine)
    if cell.question == "optimise":
        from agents.plants.optimising import optimise_on

        return optimise_on(cell.machine)
    if cell.question == "robust":
        from agents.plants.robust_agent import robust_on

        shifts = robust_on(cell.machine, cell.runs, cell.episodes)
    else:
        from agents.plants.advising import advise_on

        shifts = advise_on(cell.machine, cell.episodes)
    from agents.plants.batch_costs import numbers_of

    simulation = cell.machine.simulation(PARTS)
    numbers = {who: [numbers_of(batch, simulation) for batch in found] for who, found in shifts.items()}
    return {f"{who}_{what}": mean(each[what] for each in of) for who, of in numbers.items() for what in of[0]}


def code(cell: PlantsTrial) -> str:
    """Return a fingerprint of the deciding code, the program, its job and the catalogue."""
    digest = hashlib.sha256(sources(f"agents.plants.{QUESTIONS[cell.question]}", DECIDING).encode())
    for path in (*cell.machine.program.files, *sorted(DATA.rglob("*.toml"))):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
