"""The study of machines that are not the model: its machines, what it is compared with, what is kept, what is asked."""

import json
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from agents.__main__ import main
from agents.plants import study
from agents.plants.floor import Law, strokes_of
from agents.plants.log import over_the_part
from agents.plants.machines import FAMILY_NAMES, PROGRAMS, Machine, machines
from agents.plants.optimising import real
from agents.plants.page import csv_text, page
from agents.plants.plans import plans
from agents.plants.regression import Cuts, fitted, predicted
from agents.plants.shift import Choice, ground
from agents.plants.study import Cell, Request, find, run_study
from agents.plants.variants import batch, scaled
from agents.plants.verdicts import promises
from grind_env.control import read, read_file
from grind_env.machine.grind import grind

PLATE = Machine("model", "plate")


def test_machines_are_all_families_with_all_programs() -> None:
    found = machines(seeds=2)
    assert len({*found}) == len(found) == len(PROGRAMS) * (1 + 2 * (len(FAMILY_NAMES) - 1))
    assert all(each.path.with_suffix(".toml").exists() for each in found)


@pytest.mark.parametrize("program", PROGRAMS)
def test_other_words_say_other_strokes(program: str) -> None:
    machine = Machine("model", program)
    text, job = machine.path.read_text(), machine.job()
    own, other = (grind(read(each, "a.nc"), job).strokes for each in (text, scaled(text, 0.5, 1.0)))
    np.testing.assert_allclose(other["E"], 0.5 * own["E"])
    deeper = grind(read(scaled(text, 1.0, 2.0), "a.nc"), job).strokes
    assert len(deeper) < len(own) and deeper["Z"].max() == own["Z"].max()
    assert not grind(read(scaled(text, dressed=False), "a.nc"), job).dresses.size


def test_a_batch_is_its_parts_one_after_the_other() -> None:
    text, job = PLATE.path.read_text(), PLATE.job()
    whole = grind(read(batch(text, (1.0, 0.8), (True, False)), "a.nc"), job)
    first = grind(read(text, "a.nc"), job)
    assert len(whole.parts) == 2 and len(whole.dresses) == 1
    count = len(first.strokes)
    np.testing.assert_array_equal(whole.strokes["ae"][:count], first.strokes["ae"])
    np.testing.assert_allclose(whole.strokes["E"][count:], 0.8 * first.strokes["E"])


def test_a_log_has_every_stroke_for_as_long_as_the_wheel_is_over_the_part_and_a_pause_at_every_stop() -> None:
    text = PLATE.path.read_text()
    strokes = grind(read(text, "a.nc"), PLATE.job()).strokes
    begins, ends = over_the_part(grind(read(text, "a.nc"), PLATE.job()), text)
    np.testing.assert_allclose(ends - begins, 60.0 * 200.0 / strokes["E"])
    assert (begins[1:] > ends[:-1]).all()
    gap = np.diff(begins) - np.diff(strokes["time"])
    assert gap[np.flatnonzero(np.diff(strokes["line"]))[-1]] == pytest.approx(8.0, abs=0.5)  # at the M01


def test_the_regression_finds_a_power_law() -> None:
    rng = np.random.default_rng(1)
    cuts = Cuts(*(rng.uniform(low, high, 60) for low, high in ((0.002, 0.02), (100, 400), (0, 400), (5, 25))))
    power = cuts.b * 300.0 * cuts.a**0.7 * cuts.v**0.5 * (cuts.V + 10.0) ** 0.1
    np.testing.assert_allclose(fitted(cuts, power)[1:], [0.7, 0.5, 0.1], atol=0.01)
    np.testing.assert_allclose(predicted(fitted(cuts, power), cuts), power, rtol=0.02)


def test_the_adviser_without_a_model_learns_a_power_law() -> None:
    law, rng = Law(), np.random.default_rng(2)
    for _ in range(200):
        speed, volume = rng.uniform(5000, 25000), rng.uniform(0, 500)
        law.learn(speed, volume, 2.0 * speed**0.6 * (volume + 10.0) ** 0.2)
    assert law.speed(2.0 * 12000**0.6 * 110**0.2, 100.0) == pytest.approx(12000, rel=0.01)


def test_strokes_are_those_of_the_program() -> None:
    strokes = grind(read_file(PLATE.path), PLATE.job()).strokes
    _, counts = np.unique(strokes["line"], return_counts=True)
    np.testing.assert_array_equal(strokes_of(PLATE.simulation(2)), [*counts, *counts])


def test_a_shift_costs_what_the_same_program_costs() -> None:
    """The own words on lots without end are in the mean what trials of the same program say."""
    simulation = PLATE.simulation(30)
    shifts = [
        ground(
            simulation, lambda k, _: Choice(simulation.blocks[k].plan.feed, int(simulation.blocks[k].plan.dresses)), s
        )
        for s in range(4)
    ]
    assert np.mean([shift.mean_cost for shift in shifts]) == pytest.approx(
        real(read_file(PLATE.path), PLATE.job())[0], rel=0.01
    )


def test_plans_dress_as_often_as_they_say() -> None:
    simulation = PLATE.simulation(8)
    dresses = [ground(simulation, plan).executions.sum() for plan in plans(simulation)]
    assert dresses == [8.0, 4.0, 2.0] * 5


def test_what_is_found_is_kept_with_the_code_that_found_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[Cell] = []

    def answer(cell: Cell) -> dict[str, float]:
        calls.append(cell)
        return {"adviser_cost": 1.0}

    monkeypatch.setattr(study, "_answer", answer)
    cell, request = Cell("advise", PLATE), Request(runs=tmp_path)
    first = find(cell, request, lambda done: None)
    assert find(cell, request, lambda done: None) == first and len(calls) == 1
    path = tmp_path / cell.files[0]
    path.write_text(json.dumps(json.loads(path.read_text()) | {"code": "another"}))
    find(cell, request, lambda done: None)
    assert len(calls) == 2


def test_the_tables_tell_what_is_asked_and_whether_it_holds(tmp_path: Path) -> None:
    kept = {"adviser_cost": 1.0, "floor_cost": 1.0, "plan_cost": 1.0, "adviser_scrap": 0.0, "adviser_in_a_row": 0.0}
    missed = kept | {"adviser_cost": 2.0, "adviser_scrap": 0.5}
    others = [Machine("meter:1", "plate"), Machine("soft:1", "plate")]
    good, bad = (
        {
            each.what: each.kept
            for _, each in promises({Cell("advise", others[0]): kept, Cell("advise", others[1]): last})
        }
        for last in (kept, missed)
    )
    assert all(good.values()) and not bad["scrap, worst machine, %"] and not bad["the same, worst machine"]
    found = {Cell("advise", others[0]): kept, Cell("advise", others[1]): missed}
    assert "| soft | 1 |" in page(found) and "NO" in page(found)
    assert csv_text(found).count("\n") == 1 + len(kept) + len(missed)


def test_a_family_that_there_is_not_is_named(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["agents", "plants", "--family", "metre"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2 and "did you mean meter" in capsys.readouterr().err.lower()


def test_a_study_in_processes_is_kept(tmp_path: Path) -> None:
    cells = run_study([PLATE], ["advise"], jobs=1, console=Console(quiet=True), runs=tmp_path)
    (found,) = cells.values()
    assert found["adviser_cost"] < found["program_cost"]
    assert (tmp_path / "plants/advise/plate-model.json").exists()
