"""The cells of the study, and what decides what is found in one."""

import ast
import hashlib
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from statistics import mean

from agents.cells import RUNS, bare
from agents.plants.machines import StudyMachine
from agents.provenance import ROOT

QUESTIONS = {"calibrate": "calibrating", "optimise": "optimising", "advise": "advising", "robust": "robust"}
"""With the module of `agents.plants` that answers it."""
DECIDING, DATA = ("agents.benchmark.agents", "agents.plants.", "grind_env."), ROOT / "grind_env" / "process"
"""Where the code lies that decides what is found, of all that such a module stands on; folder of the catalogue."""
HOURS = {"calibrate": 0.005, "optimise": 0.027, "advise": 0.001, "robust": 0.002}
"""That a cell of a question takes on one core, by measurement; trainings, of minutes, come to those of robust."""

Found = Mapping[str, float]


@dataclass(frozen=True)
class PlantsTrial:
    """A question about a machine, the batches that judge who decides, and the folder of the agents of `robust`."""

    question: str
    machine: StudyMachine
    episodes: int = 1
    runs: Path = field(default=RUNS, repr=False, compare=False)

    def __str__(self) -> str:
        return f"{self.question}: {self.machine}"


def answer(cell: PlantsTrial) -> Found:
    """Return what is found in a cell."""
    before = time.process_time()
    return dict(_answer(cell)) | {"cpu_seconds": time.process_time() - before}


def _answer(cell: PlantsTrial) -> Found:
    if cell.question == "calibrate":
        from agents.plants.calibrating import calibrate_on

        return calibrate_on(cell.machine)
    if cell.question == "optimise":
        from agents.plants.optimising import optimise_on

        return optimise_on(cell.machine)
    if cell.question == "robust":
        from agents.plants.robust import robust_on

        shifts = robust_on(cell.machine, cell.runs, cell.episodes)
    else:
        from agents.plants.advising import advise_on

        shifts = advise_on(cell.machine, cell.episodes)
    numbers = {who: [batch.numbers() for batch in found] for who, found in shifts.items()}
    return {f"{who}_{what}": mean(each[what] for each in of) for who, of in numbers.items() for what in of[0]}


def code(cell: PlantsTrial) -> str:
    """Stands for the code that decides what is found, and for the program, its job and the catalogue."""
    digest = hashlib.sha256(_code_of(f"agents.plants.{QUESTIONS[cell.question]}").encode())
    for path in (*cell.machine.program.files, *sorted(DATA.rglob("*.toml"))):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def _code_of(module: str) -> str:
    """Hash of the code that a module stands on, its own among it."""
    digest = hashlib.sha256()
    for path in sorted(_stands_on(module)):
        digest.update(bare(path.read_text(encoding="utf-8")).encode())
    return digest.hexdigest()


def _stands_on(module: str) -> set[Path]:
    """Files of the modules that a module imports, and that these import, anywhere in them."""
    found, waiting = dict[str, Path | None](), [module]
    while waiting:
        name = waiting.pop()
        if name in found or not name.startswith(DECIDING):
            continue
        path = found[name] = _file_of(name)
        for node in ast.walk(ast.parse("" if path is None else path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module is not None:
                waiting += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return {path for path in found.values() if path is not None}


def _file_of(module: str) -> Path | None:
    """File of a module; None of a name in one."""
    path = ROOT.joinpath(*module.split("."))
    return next((file for file in (path.with_suffix(".py"), path / "__init__.py") if file.exists()), None)
