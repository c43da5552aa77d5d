"""The study of the best dress interval against each unknown number, and its table in the repository."""

import math
import shutil
from dataclasses import astuple
from pathlib import Path

import pytest

from agents.csv_tables import csv_rows
from agents.dressing import interval_sensitivity
from agents.dressing.interval_sensitivity import ALL, NOMINAL, PICTURE, UnknownTrial, answers, find, trials
from agents.evaluation_cache import RESULTS
from grind_env import examples
from grind_env.machine.job.drawn_machines import USUAL_SPREADS
from grind_env.shop import python_api
from grind_env.shop.sweep.study import SweepRanges
from grind_env.task_version import TASK_VERSION
from tests.agents.asking import status

KNOWN = "\n[catalogue.uncertainty]\nnames = []\nspread = []\ncorrelation = []\n"


def test_each_number_is_taken_at_both_ends_of_its_range():
    listed = [trial for trial in trials() if trial.program == "plate_g82"]
    assert {trial.number for trial in listed} >= {*USUAL_SPREADS, "part.height", NOMINAL, ALL}
    assert len(listed) == 2 + 2 * len({trial.number for trial in listed} - {NOMINAL, ALL})
    low, high = (trial.value for trial in listed if trial.number == "fluid.part_cooling")
    assert math.sqrt(low * high) == pytest.approx(3000.0, rel=1e-3)
    # 5 and 95 % of a normal distribution are 1.645 standard deviations from its mean
    assert math.log(high / low) == pytest.approx(2 * 1.645 * USUAL_SPREADS["fluid.part_cooling"], rel=1e-3)


def test_a_trial_equals_the_sweep_of_a_job_with_the_changed_number(tmp_path, monkeypatch):
    monkeypatch.setattr(interval_sensitivity, "PARTS", 2)
    monkeypatch.setattr(interval_sensitivity, "RANGES", SweepRanges(every=(1, 2)))
    shutil.copy(examples.path("plate_g82.nc"), tmp_path)
    written = examples.path("plate_g82.toml").read_text("utf-8")
    changes = {
        "part.height": ("height = 20", "height = 40"),
        "fluid.part_cooling": ("[setup]", "[setup]\nfluid_overrides = { part_cooling = 40.0 }"),
    }
    for number, (old, new) in changes.items():
        assert written.count(old) == 1
        (tmp_path / "plate_g82.toml").write_text(written.replace(old, new) + KNOWN, "utf-8")
        swept = python_api.sweep(tmp_path / "plate_g82.nc", dress_every=(1, 2), parts=2)
        found = find(UnknownTrial("plate_g82", number, "high", 40.0))
        assert [point[2] for point in found["points"]] == [each.cost.value for each in swept.speeds]


def test_the_loss_of_the_nominal_plan_by_hand():
    points = {NOMINAL: [(9000.0, 1, 2.0, True), (9000.0, 2, 3.0, True)]}
    points["height"] = [(9000.0, 1, 4.0, False), (9000.0, 2, 2.0, True)]
    found = {UnknownTrial("rail_g83", name, name): {"best": k, "points": points[name]} for k, name in enumerate(points)}
    nominal, height = answers(found)
    assert (nominal.every, nominal.lost) == (1, 0.0)
    assert height[4:] == (9000, 2, 2.0, 4.0, 100.0, False)


def test_the_checked_in_table_has_the_present_numbers():
    rows = csv_rows(RESULTS / "intervals.csv")
    assert [tuple(row[name] for name in ("program", "number", "end", "value")) for row in rows] == [
        tuple(map(str, astuple(trial))) for trial in trials()
    ], "run `python -m agents intervals`"
    assert {row["task_version"] for row in rows} == {str(TASK_VERSION)}
    assert (RESULTS / PICTURE).read_bytes().startswith(b"\x89PNG")


def test_the_command_prints_its_number_of_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status(monkeypatch, "intervals", "--hours", "--cache", tmp_path) == 0
    assert "96 runs" in capsys.readouterr().out
