"""Unusual logs: programs for several parts, runs without pauses, noise, wrong units, missing rows."""

import re
from dataclasses import replace

import numpy as np
import pytest

from grind_env.control import read_file
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.shop.calibrate.column_names import read_map
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.log_alignment import Alignment
from grind_env.shop.calibrate.log_calibration import calibrate
from grind_env.shop.calibrate.meter_lag import find_program
from grind_env.shop.calibrate.power_logs import read_log
from grind_env.shop.calibrate.stroke_schedule import RepeatedProgram, pattern_of, powers
from tests.examples import few
from tests.shop.blemished import PLAIN, write_log
from tests.shop.coverage import EXAMPLES

PLATE, JOB = EXAMPLES / "plate_g82.nc", EXAMPLES / "plate_g82.toml"
TRUTH = {"material": {"ploughing_pressure": 0.95}, "machine": {"stiffness": 14_000.0}}
FITTED = ("ploughing_pressure", "stiffness")
LOOP = "%\nO1\n#1=0\nN1 M98 P2001\n#1=#1+1\nIF [#1 EQ {}] GOTO 9\nM00\nGOTO 1\nN9 M30\n\n"
SECONDS = replace(PLAIN, gaps=0)


def write_loop(path, parts):
    """Write a program that calls the plate as a subprogram in a loop of jumps, once per part."""
    text = PLATE.read_text(encoding="utf-8").lstrip("%\n").replace("M30", "M99")
    path.write_text(LOOP.format(parts) + text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def plates(tmp_path_factory):
    """Return a log of three plates in W and s."""
    path = tmp_path_factory.mktemp("plates") / "log.csv"
    truth, style = with_entries(load_job(JOB), TRUTH), replace(SECONDS, overrides=(0.8, 1.0))
    write_log(path, read_file(PLATE), truth, 3, style, np.random.default_rng(2))
    return path


@pytest.mark.nightly
def test_one_program_for_three_parts_fits_like_three_runs_of_one_part(plates, tmp_path):
    whole = calibrate(plates, write_loop(tmp_path / "three.nc", 3), JOB, names=FITTED)
    each = calibrate(plates, PLATE, JOB, names=FITTED)
    for one, other in zip(whole.estimates, each.estimates, strict=True):
        assert one.value == pytest.approx(other.value, rel=0.02)
        assert one.value == pytest.approx(TRUTH[one.parameter.kind][one.parameter.key], rel=0.1)
    np.testing.assert_array_equal(whole.data.part, each.data.part)
    np.testing.assert_array_equal(*(np.isfinite(found.fit.held_out) for found in (whole, each)))
    told = [[remark for remark in found.remarks if "overridden" in remark] for found in (whole, each)]
    assert told[0] == told[1] != []


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_runs_without_a_pause_between_them_are_located(seed, tmp_path):
    style = replace(SECONDS, idle=630.0, warm_up=0.0, coolant=0.0, stops=False)
    write_log(tmp_path / "log.csv", read_file(PLATE), load_job(JOB), 3, style, np.random.default_rng(seed))
    job, programs = load_job(JOB), read_file(PLATE)
    pattern, expected = pattern_of(programs, job), powers(RepeatedProgram(programs, job, 2).run(job))[-29:]
    found, _ = find_program(read_log(tmp_path / "log.csv", job.setup.machine, read_map(None)), pattern, expected)
    span = pattern.times(1)[2] / found.override[:, 1]
    np.testing.assert_allclose(found.begin[:, 2] - found.begin[:, 1], span, atol=0.3)


@pytest.mark.nightly
def test_noise_between_parts_is_not_counted_as_an_execution(tmp_path):
    text = (EXAMPLES / "rail_g83.nc").read_text(encoding="utf-8")
    head, body = text.split("N20 ", 1)
    body, dress = body.replace(" M05", "").split("N110 M30")
    program, job = tmp_path / "rails.nc", EXAMPLES / "rail_g83.toml"
    program.write_text(head + "M00\n".join(["N20 " + body] * 3) + "M30" + dress, encoding="utf-8")
    truth = with_entries(load_job(job), {"material": {"ploughing_pressure": 0.45, "chip_energy": 11.8}})
    style = replace(SECONDS, rate=1.0, idle=480.0, warm_up=0.0)
    write_log(tmp_path / "log.csv", read_file(program), truth, 1, style, np.random.default_rng(1))
    found = calibrate(tmp_path / "log.csv", program, job, names=["ploughing_pressure"])
    assert any("in the log once" in remark for remark in found.remarks)
    assert found.judged.errors["power"][2] < 0.1


def test_runs_unlike_the_others_are_left_out():
    """A run as weak as noise and one with a feed change are left out; one in a coarse log is good enough."""
    row = {
        "begin": [0.0, 50.0, 100.0, 150.0],
        "override": [1.0, 0.7, 0.85, 1.0],
        "correlation": [0.99, 0.8, 0.66, 0.7],
        "gain": [1.2, 0.02, 0.8, 1.1],
        "rest": [80.0, 5.0, 600.0, 90.0],
    }
    found = Alignment(**{name: np.array([values]) for name, values in row.items()})
    np.testing.assert_array_equal(found.sure, [[True, False, False, True]])


def test_a_log_without_the_idling_spindle_is_refused(plates, tmp_path):
    heading, *rows = plates.read_text(encoding="utf-8").splitlines()
    power = np.array([float(row.split(",")[1]) for row in rows])
    kept = [row for row, value in zip(rows, power, strict=True) if value > 1950.0]
    (tmp_path / "log.csv").write_text("\n".join([heading, *kept]), encoding="utf-8")
    with pytest.raises(CalibrationError, match="idling spindle is not known"):
        calibrate(tmp_path / "log.csv", PLATE, JOB, names=FITTED)


@pytest.mark.parametrize(("heading", "factor", "meant"), few([("kW", 1.0, "W"), ("W", 1e-3, "kW")]))
def test_a_power_in_the_wrong_unit_is_refused_and_a_map_corrects_it(plates, tmp_path, heading, factor, meant):
    first, *rows = plates.read_text(encoding="utf-8").splitlines()
    pairs = [row.split(",") for row in rows]
    scaled = [f"{time},{factor * float(power):.4f}" for time, power in pairs]
    text = "\n".join([first.replace("[W]", f"[{heading}]"), *scaled])
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    told = f"it is in {meant} and not in {heading}, a factor of 1000; write {meant} in its heading"
    with pytest.raises(CalibrationError, match=told):
        calibrate(tmp_path / "log.csv", PLATE, JOB, names=["stiffness"])
    (tmp_path / "map.toml").write_text(f'[log]\npower_unit = "{meant}"\n', encoding="utf-8")
    found = calibrate(tmp_path / "log.csv", PLATE, JOB, map_file=tmp_path / "map.toml", names=["stiffness"])
    (known,) = calibrate(plates, PLATE, JOB, names=["stiffness"]).estimates
    assert found.estimates[0].value == pytest.approx(known.value, rel=0.01)


@pytest.mark.parametrize(
    ("text", "reason"),
    few(
        [
            ("part,size [um]\n1,900\n", "more than the stock of 200 um"),
            ("part,diameter\n1,29.9\n2,29.8\n", "check the unit of its diameter"),
            ("part,Ra\n1,250\n2,240\n", "check the unit of Ra"),
        ]
    ),
)
def test_a_gauge_file_in_wrong_units_is_refused(plates, tmp_path, text, reason):
    (tmp_path / "gauge.csv").write_text(text, encoding="utf-8")
    with pytest.raises(CalibrationError, match=reason):
        calibrate(plates, PLATE, JOB, gauge=tmp_path / "gauge.csv", names=["roughness"])


def test_a_job_with_parts_that_differ_is_refused(tmp_path):
    job = tmp_path / "job.toml"
    job.write_text(JOB.read_text(encoding="utf-8") + "\n[[parts]]\n[parts.factors]\nkA = 2.0\n", encoding="utf-8")
    with pytest.raises(CalibrationError, match=r"like parts; leave \[\[parts\]\] out"):
        calibrate(tmp_path / "log.csv", PLATE, job)


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("5,{power}", "the time, column 'time', does not change"),
        ("{time},650", "the power, column 'power', does not change (it is 650)"),
        ("{time},{switched}", "the power, column 'power', is 500 or 800 and nothing else"),
    ],
)
def test_a_time_or_power_column_without_information_is_refused(tmp_path, row, reason):
    path = tmp_path / "log.csv"
    rows = [row.format(time=0.1 * k, power=500 + k, switched=500 + 300 * (k // 15 % 2)) for k in range(600)]
    path.write_text("\n".join(["time [s],power [W]", *rows]), encoding="utf-8")
    with pytest.raises(CalibrationError, match=re.escape(reason)):
        calibrate(path, PLATE, JOB)
