"""Commands for a shop on a program for two stations."""

import json
import shutil
from pathlib import Path

import gymnasium as gym
import pytest

from grind_env.control import read_file
from grind_env.machine.job.job_file import load_job
from grind_env.shop.start.sample_log import PRESSURE, sample_log
from tests.command import Grind
from tests.shop.programs import EXAMPLES, KNOWN, TWO_PLATES


@pytest.fixture
def program(tmp_path: Path) -> Path:
    job = TWO_PLATES.with_suffix(".toml").read_text(encoding="utf-8")
    path = tmp_path / TWO_PLATES.with_suffix(".toml").name
    path.write_text(job.replace('name = "B"', 'name = "B"\nroughness_limit = 0.9'), encoding="utf-8")
    return Path(shutil.copy(TWO_PLATES, tmp_path))


def test_parts_at_two_stations_are_good_and_the_first_matches_a_single_part(grind: Grind) -> None:
    assert grind("check", TWO_PLATES, "--job", TWO_PLATES.with_suffix(".toml"))[0] == 0
    found = json.loads(grind("run", TWO_PLATES, "--json")[1])
    single = json.loads(grind("run", EXAMPLES / "plate_g82.nc", "--json")[1])["parts"][0]
    assert found["warnings"] == [] and [each["station"] for each in found["parts"]] == ["A", "B"]
    assert [each["beyond"] for each in found["parts"]] == [[], []]
    first = found["parts"][0]
    assert {name: first[name] for name in ("strokes", "S", "Ra", "rise")} == pytest.approx(
        {name: single[name] for name in ("strokes", "S", "Ra", "rise")}
    )


@pytest.mark.nightly
def test_a_log_of_two_stations_yields_the_true_constant(program: Path, grind: Grind) -> None:
    log = program.with_name("log.csv")
    log.write_text(sample_log(read_file(program), load_job(program.with_suffix(".toml"))))
    told = grind("calibrate", log, "--program", program, "--job", program.with_suffix(".toml"), "--json")[1]
    fitted = json.loads(told)
    (found,) = [each for each in fitted["constants"] if each["name"].endswith("ploughing_pressure")]
    assert found["low"] < PRESSURE * found["was"] < found["high"] and found["low"] > found["was"]


@pytest.mark.usefixtures("few_lots", "coarse_speeds")
def test_the_limits_of_each_station_are_shown(program: Path, grind: Grind) -> None:
    job = program.with_suffix(".toml")
    job.write_text(job.read_text() + KNOWN)
    few = "--vary", "E", "--budget", "1000s", "--parts", "3"
    status, out, _ = grind("optimise", program, *few)
    assert status == 0 and "A 0.5, B 0.9 um" in out
    found = json.loads(grind("optimise", program, *few, "--json")[1])
    limits = {each["name"]: each for each in found["limits"]}
    assert limits["Ra"]["stations"] == [["A", 0.5], ["B", 0.9]] and limits["Ra"]["limit"] == 0.5
    assert limits["size"]["stations"] == []


@pytest.mark.nightly
def test_sweep_report_environment_and_advise_accept_stations(program: Path, grind: Grind, tmp_path: Path) -> None:
    status, _, err = grind("sweep", program, "--E", "9000..12000", "--dress-every", "1..2", "--parts", "2", "--json")
    assert (status, err) == (0, "")
    report = tmp_path / "report.html"
    assert grind("report", program, "-o", report)[0] == 0
    page = report.read_text(encoding="utf-8")
    assert "station" in page and "1 A" in page and "for all stations together" in page
    env = gym.make("grind/Job-v0", program=str(program), parts=2)
    env.reset(seed=1)
    steps, over = 0, False
    while not over:
        _, _, over, _, _ = env.step(env.action_space.sample())
        steps += 1
    assert steps == 8  # two cycles on each of two parts, loaded twice
    measured = tmp_path / "measured.csv"
    measured.write_text("mean_power\n1700\n900\n")
    status, out, err = grind("advise", program, "--parts", 1, "--policy", "E12000D1", "--measurements", measured)
    assert status == 0, err
    assert out
