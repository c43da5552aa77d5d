"""Promised and true cost of optimised programs on a machine, with and without a calibration."""

import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from agents.plants.program_variants import with_catalogue, write
from agents.plants.shop_log import logged
from agents.plants.study_machines import StudyMachine, StudyProgram
from grind_env.control import Programs, read_file
from grind_env.errors import GrindError
from grind_env.machine.job import Job
from grind_env.machine.job.uncertainty import CERTAIN
from grind_env.shop.calibrate.log_calibration import calibrate
from grind_env.shop.optimise.optimisation import find_words
from grind_env.shop.optimise.result import Optimised
from grind_env.shop.possible_machines import CondemnedError
from grind_env.shop.trials import LotUse, lots_of, trials_of

#: number of parts in a batch, number of lots that judge it, and time of a search, s
PARTS, LOTS, SECONDS = 30, 64, 25.0
JUDGES = 7  #: seed of the lots that judge; no search uses this seed


def real(programs: Programs, job: Job) -> tuple[float, float]:
    """Return the cost of a part, $, and the share of scrap of a batch on a machine."""
    trials = trials_of(programs, job, PARTS, lots_of(JUDGES, LotUse.JUDGEMENT, LOTS))
    found = trials.measure(trials.own[None])
    return float(found.cost.mean()), float(found.scrap.mean())


def answer(machine: StudyMachine, *_: object) -> dict[str, float]:
    """Return promised and true costs of the search: without a calibration, with one, and with the true model."""
    truth, found = machine.job(), dict[str, float]()
    found["original"], found["original_scrap"] = real(read_file(machine.program.path), truth)
    with tempfile.TemporaryDirectory() as folder:
        catalogue = calibrated(machine, Path(folder))
        plain = _judged(uncalibrated(machine.program), machine, truth)
        # a refused calibration leaves the machine without one
        fitted = plain if catalogue is None else _searched(machine, catalogue, truth)
    known = _searched(machine, replace(truth, uncertainty=CERTAIN), truth)
    for way, searched in (("uncalibrated", plain), ("calibrated", fitted), ("known", known)):
        found |= {f"{way}_{what}": value for what, value in searched.items()}
    found["refused"] = float(catalogue is None)
    return found


def calibrated(machine: StudyMachine, folder: Path) -> Path | None:
    """Return the job with the result of a calibration on a log of the machine; None if the log was refused."""
    files = logged(machine, folder)
    try:
        calibrate(files.log, files.program, files.job, gauge=files.gauge).write(folder / "machine.toml")
    except GrindError:
        return None
    return write(folder / "job.toml", with_catalogue(files.job, folder / "machine.toml"))


@cache
def uncalibrated(program: StudyProgram) -> Optimised:
    """Return the result without a calibration, which is equal for all machines."""
    return find_words(program.path, program.job, parts=PARTS, seconds=SECONDS)


def _searched(machine: StudyMachine, job: Path | Job, truth: Job) -> dict[str, float]:
    """Return the judged result of a search; a program that the model condemns stays unchanged."""
    try:
        found = find_words(machine.program.path, job, parts=PARTS, seconds=SECONDS)
    except CondemnedError:
        cost, scrap = real(read_file(machine.program.path), truth)
        return {"cost": cost, "scrap": scrap, "promised": cost, "low": cost, "high": cost, "changed": 0.0}
    return _judged(found, machine, truth)


def _judged(found: Optimised, machine: StudyMachine, truth: Job) -> dict[str, float]:
    cost, scrap = real(machine.program.read(found.after), truth)
    promise = promised(found)
    return {
        "cost": cost,
        "scrap": scrap,
        "promised": promise[1],
        "low": promise[0],
        "high": promise[2],
        "changed": float(np.mean([word.changed for word in found.words])),
    }


def promised(found: Optimised) -> tuple[float, float, float]:
    """Return the lower end, the mean and the upper end of the promised cost, $."""
    cost = found.quantity("cost")
    after = cost.after if found.after != found.before else cost.before
    return after.low, after.value, after.high
