"""A job of a machine that is not the model: what grinds is that machine, what advises and fits holds the model."""

from pathlib import Path

import pytest

from grind_env import examples
from grind_env.machine.job.file import load_job
from grind_env.shop.advise.command import AdviceRequest
from grind_env.shop.sweep.study import SweepRanges, sweep
from grind_env.shop.sweep.table import as_data, sentences

pytestmark = pytest.mark.usefixtures("few_lots")

PLATE = examples.path("plate_g82.nc")
PLANT = "held-out:3"
TABLE = "table_speed [m/min],downfeed [um],power [W]\n8,5,900\n8,15,2100\n20,5,1500\n20,15,4200\n14,10,2300\n"


@pytest.fixture
def jobs(tmp_path: Path) -> tuple[Path, Path]:
    text = PLATE.with_suffix(".toml").read_text(encoding="utf-8")
    paths = tmp_path / "model.toml", tmp_path / "plant.toml"
    for path, head in zip(paths, ("", f'plant = "{PLANT}"\n'), strict=True):
        path.write_text(head + text, encoding="utf-8")
    assert load_job(paths[1]).plant == PLANT
    return paths


@pytest.mark.nightly
def test_a_sweep_names_the_machine_that_it_grinds_on(jobs: tuple[Path, Path]) -> None:
    on_model, on_plant = (sweep(PLATE, job, SweepRanges(E=(14_000.0, 16_000.0)), parts=2) for job in jobs)
    said = f"simulated on {PLANT}, an out-of-model machine"
    assert said in sentences(on_plant) and as_data(on_plant)["plant"] == PLANT
    assert said not in sentences(on_model) and "plant" not in as_data(on_model)
    assert on_model.own.cost != on_plant.own.cost


def test_an_adviser_holds_the_model(jobs: tuple[Path, Path]) -> None:
    advisers = []
    for job in jobs:
        request = AdviceRequest(
            program=PLATE,
            job=job,
            policy=None,
            other_part=False,
            parts=2,
            variables={},
            step=1.25,
            bounds=None,
            as_json=False,
            why=False,
        )
        advisers.append(request.adviser(request.simulation()))
    model, plant = advisers
    assert model.simulation.job.process is plant.simulation.job.process
    assert model.advice == plant.advice and model.details() == plant.details()
