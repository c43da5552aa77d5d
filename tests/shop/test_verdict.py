"""Verdict on the use of a fit: worked by hand, on tables of settings, and on out-of-model machines."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from grind_env.cli import app
from grind_env.control import read_file
from grind_env.machine.grind import grind
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.process.catalogue import load_catalogue
from grind_env.shop.calibrate.least_squares import Data
from grind_env.shop.calibrate.log_calibration import calibrate
from grind_env.shop.calibrate.verdict import FitJudgement, judge
from grind_env.validation.rig import Rig
from tests.foreign.shop import SHOPS, Shop, run, trace
from tests.shop.blemished import PLAIN, write_gauge, write_log
from tests.shop.coverage import EXAMPLES

PLATE = EXAMPLES / "plate_g82.nc"


def judge_kind(kind: str, value: list[float], nominal: list[float], held_out: list[float]) -> FitJudgement:
    """Return the judgement of a fit to one kind of measurement, one value per part."""
    count = len(value)
    measured, before, after = np.array([value, nominal, held_out], np.float64)
    data = Data(measured, np.zeros(count), np.full(count, kind, "U10"), np.arange(1, count + 1))
    return judge(data, np.ones(count, np.bool_), before, after, after)


def test_errors_are_absolute_for_size_relative_for_Ra_and_probabilities_for_burn() -> None:
    found = judge_kind("size", [1.0, 2.0, 3.0], [2.0, 3.0, 4.0], [4.0, 5.0, 6.0])
    assert found.errors["size"] == pytest.approx((3, 1.0, 3.0)) and found.worse == ("size",)
    found = judge_kind("Ra", [0.2, 0.2], [0.4, 0.4], [0.2, 0.2])
    assert found.errors["Ra"] == pytest.approx((2, np.log(2.0), 0.0)) and not found.worse
    found = judge_kind("burn", [0.0, 0.0], [-3.0, -3.0], [3.0, 3.0])
    assert found.errors["burn"][1:] == pytest.approx((1.0 / (1.0 + np.exp(3.0)), 1.0 / (1.0 + np.exp(-3.0))))
    assert found.worse == ("burn",)
    assert judge_kind("burn", [0.0, 0.0], [-9.0, -9.0], [-2.0, -2.0]).worse == ()  # neither model expects burn


def test_one_outlying_part_does_not_make_a_fit_worse() -> None:
    assert judge_kind("size", [0.0] * 4, [3.0] * 4, [0.0, 0.0, 0.0, 7.0]).worse == ()
    assert judge_kind("size", [0.0] * 4, [3.0] * 4, [5.0] * 4).worse == ("size",)


def test_a_deviation_within_the_measuring_error_does_not_make_a_fit_worse() -> None:
    data = Data(np.array([2.0]), np.array([2.0]), np.array(["size"]), np.array([1]))
    for off, worse in ((3.0, ()), (24.0, ("size",))):
        fit = np.array([2.0 + off])
        assert judge(data, np.ones(1, np.bool_), np.array([3.5]), fit, fit).worse == worse


def test_the_verdict_names_the_uses_of_the_fit() -> None:
    errors = {"power": (9, 0.2, 0.02), "size": (3, 4.0, 1.0)}
    found = FitJudgement(errors, errors, ()).verdict(tells_nothing=False)
    assert (found.level, found.uses) == ("good", ("E and dressing", "size"))
    assert found.headline == "Use the fit for E and dressing, size; not for roughness, burn, wheel wear (not measured)."
    kept = FitJudgement(errors, errors, (), kept=("size",)).verdict(tells_nothing=False)
    assert kept.uses == ("E and dressing",) and "for size the constants of the catalogue stay" in kept.headline
    assert FitJudgement(errors, None, ()).verdict(tells_nothing=False).level == "poor"
    assert FitJudgement(errors, errors, ("size",)).verdict(tells_nothing=False).level == "bad"
    assert FitJudgement(errors, errors, ()).verdict(tells_nothing=True).level == "bad"


def test_a_kind_the_model_does_not_follow_keeps_its_catalogue_constants(tmp_path: Path) -> None:
    lines = ["table_speed [m/min];downfeed [um];volume;Ft [N/mm];Ra [um]"]
    for k, (speed, feed) in enumerate((speed, feed) for speed in (8, 14, 20) for feed in (5, 15)):
        rig = Rig(load_catalogue()).fresh(
            table_speed=speed * 1000 / 60, downfeed=feed / 1000, changes={"material": {"chip_energy": 18.0}}
        )
        done = rig.grind_volume(40.0)
        lines.append(f"{speed};{feed};40;{done.Ft:.4f};{done.Ra * (3.0 if k == 2 else 0.85):.4f}")
    (tmp_path / "table.csv").write_text("\n".join(lines), encoding="utf-8")
    words = ["calibrate", str(tmp_path / "table.csv"), "--job", str(PLATE.with_suffix(".toml")), "--json"]
    result = CliRunner().invoke(app, [*words, "-o", str(tmp_path / "shop.toml")])
    found = json.loads(result.stdout)
    assert result.exit_code == 0 and found["verdict"]["kept"] == ["Ra"]
    written = (tmp_path / "shop.toml").read_text()
    assert "chip_energy" in written and "roughness =" not in written
    assert "roughness" not in found["verdict"]["uses"]


def test_the_heat_factor_is_found_from_gauged_parts(tmp_path: Path) -> None:
    job = load_job(PLATE.with_suffix(".toml"))
    truth = with_entries(job, {"material": {"heat_factor": 0.3, "chip_energy": 20.0}})
    rng = np.random.default_rng(4)
    record = write_log(tmp_path / "log.csv", read_file(PLATE), truth, 4, PLAIN, rng)
    write_gauge(tmp_path / "parts.csv", record, rng, filled=1.0)
    found = calibrate(tmp_path / "log.csv", PLATE, PLATE.with_suffix(".toml"), gauge=tmp_path / "parts.csv")
    heat = next(each for each in found.estimates if each.parameter.key == "heat_factor")
    assert heat.determined and heat.low < 0.3 < heat.high < 1.0
    assert found.verdict.level == "good"


@pytest.mark.nightly
@pytest.mark.parametrize("shop", SHOPS.values(), ids=SHOPS)
def test_a_fit_predicts_new_parts_of_a_foreign_machine_better_than_the_catalogue(shop: Shop, tmp_path: Path) -> None:
    job = shop.write(tmp_path)
    found = calibrate(tmp_path / "log.csv", tmp_path / "varied.nc", job, gauge=tmp_path / "gauge.csv")
    assert found.verdict.level == "good" and not found.judged.worse
    parts = list(run(shop, shop.machine(7), trace(tmp_path / "varied.nc", job)))
    program = read_file(tmp_path / "varied.nc")
    size, Ra = (np.array([getattr(part, name) for part in parts]) for name in ("size", "Ra"))
    fit, catalogue = (grind(program, each).parts for each in (found.fitted, found.job))
    assert np.abs(fit["size_error"] - size).mean() < np.abs(catalogue["size_error"] - size).mean()
    assert np.abs(np.log(fit["Ra"] / Ra)).mean() < np.abs(np.log(catalogue["Ra"] / Ra)).mean()
    assert fit["survival"].min() > 0.9 and not any(part.burnt for part in parts)
