"""Jobs on an out-of-model machine: this machine grinds, but advice and search use the model."""

from pathlib import Path

import pytest

from grind_env import examples
from grind_env.machine.grind import grind_file
from grind_env.machine.job.job_file import load_job
from grind_env.render.record_tables import as_data as run_data
from grind_env.shop.advise.session_setup import AdviceRequest
from grind_env.shop.optimise import tables
from grind_env.shop.python_api import optimise
from grind_env.shop.sweep.study import SweepRanges, sweep
from grind_env.shop.sweep.table import as_data, sentences

pytestmark = pytest.mark.usefixtures("few_lots")

PLATE = examples.path("plate_g82.nc")
PLANT = "held-out:3"
WISHES = {"vary": ["E"], "parts": 2, "bounds": {"E": (9000, 11000)}, "budget": 60.0}


@pytest.fixture
def jobs(tmp_path: Path) -> tuple[Path, Path]:
    text = PLATE.with_suffix(".toml").read_text(encoding="utf-8")
    paths = tmp_path / "model.toml", tmp_path / "plant.toml"
    for path, head in zip(paths, ("", f'plant = "{PLANT}"\n'), strict=True):
        path.write_text(head + text, encoding="utf-8")
    assert load_job(paths[1]).plant == PLANT
    return paths


@pytest.mark.nightly
def test_a_sweep_reports_its_out_of_model_machine(jobs: tuple[Path, Path]) -> None:
    on_model, on_plant = (sweep(PLATE, job, SweepRanges(E=(14_000.0, 16_000.0)), parts=2) for job in jobs)
    sentence = f"simulated on {PLANT}, an out-of-model machine"
    assert sentence in sentences(on_plant) and as_data(on_plant)["plant"] == PLANT
    assert sentence not in sentences(on_model) and "plant" not in as_data(on_model)
    assert on_model.own.cost != on_plant.own.cost


def test_an_adviser_uses_the_model_instead_of_the_plant(jobs: tuple[Path, Path]) -> None:
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


@pytest.mark.usefixtures("coarse_speeds")
@pytest.mark.nightly
def test_optimise_searches_on_the_model_and_computes_costs_on_the_plant() -> None:
    on_model, on_plant = optimise(PLATE, **WISHES), optimise(PLATE, **WISHES, plant=PLANT)
    assert (on_model.plant, on_plant.plant) == ("", PLANT)
    assert [word.after for word in on_model.words] == [word.after for word in on_plant.words]
    assert on_model.cheapest == on_plant.cheapest
    assert on_model.quantity("cost").before != on_plant.quantity("cost").before
    for found, plant in ((on_model, None), (on_plant, PLANT)):
        record = grind_file(PLATE, plant=plant)
        cost = run_data(record, "")["cost"] / len(record.parts)
        assert found.quantity("cost").expected[0] == pytest.approx(cost, rel=1e-6)
    assert all(each.price is None for each in on_plant.limits)
    assert f"judged on {PLANT}" in tables.heading(on_plant) and tables.as_data(on_plant)["plant"] == PLANT
    assert "plant" not in tables.as_data(on_model) and "judged on" not in tables.heading(on_model)
