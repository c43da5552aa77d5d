"""What `grind optimise` makes of machines that are not the model: never a dearer program than the one at hand."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.foreign.shop import SHOPS, Shop, cost, grind, run, trace

EFFORT = "--parts", "5", "--seed", "1", "--budget", "150 programs", "--json"
CALIBRATED = '[catalogue]\nfiles = ["fit.toml"]\n'


def ground(shop: Shop, program: Path, job: Path) -> float:
    """Return what a part costs on the machine, $, in eight lots."""
    motions = trace(program, job)
    return cost(shop, [part for seed in range(8) for part in run(shop, shop.machine(300 + seed), motions)]).each


def optimised(shop: Shop, folder: Path, job: Path) -> dict[str, Any] | None:
    """Return what was found, and hold what it promises against the machine; None if the model condemns the program."""
    lot, better = folder / "lot.nc", folder / "better.nc"
    done = grind("optimise", lot, "--job", job, *EFFORT, "-o", better)
    if done.stderr.startswith("grind: The model says this program scraps "):
        assert done.returncode == 3 and not better.exists() and not done.stdout
        return None
    assert done.returncode in (0, 3, 4), done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    before = ground(shop, lot, folder / "job.toml")
    after = ground(shop, better, folder / "job.toml") if better.exists() else before
    (promised,) = (each for each in found["quantities"] if each["name"] == "cost")
    said = promised["after" if better.exists() else "before"]
    assert after <= before
    assert said["low"] <= after <= said["high"]
    return found


@pytest.mark.nightly
@pytest.mark.parametrize("shop", SHOPS.values(), ids=SHOPS)
def test_a_program_is_never_dearer_on_a_machine_that_is_not_the_model(shop: Shop, tmp_path: Path) -> None:
    """Not calibrated, and with a fit that is forced, however wrong it is."""
    job = shop.write(tmp_path)
    optimised(shop, tmp_path, job)
    words = "--program", tmp_path / "varied.nc", "--job", job, "--gauge", tmp_path / "gauge.csv"
    grind("calibrate", tmp_path / "log.csv", *words, "-o", tmp_path / "fit.toml", "--force")
    calibrated = tmp_path / "calibrated.toml"
    calibrated.write_text(job.read_text() + CALIBRATED)
    optimised(shop, tmp_path, calibrated)


def test_a_model_that_scraps_what_a_machine_grinds_well_stops(tmp_path: Path) -> None:
    """The catalogue scraps every part of Werner's machine, whose parts are good."""
    shop = SHOPS["Werner"]
    job = shop.write(tmp_path)
    assert optimised(shop, tmp_path, job) is None
