"""Calibration from logs with deliberate faults, of a machine with known constants."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from grind_env.control import read_file
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.process.catalogue import load_catalogue
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.log_alignment import template
from grind_env.shop.calibrate.log_calibration import calibrate
from grind_env.shop.calibrate.meter_lag import sharpened
from grind_env.shop.calibrate.power_logs import Log
from grind_env.shop.calibrate.stroke_power import idle_at
from grind_env.shop.calibrate.stroke_schedule import pattern_of
from grind_env.shop.calibrate.table_calibration import calibrate_table
from grind_env.validation.rig import Rig
from tests.shop.blemished import TICK, Style, strokes_of, write_log
from tests.shop.coverage import EXAMPLES, STYLES, trial

TRUTH = {"material": {"ploughing_pressure": 0.95, "chip_energy": 15.5}, "machine": {"stiffness": 14_000.0}}


@pytest.fixture(scope="module")
def plates(tmp_path_factory):
    """Return the folder with a log of three plates, and its calibration."""
    folder = tmp_path_factory.mktemp("plates")
    program, job = EXAMPLES / "plate_g82.nc", EXAMPLES / "plate_g82.toml"
    truth = with_entries(load_job(job), TRUTH)
    write_log(folder / "log.csv", read_file(program), truth, 3, Style(scale=0.0), np.random.default_rng(5))
    return folder, calibrate(folder / "log.csv", program, job)


def test_known_constants_are_found_again(plates):
    found = {each.parameter.key: each for each in plates[1].estimates}
    for kind in TRUTH.values():
        for key, value in kind.items():
            assert found[key].determined
            assert 0.85 * value < found[key].value < 1.15 * value
            assert found[key].low < found[key].parameter.prior or found[key].high > found[key].parameter.prior
    assert plates[1].judged.errors["power"][2] < 0.02 < plates[1].judged.errors["power"][1]
    assert plates[1].judged.held_out["power"][2] < 0.03


def test_undetermined_constants_are_named_and_stay_at_their_priors(plates):
    assert {"material.tempering_rise", "wheel.roughness"} <= set(plates[1].undetermined)
    kept = {each.parameter.name: each for each in plates[1].estimates if not each.determined}
    assert all(each.value == pytest.approx(each.parameter.prior) for each in kept.values())


def test_the_catalogue_file_contains_the_fitted_machine(plates):
    folder, found = plates
    found.write(folder / "shop.toml")
    catalogue = load_catalogue(folder / "shop.toml")
    assert catalogue.machine("default").stiffness == pytest.approx(found.fitted.setup.machine.stiffness, rel=1e-3)
    assert catalogue.machine("default").idle_power == pytest.approx(found.idle.mean, abs=1.0)
    left = catalogue.machine("default").power_limit - catalogue.machine("default").idle_power
    assert left == pytest.approx(7500.0)


def test_the_power_limit_of_a_percent_meter_includes_idle_power(plates, tmp_path):
    """A load meter shows 100 % at the limit, and the idling spindle takes a share of that."""
    found = plates[1]
    in_percent = dataclasses.replace(found, idle=dataclasses.replace(found.idle, full=7600.0))
    in_percent.write(tmp_path / "shop.toml")
    machine = load_catalogue(tmp_path / "shop.toml").machine("default")
    assert machine.power_limit == pytest.approx(7600.0, abs=1.0)
    assert machine.idle_power == pytest.approx(found.idle.mean, abs=1.0)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [0, 4, 9])
def test_fitted_constants_lie_within_four_spreads_of_the_truth(seed, tmp_path):
    program = ("plate_g82", "rail_g83", "plate_g82")[seed % 3]
    _, rows = trial(seed, tmp_path, 2, program, STYLES[seed // 3])
    told = [row for row in rows if row[1]]
    assert told
    assert all(abs(row[3]) < 4.0 for row in told)


def test_a_missing_time_unit_is_recognised(tmp_path):
    program, job = EXAMPLES / "plate_g82.nc", EXAMPLES / "plate_g82.toml"
    style = Style(rate=200.0, unit="W", comma=False, clock="ms", headings=("time", "power"), noise=80.0, scale=0.0)
    write_log(tmp_path / "log.csv", read_file(program), load_job(job), 1, style, np.random.default_rng(3))
    found = calibrate(tmp_path / "log.csv", program, job, names=["stiffness"])
    assert any("it is in ms" in remark for remark in found.remarks)
    assert found.estimates[0].value == pytest.approx(20_000.0, rel=0.1)


def test_a_log_of_another_program_is_refused(plates):
    with pytest.raises(CalibrationError, match="does not match the program"):
        calibrate(plates[0] / "log.csv", EXAMPLES / "keyway_g81.nc", EXAMPLES / "keyway_g81.toml")


@pytest.mark.parametrize("names", ["chip_energi", "youngs_modulus", "idle_power"])
def test_a_constant_that_cannot_be_fitted_is_named(plates, names):
    with pytest.raises(CalibrationError, match=names.split("_")[0]):
        calibrate(plates[0] / "log.csv", EXAMPLES / "plate_g82.nc", EXAMPLES / "plate_g82.toml", names=[names])


@pytest.mark.parametrize("override", [1.0, 0.7])
def test_the_stroke_pattern_matches_a_table_moved_in_small_steps(override):
    job = load_job(EXAMPLES / "plate_g82.toml")
    programs = read_file(EXAMPLES / "plate_g82.nc")
    pattern = pattern_of(programs, job)
    on, off, _ = pattern.times(0, override)
    _, places, _ = strokes_of(programs, job, override, [])[0]
    over = np.flatnonzero((places >= job.part.start) & (places <= job.part.start + job.part.length)) * TICK
    assert on[0] == pytest.approx(over[0], abs=2 * TICK)
    assert off[0] == pytest.approx(over[-1], abs=2 * TICK)
    assert pattern.runs == 3


def test_idle_power_follows_the_drift_and_ignores_outliers():
    time = np.arange(0.0, 60.0, 0.7)
    power = 1500.0 - 3.0 * time
    power[::9] += 800.0
    when = np.array([10.0, 30.0, 50.0])
    idle, error = idle_at(when, time, power + np.random.default_rng(1).normal(0.0, 5.0, time.size))
    np.testing.assert_allclose(idle, 1500.0 - 3.0 * when, atol=8.0)
    assert np.all(error < 5.0)


def test_the_lag_of_a_meter_is_removed():
    """Use the exact response of a first-order meter to a square wave."""
    time = np.arange(0.0, 20.0, 0.05)
    power = np.where(time % 2.0 < 1.0, 2000.0, 500.0)
    shown = np.empty_like(power)
    shown[0] = power[0]
    for k in range(1, time.size):
        shown[k] = power[k - 1] + (shown[k - 1] - power[k - 1]) * np.exp(-0.05 / 0.2)
    log = Log(time, shown, np.zeros(time.size, bool), 0.02, True, "W", True, (), lag=0.2)
    inside = (time % 1.0 > 0.15) & (time % 1.0 < 0.9)
    np.testing.assert_allclose(sharpened(log)[inside], power[inside], rtol=0.05)


@pytest.mark.parametrize("lag", [0.1, 1.0, 4.0])
def test_the_readings_of_a_lagging_meter_match_small_time_steps(lag):
    programs, job = read_file(EXAMPLES / "plate_g82.nc"), load_job(EXAMPLES / "plate_g82.toml")
    pattern = pattern_of(programs, job)
    height = np.linspace(500.0, 2000.0, pattern.run.size)
    on, off, _ = pattern.times(0)
    time = np.arange(-1.0, 30.0, TICK)
    power = np.zeros(time.size)
    for begin, end, P in zip(on.tolist(), off.tolist(), height.tolist(), strict=False):
        power[(time >= begin) & (time < end)] = P
    shown = np.empty(time.size)
    shown[0] = 0.0
    for k in range(1, time.size):
        shown[k] = power[k] + (shown[k - 1] - power[k]) * np.exp(-TICK / lag)
    steps = round(0.1 / TICK)
    means = shown[: time.size // steps * steps].reshape(-1, steps).mean(axis=1)
    at = time[0] + 0.1 * (np.arange(means.size) + 0.5) - 0.5 * TICK
    np.testing.assert_allclose(
        template(pattern, height, 0, 1.0, at, 0.1, lag), means, rtol=0.01, atol=2000.0 * TICK / lag
    )


def test_a_table_of_settings_determines_roughness_and_chip_energy(tmp_path: Path):
    catalogue, truth = load_catalogue(), {"material": {"chip_energy": 16.0}, "wheel": {"roughness": 0.65}}
    rows = ["table_speed [m/min];downfeed [µm];volume;power [kW];Ra"]
    for speed in (8.0, 14.0, 20.0):
        for feed in (5.0, 15.0):
            rig = Rig(catalogue).fresh(table_speed=speed * 1000 / 60, downfeed=feed / 1000, changes=truth)
            done = rig.grind_volume(40.0)
            rows.append(f"{speed};{feed};40;{done.power / 1000:.4f};{done.Ra:.4f}")
    (tmp_path / "table.csv").write_text("\n".join(rows), encoding="utf-8")
    found = calibrate_table(tmp_path / "table.csv", EXAMPLES / "plate_g82.toml")
    values = {each.parameter.key: each for each in found.estimates}
    assert values["roughness"].low < 0.65 < values["roughness"].high
    assert values["chip_energy"].low < 16.0 < values["chip_energy"].high
    assert found.judged.errors["Ra"][2] < 0.05 < found.judged.errors["Ra"][1]


@pytest.mark.parametrize("volume", ["400000000", "100001"])
def test_a_setting_with_too_many_strokes_is_refused(volume: str, tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(f"downfeed [um];volume;Ra\n5;40;.3\n5;{volume};.4\n", encoding="utf-8")
    with pytest.raises(CalibrationError, match=r"setting 2 grinds .* strokes; check volume, downfeed and length"):
        calibrate_table(tmp_path / "table.csv", EXAMPLES / "plate_g82.toml")


def test_a_table_without_a_measured_value_is_refused(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("downfeed [um],volume,Ra\n5,40,\n15,40,\n", encoding="utf-8")
    with pytest.raises(CalibrationError, match="fewer than two measurements"):
        calibrate_table(tmp_path / "table.csv", EXAMPLES / "plate_g82.toml")


@pytest.mark.nightly
def test_forces_that_follow_other_laws_leave_a_residual(tmp_path: Path) -> None:
    path, left = tmp_path / "forces.csv", []
    for off in (0.0, 0.2):
        rows = ["table_speed [m/min],downfeed [um],volume,Ft [N/mm]"]
        for k, (speed, feed) in enumerate((speed, feed) for speed in (8, 11, 14, 17, 20) for feed in (5, 15)):
            rig = Rig(load_catalogue()).fresh(table_speed=speed * 1000 / 60, downfeed=feed / 1000)
            rows.append(f"{speed},{feed},40,{rig.grind_volume(40.0).Ft * (1.0 + off * (-1) ** (k // 2)):.4f}")
        path.write_text("\n".join(rows), encoding="utf-8")
        left.append(calibrate_table(path, EXAMPLES / "plate_g82.toml").residual)
    assert left[0] < 0.02 and 0.1 < left[1] < 0.3
