"""Commands of a shop at a foreign machine."""

import json
from pathlib import Path
from typing import Any, NamedTuple

from grind_env.envs.job.loading import load_simulation
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.operator_readings import MachineReadings
from tests.foreign.shop import Block, Part, Shop, cost, depths_of, grind, run, shift, trace

EFFORT = "--parts", "1", "--budget", "150 programs", "--json"
CALIBRATED = '[catalogue]\nfiles = ["fit.toml"]\n'


def ground_cost(shop: Shop, program: Path, job: Path) -> float:
    """Return the cost of a part on the machine in eight lots, $."""
    motions = trace(program, job)
    return cost(shop, [part for seed in range(8) for part in run(shop, shop.machine(300 + seed), motions)]).each


class Optimised(NamedTuple):
    """True and promised costs before and after `grind optimise`, $ a part."""

    before: float  #: cost on the machine with the program as it is
    after: float  #: cost on the machine with the better program, if there is one
    low: float  #: lower end of the promised interval
    high: float


def optimised(shop: Shop, folder: Path, job: Path, seed: int = 1) -> Optimised | None:
    """Return the costs, or None if the model condemns the program and nothing is written."""
    lot, better = folder / "lot.nc", folder / "better.nc"
    better.unlink(missing_ok=True)
    done = grind("optimise", lot, "--job", job, *EFFORT, "--seed", seed, "-o", better)
    if done.stderr.startswith("grind: The model says this program scraps "):
        assert done.returncode == 3 and not better.exists() and not done.stdout
        return None
    assert done.returncode in (0, 3, 4), done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    before = ground_cost(shop, lot, folder / "job.toml")
    after = ground_cost(shop, better, folder / "job.toml") if better.exists() else before
    (promised,) = (each for each in found["quantities"] if each["name"] == "cost")
    said = promised["after" if better.exists() else "before"]
    return Optimised(before, after, said["low"], said["high"])


def calibrated(folder: Path, job: Path, *options: str) -> Path | None:
    """Return a job with the fit of the machine's log, or None if the fit is refused."""
    fit = folder / "fit.toml"
    words = "--program", folder / "varied.nc", "--job", job, "--gauge", folder / "gauge.csv", "-o", fit
    grind("calibrate", folder / "log.csv", *words, *options)
    if not fit.exists():
        return None
    fitted = folder / "calibrated.toml"
    fitted.write_text(job.read_text() + CALIBRATED)
    return fitted


def advised_shift(shop: Shop, folder: Path, job: Path, seed: int) -> list[Part]:
    """Grind a shift with the advice of the default adviser."""
    simulation = load_simulation(str(folder / "one.nc"), str(job), 30, 1.0, "measured")
    adviser = Adviser(simulation, policy_for(None, simulation))

    def decide(number: int, readings: Any) -> Block:
        if readings:
            adviser.take(MachineReadings(**{name: float(value) for name, value in readings.items()}))
        assert adviser.advice is not None
        return Block(adviser.advice.speed, adviser.advice.executions)

    return shift(shop, depths_of(folder / "one.nc", folder / "job.toml"), decide, seed)
