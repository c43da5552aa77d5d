"""Cells of the study, and the inputs that decide the result of a cell."""

import hashlib
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path

from agents.evaluation_cache import RUNS, sources
from agents.plants.study_machines import StudyMachine
from agents.provenance import ROOT

#: module of `agents.plants` whose `answer(machine, episodes, runs)` answers each question
QUESTIONS = {"calibrate": "power_errors", "optimise": "optimising", "advise": "advising", "robust": "robust_agent"}
#: prefixes of the modules whose code decides the results, and folder of the catalogue
DECIDING, DATA = ("agents.benchmark.agent_training", "agents.plants.", "grind_env."), ROOT / "grind_env" / "process"
#: measured time of a cell of each question on one core, h; `robust` also trains agents, for minutes each
HOURS = {"calibrate": 0.005, "optimise": 0.027, "advise": 0.001, "robust": 0.002}

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
    module = import_module(f"agents.plants.{QUESTIONS[cell.question]}")
    found: dict[str, float] = module.answer(cell.machine, cell.episodes, cell.runs)
    return found | {"cpu_seconds": time.process_time() - before}


def code(cell: PlantsTrial) -> str:
    """Return a fingerprint of the deciding code, the program, its job and the catalogue."""
    digest = hashlib.sha256(sources(f"agents.plants.{QUESTIONS[cell.question]}", DECIDING).encode())
    for path in (*cell.machine.program.files, *sorted(DATA.rglob("*.toml"))):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
