"""The track as a study: scores by hand, frozen anchors, resumed trials."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.track import page as pages
from agents.track import scale_anchors, scores, study
from agents.track.adapter_registry import make_adapter
from agents.track.page import page
from agents.track.scale_anchors import PLAN, PLANNER, TRAINED, MachineRuns
from agents.track.scores import anchors_of, collected, points, read_anchors, summary, write_anchors
from agents.track.track_trials import TrackTrial
from grind_env.policies import track
from grind_env.policies.nominal_model import model_of
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.track import BASELINE, SHIFTS, TrackRuns
from grind_env.task_version import TASK_VERSION
from tests.agents.asking import in_process, status

MINE = "tests.policies.test_track:Slower"  #: policy class that learns
COSTS = {PLAN: 5.0, PLANNER: 2.0, TRAINED: 3.0, BASELINE: 4.0, "half": 3.5, "best": 1.0}


def runs(*costs: float, said: str = "", scrap: float = 0.6) -> MachineRuns:
    """Return runs of one seed for each cost, which is the cost of every block."""
    shape = len(costs), SHIFTS
    cost = np.repeat(np.array(costs)[:, None], SHIFTS, axis=1)
    return MachineRuns(TrackRuns(cost, np.full(shape, scrap), np.full(shape, 60.0)), said, 1.0)


def known(factor: float = 1.0) -> Mapping[str, MachineRuns]:
    return {name: runs(factor * cost, factor * (cost + 1.0), said=name) for name, cost in COSTS.items()}


def test_scores_scale_between_two_policies_on_the_same_lots() -> None:
    zero, hundred = np.array([[4.0, 6.0], [8.0, 12.0]]), np.array([[3.0, 5.0], [6.0, 10.0]])
    for ours, score in ((zero, 0.0), (hundred, 100.0), (0.5 * (zero + hundred), 50.0)):
        assert [each.value for each in summary(ours, zero, hundred)] == [score] * 3
    assert {tuple(each) for each in summary(zero, zero, hundred)} == {(0.0, 0.0, 0.0)}
    assert {tuple(each) for each in summary(hundred, zero, hundred)} == {(100.0, 100.0, 100.0)}
    ours = np.array([[3.0, 5.0], [8.0, 12.0]])  # 100 on a machine, and 0 on one with twice the gap
    found = summary(ours, zero, hundred)
    assert (found.mean.value, found.median.value) == (50.0, 50.0)
    assert found.of_sums.value == pytest.approx(100.0 / 3.0)
    assert (found.mean.low, found.mean.high) == (0.0, 100.0)


def test_a_machine_with_equal_anchors_counts_in_the_sums_only() -> None:
    zero, hundred, ours = np.array([[4.0], [4.0]]), np.array([[3.0], [4.0]]), np.array([[3.5], [3.75]])
    assert np.isnan(points(ours, zero, hundred)).tolist() == [[False], [True]]
    found = summary(ours, zero, hundred)
    assert found.mean.value == found.median.value == 50.0 and found.of_sums.value == pytest.approx(75.0)
    assert np.isnan(summary(ours[1:], zero[1:], hundred[1:])).all()


def test_trainings_are_averaged_and_seeds_stay_separate() -> None:
    found = {TrackTrial("public:1", TRAINED, (0, 1), k): {TRAINED: runs(2.0 + k, 4.0 + k)} for k in range(3)}
    found |= {TrackTrial("public:1", "mine", (seed,)): {"mine": runs(7.0 + seed)} for seed in range(2)}
    of = collected(found)["public:1"]
    assert of[TRAINED].runs.cost.mean(axis=1).tolist() == [3.0, 5.0]
    assert of["mine"].runs.cost.mean(axis=1).tolist() == [7.0, 8.0] and of["mine"].runs.scrap.shape == (2, SHIFTS)


def test_the_bound_is_the_cheapest_and_anchors_are_read_as_written(tmp_path: Path) -> None:
    anchors = {"public:1": anchors_of(known()), "public:2": anchors_of(known(2.0))}
    assert (anchors["public:1"].bound_by, anchors["public:1"].bound.tolist()) == ("best", [1.0, 2.0])
    path = tmp_path / "anchors.csv"
    write_anchors(path, anchors)
    again = read_anchors(path, [0, 1])
    assert {plant: [np.array(x).tolist() for x in each] for plant, each in anchors.items()} == {
        plant: [np.array(x).tolist() for x in each] for plant, each in again.items()
    }
    assert read_anchors(path, [0])["public:2"].robust.tolist() == [8.0] and read_anchors(path, [0, 1, 2]) == {}
    path.write_text(path.read_text().replace(f"\n{TASK_VERSION},", f"\n{TASK_VERSION - 1},"))
    assert read_anchors(path, [0]) == {} == read_anchors(tmp_path / "none.csv", [0])


def test_the_page_has_both_scores_and_every_machine() -> None:
    ground = {"public:1": known(), "public:2": known(2.0)}
    text = page(ground, {plant: anchors_of(of) for plant, of in ground.items()})
    assert f"| {BASELINE} | 0 (0 to 0) | 0 (0 to 0) | 0 (0 to 0) | 1.000 | 1.00 | 1.0 |" in text
    assert f"| {TRAINED} | 100 (100 to 100) | 100 (100 to 100) |" in text
    assert "| half | 50 (50 to 50) |" in text and "| best | 100 (100 to 100) |" in text
    assert f"| {PLAN} | 0 (0 to 0) | 0 (0 to 0) | 0 (0 to 0) |" in text
    assert "| public:2 | 11.000 | 9.000 | 7.000 | 3.000 | best | 50 | 300 |" in text
    assert "| half | 6.000 |" in text.partition("shift by shift")[2]


def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the track and the search for its anchors."""
    for name, number in (("EVALUATIONS", 4), ("STARTS", 1), ("EPISODES", 2), ("HORIZON", 1)):
        monkeypatch.setattr(scale_anchors, name, number)
    monkeypatch.setattr(scale_anchors, "STEPS", 128 * 60)
    for shared in (track, pages):
        monkeypatch.setattr(shared, "SHIFTS", 2)
    for shared in (study, scores, pages):
        monkeypatch.setattr(shared, "BASELINE", "E8000D1")
    monkeypatch.setattr(study, "TRAININGS", 1)
    in_process(monkeypatch)


