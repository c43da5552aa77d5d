"""`python -m agents splits`: policies on held-out contexts and beyond the task."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents import split_study
from agents.split_study import EVERY, SHOWN, SplitScore, judged, leading, lines_of, page, plans_of
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import REFERENCE
from tests.agents.asking import in_process, status, study_options

ORACLE, PLATES = find_problem("oracle6"), find_problem("power_limited")


def test_agents_are_judged_on_tasks_with_bundled_agents() -> None:
    assert judged(ORACLE) == ["empirical_rule", "look_ahead", "belief_planner", "mpc"]
    assert judged(PLATES) == ["empirical_rule", "look_ahead", "belief_planner", "plain_gru", "robust", "mpc"]


def test_each_split_is_scored_between_its_hindsight_and_the_best_overall_plan() -> None:
    def run(cost: float) -> Evaluation:
        N = np.full(4, cost)
        shape = dict.fromkeys(Evaluation.__slots__, N)
        return Evaluation(**shape)

    costs = {EVERY: (4.0, 5.0, 2.0, 1.0), "interpolation": (8.0, 2.0, 5.0, 2.0), "extrapolation": (9.0, 9.0, 9.0, 1.0)}
    names = ("constant", "interval", "mpc", REFERENCE)
    found = {(PLATES, split, who): run(cost) for split in SHOWN for who, cost in zip(names, costs[split], strict=True)}
    lines = lines_of(PLATES, found)
    assert [(each.split, each.who) for each in lines] == [
        (split, who) for split in SHOWN for who in ("constant", "mpc", REFERENCE)
    ]
    assert [each.score[0] for each in lines if each.who == "mpc"] == pytest.approx([200.0 / 3.0, 50.0, 0.0])
    assert "| power_limited | interpolation | – | – | – | – | – | 50.0 (50.0 to 50.0) |" in page(lines, 4)


def test_the_page_counts_the_leads_over_tasks_and_the_significant_ones() -> None:
    def line(task: str, who: str, score: float, half: float = 1.0) -> SplitScore:
        return SplitScore(task, EVERY, who, (score, score - half, score + half), (1.0, 1.0, 1.0), 0.0)

    both = ("a", "plain_gru", 9.0), ("a", "robust", 5.0), ("b", "robust", 9.0), ("b", "plain_gru", 8.0)
    lines = [line(*each) for each in both]
    lines += [line("c", "robust", 9.0), line("c", "look_ahead", 3.0), line("c", "mpc", 50.0)]
    one, other = leading(lines, EVERY).split(", ")
    assert one == "`robust` on 2 of 3 tasks (1 significantly)"
    assert other == "`plain_gru` on 1 of 3 tasks (1 significantly)"


def test_a_split_study_is_cached_and_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    in_process(monkeypatch)
    split_study.study(study_options(tmp_path, ORACLE)).publish_to(tmp_path, study_options(tmp_path).options)
    written = {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").rglob("*.npz")}
    words = ("splits", "--task", "oracle6", "--episodes", 2, "--jobs", 1, "--cache", tmp_path / "runs")
    assert status(monkeypatch, *words, "--results", tmp_path) == 0
    said = capsys.readouterr().out
    assert "| oracle6 | extrapolation |" in said and " 0 to do" in said
    assert all(path.stat().st_mtime_ns == time for path, time in written.items())
    assert len(written) == (len(plans_of(ORACLE)) + len(judged(ORACLE)) + 1) * len(SHOWN)
    with (tmp_path / "splits.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["split"] for row in rows} == set(SHOWN)
    assert all(float(row["score"]) == pytest.approx(100.0) for row in rows if row["who"] == REFERENCE)


def test_a_study_without_trainings_refuses_their_options(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    assert status(monkeypatch, "splits", "--seeds", 2) == 2
    assert "splits trains nothing: leave out --seeds and --steps" in capsys.readouterr().err
