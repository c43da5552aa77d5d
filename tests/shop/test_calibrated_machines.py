"""Calibration of out-of-model machines; `python -m agents plants` prints the table of all machines."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import tomllib
from typer.testing import CliRunner

from agents.plants.study_machines import PROGRAMS
from grind_env.cli import app
from grind_env.control import read, read_file
from grind_env.machine.grind import grind
from grind_env.machine.job.drawn_machines import usual_uncertainty
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.process.catalogue import load_catalogue
from grind_env.shop.calibrate.exceptions import CalibrationError, WorseFit
from grind_env.shop.calibrate.experiment_program import plan_of
from grind_env.shop.calibrate.least_squares import Data, Solver
from grind_env.shop.calibrate.log_calibration import calibrate
from grind_env.shop.calibrate.result import catalogue_text
from grind_env.shop.calibrate.verdict import FitJudgement
from grind_env.shop.python_api import plan
from tests.examples import nightly
from tests.shop.blemished import PLAIN, write_log
from tests.shop.coverage import EXAMPLES
from tests.shop.machines import trial

FOUND = Path(__file__).parent
PROGRAM, JOB = EXAMPLES / "plate_g82.nc", EXAMPLES / "plate_g82.toml"


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """Return a calibration of the model itself, and the errors of the fit, the catalogue and a regression."""
    return trial("model", "plate_g82", tmp_path_factory.mktemp("model"), 3)


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    """Return a calibration and errors of a machine with other laws, logged with several E and depths."""
    return trial("foreign:1", "plate_g82", tmp_path_factory.mktemp("foreign"), 6, varies=True)


@pytest.mark.nightly
def test_the_fit_of_the_model_has_no_free_term_and_half_the_error_of_a_regression(model):
    found, errors = model
    assert found.fit.width == 0.0
    assert errors["error"] <= 0.5 * errors["regression"]


@pytest.mark.nightly
def test_the_free_term_follows_forces_that_the_model_does_not(foreign):
    """The force of this machine grows with table speed and depth; the rubbing force of the model with depth alone."""
    found, errors = foreign
    assert found.fit.width > 0.0
    assert found.fitted.part.material.power_speed_exponent > 0.15
    assert errors["error"] <= 0.3 * errors["catalogue"]


@pytest.mark.nightly
def test_a_fit_of_other_laws_has_half_the_error_of_a_regression(tmp_path):
    _, errors = trial("foreign:2", "keyway_g81", tmp_path, 3, varies=True)
    assert errors["error"] <= 0.5 * errors["regression"]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "program", "lag"),
    [nightly("table:1", "plate_g82", None), nightly("meter:4", "plate_g82", 1.51), ("meter:1", "keyway_g81", 0.32)],
)
def test_slow_tables_and_lagging_meters_leave_half_the_error_of_a_regression(name, program, lag, tmp_path):
    found, errors = trial(name, program, tmp_path, 4)
    assert errors["error"] <= 0.5 * errors["regression"]
    if lag is None:
        assert any("of its pace" in remark for remark in found.remarks)
    else:
        said = next(remark for remark in found.remarks if "lags" in remark)
        assert float(said.split("about ")[1].split(" s")[0]) == pytest.approx(lag, rel=0.15)


def test_the_idle_power_is_found_from_a_lagging_meter(tmp_path):
    style = dataclasses.replace(PLAIN, idle=630.0, warm_up=0.0, coolant=0.0, lag=1.0)
    write_log(tmp_path / "log.csv", read_file(PROGRAM), load_job(JOB), 3, style, np.random.default_rng(2))
    found = calibrate(tmp_path / "log.csv", PROGRAM, JOB, names=["ploughing_pressure"])
    assert found.idle.mean == pytest.approx(630.0, rel=0.06)
    assert 0.85 * 630.0 < found.idle.low < found.idle.high < 1.15 * 630.0


def test_a_given_meter_scale_is_written_and_not_fitted(tmp_path):
    write_log(tmp_path / "log.csv", read_file(PROGRAM), load_job(JOB), 2, dataclasses.replace(PLAIN, gain=1.17), RNG())
    (tmp_path / "map.toml").write_text("[log]\nscale = 1.17\n", encoding="utf-8")
    found = calibrate(tmp_path / "log.csv", PROGRAM, JOB, map_file=tmp_path / "map.toml")
    assert found.scales == {}
    values = {each.parameter.key: each for each in found.estimates}
    assert values["ploughing_pressure"].low < 0.62 < values["ploughing_pressure"].high
    found.write(tmp_path / "shop.toml")
    assert load_catalogue(tmp_path / "shop.toml").machine("default").meter_scale == pytest.approx(1.17)


def RNG():
    return np.random.default_rng(5)


def test_no_idle_power_is_written_for_a_job_with_its_own_power_limit(tmp_path):
    job = tmp_path / "plate.toml"
    text = JOB.read_text(encoding="utf-8").replace("[setup]", "[setup]\nmachine_overrides = { power_limit = 4500 }")
    job.write_text(text, encoding="utf-8")
    write_log(tmp_path / "log.csv", read_file(PROGRAM), load_job(job), 2, PLAIN, RNG())
    found = calibrate(tmp_path / "log.csv", PROGRAM, job, names=["ploughing_pressure"])
    assert found.idle.mean > 300.0 and "idle_power" not in catalogue_text(found)


def test_a_scale_of_amperes_without_volts_is_refused(tmp_path):
    style = dataclasses.replace(PLAIN, unit="A", headings=("time [s]", "current [A]"))
    write_log(tmp_path / "log.csv", read_file(PROGRAM), load_job(JOB), 1, style, RNG())
    (tmp_path / "map.toml").write_text("[log]\nscale = 1.0\n", encoding="utf-8")
    with pytest.raises(CalibrationError, match=r"log\.scale is 1"):
        calibrate(tmp_path / "log.csv", PROGRAM, JOB, map_file=tmp_path / "map.toml")


@pytest.mark.parametrize("which", ["model", nightly("foreign")])
def test_the_catalogue_file_contains_the_uncertainty_table(which, request, tmp_path):
    found, _ = request.getfixturevalue(which)
    found.write(tmp_path / "shop.toml", force=True)
    table = tomllib.loads((tmp_path / "shop.toml").read_text())["uncertainty"]
    assert "material.power_speed_exponent" in table["names"]
    assert {*usual_uncertainty(found.job).names} <= {*table["names"]}
    correlation = np.array(table["correlation"])
    assert correlation.shape == (len(table["names"]), len(table["spread"]))
    assert np.allclose(correlation, correlation.T)
    assert np.all(np.diag(correlation) == 1.0)
    assert np.linalg.eigvalsh(correlation)[0] > -1e-6
    spread = dict(zip(table["names"], table["spread"], strict=True))
    # the power does not determine these
    assert (spread["material.tempering_rise"], spread["fluid.boiling_rise"]) == pytest.approx((0.18, 0.15), rel=0.01)
    assert spread["machine.stiffness"] < 0.2
    assert 0.0 <= table["residual"] < 0.05
    assert load_catalogue(tmp_path / "shop.toml").machine("default").stiffness > 0.0


@pytest.mark.nightly
def test_the_residual_is_larger_for_an_out_of_model_machine(model, foreign):
    assert foreign[0].residual > 2.0 * model[0].residual


@pytest.mark.nightly
def test_a_fit_worse_than_the_catalogue_is_written_with_force_only(model, tmp_path, monkeypatch, grind):
    errors = {"power": (9, 0.02, 0.03)}
    worse = dataclasses.replace(model[0], judged=FitJudgement(errors, errors, worse=("power",)))
    path = tmp_path / "shop.toml"
    with pytest.raises(WorseFit, match="--force"):
        worse.write(path)
    monkeypatch.setattr("grind_env.shop.python_api.calibrate", lambda *_, **__: worse)
    words = ["calibrate", PROGRAM, "--program", PROGRAM, "--job", JOB, "-o", path]
    status, out, err = grind(*words)
    assert status == 3 and "predicts power better" in err
    assert out.startswith("Do not use the fit: the catalogue predicts power better.")
    assert not path.exists()
    status, out, _ = grind(*words, "--force")
    assert status == 0 and path.exists() and "next:" not in out


def test_unchecked_parts_may_hide_burn_with_a_small_chance():
    """A tenth of the burnt parts pass as good if nobody looks."""
    data = Data(*(np.array(each) for each in ([0.0, 0.0, 1.0], [0.0, 0.1, 0.0], ["burn"] * 3, [1, 2, 3])))
    solver = Solver((), [], data, lambda _: np.array([2.0, 2.0, 2.0]))
    burnt = 1.0 / (1.0 + math.exp(-2.0))
    chances = [1.0 - burnt, 1.0 - burnt + 0.1 * burnt, burnt]
    rest = solver.residuals(solver.predicted(np.empty(0)), np.ones(3, bool), {"burn": 1.0})
    np.testing.assert_allclose(0.5 * rest**2, [-math.log(each) for each in chances])


@pytest.mark.nightly
def test_parts_gauged_as_good_are_not_condemned(tmp_path):
    """The material burns later than the catalogue says and is ground hotter than the catalogue allows."""
    job, text = tmp_path / "plate.toml", JOB.read_text()
    own = '[catalogue.material.soft]\nbase = "aisi_52100"\ntempering_rise = 80\n'
    words = 'material = "soft"\nrise_allowance = 0'
    job.write_text(text.replace('material = "aisi_52100"', words) + own, encoding="utf-8")
    truth = with_entries(load_job(job), {"material": {"tempering_rise": 200.0}})
    write_log(tmp_path / "log.csv", read_file(PROGRAM), truth, 3, PLAIN, RNG())
    (tmp_path / "parts.csv").write_text("part;Ra [um];size [um]\n1;0.23;1\n2;0.24;2\n3;0.23;1\n", encoding="utf-8")
    alone = calibrate(tmp_path / "log.csv", PROGRAM, job)
    gauged = calibrate(tmp_path / "log.csv", PROGRAM, job, gauge=tmp_path / "parts.csv")
    assert "burn" in alone.verdict.headline and "burn" not in alone.verdict.uses
    good = [grind(read_file(PROGRAM), each.fitted).parts["survival"][0] for each in (alone, gauged)]
    assert good[0] < 0.2 < 0.5 < good[1]


@pytest.mark.nightly
def test_a_plan_is_safe_varies_E_and_picks_and_narrows_the_fit(model, tmp_path):
    programs, job = read_file(PROGRAM), load_job(JOB)
    plan = plan_of(programs, job)
    record = grind(read(plan.text, "plan.nc"), job)
    assert not record.warnings
    assert record.parts["survival"][0] > 0.95
    assert record.parts["peak_power"][0] < 0.6 * job.limits.power
    assert len(record.dresses) == 1
    assert len({feed for feed, _ in plan.blocks}) >= 3
    assert len({pick for _, pick in plan.blocks}) >= 3
    (tmp_path / "plan.nc").write_text(plan.text, encoding="utf-8")
    write_log(tmp_path / "log.csv", read_file(tmp_path / "plan.nc"), job, 3, PLAIN, RNG())
    found = calibrate(tmp_path / "log.csv", tmp_path / "plan.nc", JOB)
    before, after = ({each.parameter.key: each.share for each in fit.estimates} for fit in (model[0], found))
    assert after["ploughing_pressure"] < 0.6 * before["ploughing_pressure"]
    assert after["chip_energy"] < 0.8 * before["chip_energy"]


def test_the_command_writes_a_plan_without_a_log(tmp_path):
    path = tmp_path / "plan.nc"
    words = ["calibrate", "--plan", str(path), "--program", str(PROGRAM), "--job", str(JOB)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert "with one dress" in result.output
    assert "E22500." in path.read_text()


def test_a_plan_of_a_latin_1_program_is_written(tmp_path):
    program = FOUND / "programs_from_elsewhere" / "fuehrungsleiste.nc"
    plan(program, program.with_suffix(".toml"), tmp_path / "plan.nc")
    record = grind(read_file(tmp_path / "plan.nc"), load_job(program.with_suffix(".toml")))
    assert not record.warnings
    assert record.parts["survival"].min() > 0.95


@pytest.mark.parametrize(
    ("program", "reason"),
    [
        ("programs_from_shops/two_rows_g10.nc", "1 warnings; log the program as it is"),  # G55 shifts its second row
        ("programs_from_elsewhere/column_machine.nc", r"vary E and J by hand"),  # its picks are K
        ("programs_from_elsewhere/hand_plunge.nc", "no G82 or G83"),
    ],
)
def test_a_plan_is_refused_for_programs_it_cannot_vary(program, reason):
    path = FOUND / program
    with pytest.raises(CalibrationError, match=reason):
        plan_of(read_file(path), load_job(path.with_suffix(".toml")))


@pytest.mark.parametrize("program", [PROGRAM, EXAMPLES / "rail_g83.nc", PROGRAMS["die"].path])
def test_plans_of_bundled_programs_grind_good_parts_without_warnings(program):
    job = load_job(program.with_suffix(".toml"))
    record = grind(read(plan_of(read_file(program), job).text, program.name, program.parent), job)
    assert not record.warnings
    assert record.parts["survival"].min() > 0.98
    assert record.parts["Ra"].max() < job.limits.roughness
    assert np.abs(record.parts["size_error"]).max() < job.limits.size