@pytest.mark.nightly
def test_the_command_runs_the_track_and_resumes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    small(monkeypatch)
    words = ["track", "--machines", "public:1", "--seeds", "2", "--cache", tmp_path, "--adapters", MINE]
    assert status(monkeypatch, *words) == 0
    assert "5 runs, 5 to do: about 0.1 core-hours" in capsys.readouterr().out
    rows = (tmp_path / "track.csv").read_text().splitlines()
    assert len(rows) == 1 + 5 * 2 and rows[0].startswith("task,plant,adapter,seed,cost,scrap")
    assert f"| {PLAN} | 0 (0 to 0) |" in (tmp_path / "track.md").read_text()
    assert [*read_anchors(tmp_path / "track_anchors.csv", [0, 1])] == ["public:1"]
    assert status(monkeypatch, *words, "--adapters", "E7000D1") == 0
    assert "7 runs, 2 to do" in capsys.readouterr().out


def test_with_frozen_anchors_only_the_adapter_is_run_and_a_row_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    small(monkeypatch)
    monkeypatch.setattr(study, "RESULTS", tmp_path)
    monkeypatch.setattr(study, "MACHINES", ("public:1", "public:2"))
    monkeypatch.setattr(scores, "BASELINE", BASELINE)
    write_anchors(tmp_path / "track_anchors.csv", {plant: anchors_of(known()) for plant in ("public:1", "public:2")})
    monkeypatch.setattr(study, "track_row", lambda *told: told)
    written: list[Any] = []
    monkeypatch.setattr(study, "write_rows", lambda path, rows: written.append((path, *rows[0])))
    words = ["track", "--seeds", "1", "--cache", tmp_path / "cache", "--adapters", MINE]
    assert status(monkeypatch, *words, "--submit", tmp_path / "row.json") == 0
    assert "2 runs, 2 to do" in capsys.readouterr().out
    ((path, text, costs, robust),) = written
    assert (path, text, robust.tolist()) == (tmp_path / "row.json", MINE, [4.0, 4.0])
    model = model_of(find_problem("power_limited"))
    machines = [track.run_shifts(make_adapter(text, model), plant, [0]) for plant in ("public:1", "public:2")]
    assert costs.tolist() == [each.cost[0].mean() for each in machines]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--machines", "public"], "'public' is the name of many machines: give a seed, as 'public:1'"),
        (["--adapters", "nobody"], "there is no policy 'nobody'"),
        (["--adapters", "no_module:Mine"], "'no_module:Mine' names no policy"),
        (["--submit", "row.json"], "--submit writes the row of one policy on all machines"),
        (["--adapters", "E7000D1", "--machines", "public:1", "--submit", "row.json"], "give --adapters once"),
    ],
)
def test_invalid_options_of_the_track_are_refused(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setattr(study, "BASELINE", "E8000D1")
    monkeypatch.setattr(study, "POLICIES", ("E7000D1",))
    assert status(monkeypatch, "track", "--cache", tmp_path, *words) == 2 and said in capsys.readouterr().err
