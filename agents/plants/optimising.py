"""What a search promises on a machine, calibrated or not, and what its words come to there."""

import tempfile
from pathlib import Path

import numpy as np

from agents.plants.log import write_gauge, write_log
from agents.plants.machines import Machine
from agents.plants.variants import batch, write
from grind_env.control import Programs, read, read_file
from grind_env.errors import GrindError
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.plants import find_plant
from grind_env.shop.calibrate.calibration import calibrate
from grind_env.shop.optimise.finding import find_words
from grind_env.shop.optimise.outcome import Optimised
from grind_env.shop.trials import LotUse, lots_of, trials_of

PARTS, LOTS, SECONDS = 30, 64, 10.0
"""Parts of a batch, lots that it is judged on, and s of a search."""
JUDGES = 7
"""Seed of these lots, which no search has."""
FEEDS = (1.0, 1.0, 0.8, 1.2, 1.0, 0.9, 1.1, 1.0)
DRESSED = (True, False, False, True, False, False, True, False)
"""E, over that of the program, and dresses of the parts in the log."""


def real(programs: Programs, job: Job) -> tuple[float, float]:
    """Cost of a part, $, and share of scrap of a batch on a machine."""
    trials = trials_of(programs, job, PARTS, lots_of(JUDGES, LotUse.JUDGEMENT, LOTS))
    found = trials.measure(trials.own[None])
    return float(found.cost.mean()), float(found.scrap.mean())


def optimise_on(machine: Machine, seconds: float = SECONDS) -> dict[str, float]:
    """What the search promises and what comes of it: without a calibration, with one, and with the machine as model."""
    truth, found = machine.job(), dict[str, float]()
    found["original"], found["original_scrap"] = real(read_file(machine.path), truth)
    with tempfile.TemporaryDirectory() as folder:
        catalogue = calibrated(machine, Path(folder))
        ways = {"uncalibrated": machine.path.with_suffix(".toml"), "calibrated": catalogue}
        for way, job in ways.items():
            if job is not None:
                found |= {f"{way}_{what}": value for what, value in _searched(machine, job, truth, seconds).items()}
    return found


def calibrated(machine: Machine, folder: Path) -> Path | None:
    """The job with what a calibration has found by a log of the machine; None if it refused."""
    truth, job = machine.job(), machine.path.with_suffix(".toml")
    program = write(folder / "batch.nc", batch(machine.path.read_text(encoding="utf-8"), FEEDS, DRESSED))
    record = grind(read_file(program), truth)
    log, gauge = folder / "log.csv", folder / "gauge.csv"
    write_log(log, record, truth, find_plant(machine.plant), 1)
    write_gauge(gauge, record, truth, 2)
    try:
        calibrate(log, program, job, gauge=gauge).write(folder / "machine.toml")
    except GrindError:
        return None
    text = job.read_text(encoding="utf-8") + '\n[catalogue]\nfiles = ["machine.toml"]\n'
    return write(folder / "job.toml", text)


def _searched(machine: Machine, job: Path, truth: Job, seconds: float) -> dict[str, float]:
    found = find_words(machine.path, job, parts=PARTS, seconds=seconds)
    cost, scrap = real(read(found.after, machine.path.name, machine.path.parent), truth)
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
    """Lower end, mean and upper end of the cost that is promised, $."""
    cost = found.quantity("cost")
    after = cost.after if found.after != found.before else cost.before
    return after.low, after.value, after.high
