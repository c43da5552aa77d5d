import csv
import shutil
from dataclasses import replace

import numpy as np
import pytest

from agents import evaluations
from agents.evaluations import Evaluations, by_problem, chunks
from agents.reference.adaptation_gaps import (
    ADAPTING_D,
    ADAPTING_E,
    BEST,
    BOTH,
    DRESS,
    FIXED,
    HINDSIGHT,
    KNOWN,
    PLANNER,
    PROMISES,
    SPEED,
    STATE,
    Gap,
    TaskGaps,
    page,
    task_gaps,
)
from agents.tuning.rule_tuning import tune
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import ABLATIONS, make_policy
from grind_env.policies.score_statistics import Interval
from grind_env.policies.tuned_parameters import CONFIGS
from tests.agents.asking import evaluation, in_process, status, study_options

ORACLE = find_problem("oracle6")
SIMULATION, PAIR = ORACLE.simulation(), ("random", "mpc")
SMALL = {"evaluations": 8, "starts": 1, "episodes": 1}


def parameters(folder):
    """Return a folder of the tuned parameters, with quickly tuned parameters of the ablations."""
    place = shutil.copytree(CONFIGS, folder / "parameters")
    tune(ORACLE, list(ABLATIONS), folder=place, runs=folder / "tuning", **SMALL)
    return place


def test_gaps_by_hand(tmp_path):
    found = {
        "constant": (20.0, 24.0),
        "interval": (16.0, 24.0),
        "adaptive_speed": (15.0, 21.0),
        "adaptive_dress": (10.0, 22.0),
        "adaptive_rule": (10.0, 14.0),
        "look_ahead": (9.0, 13.0),
        "full_state_rule": (7.0, 8.0),
        "mpc": (9.0, 11.0),
        "hindsight": (8.0, 8.0),
    }
    of = task_gaps(ORACLE, {who: evaluation(*cost, blocks=6) for who, cost in found.items()}, parameters(tmp_path))
    assert {what: gap.policy for what, gap in of.gaps.items()} == {
        FIXED: "interval",
        SPEED: "adaptive_speed",
        DRESS: "adaptive_dress",
        BOTH: "adaptive_rule",
        # the cheapest policy on measurements
        BEST: "look_ahead",
        PLANNER: "mpc",
        HINDSIGHT: "hindsight",
        ADAPTING_E: "adaptive_rule",
        ADAPTING_D: "adaptive_rule",
        STATE: "full_state_rule",
    }
    savings = {what: gap.saving.value for what, gap in of.gaps.items()}
    # shares of 20 $ an episode
    plain = {FIXED: 0.0, SPEED: 10.0, DRESS: 20.0, BOTH: 40.0, BEST: 45.0, PLANNER: 50.0, HINDSIGHT: 60.0}
    # 12 $ against 16 $ and against 18 $
    assert savings == pytest.approx({**plain, ADAPTING_E: 25.0, ADAPTING_D: 100.0 / 3.0, STATE: 62.5})
    assert of.gaps[ADAPTING_E].against == "adaptive_dress"
    assert of.gaps[ADAPTING_D].against == "adaptive_speed"
    assert of.gaps[BEST].score.value == pytest.approx(75.0)
    # six blocks
    assert of.gaps[FIXED].cost.value == pytest.approx(20.0 / 6.0)
    assert replace(of, reference_cost=20.5 / 6.0).off == pytest.approx(2.5)
    # both episodes alike: 10 of 16 and 14 of 24 are 37.5 and 41.7 %
    low, high = of.gaps[BOTH].saving[1:]
    assert (low, high) == pytest.approx((37.5, 100.0 * 10.0 / 24.0))
    # 0 % in the first episode, 36 % in the second
    assert of.gaps[ADAPTING_E].saving.low == 0.0


def test_a_task_without_a_planner_has_no_planner_gap(tmp_path):
    names = ("constant", "interval", "adaptive_speed", "adaptive_dress", "adaptive_rule", "hindsight")
    of = task_gaps(ORACLE, {name: evaluation(9.0, 8.0, blocks=6) for name in names}, parameters(tmp_path))
    assert PLANNER not in of.gaps
    assert "| oracle6 | 1.417 ± 0.083 |" in page([of], 2)


def gaps_of(task, *, planner=20.0, speed=9.0, dress=11.0, best=80.0, off=0.0):
    """Return the gaps of a task with these figures."""

    def gap(saving, score=0.0):
        return Gap("", "", "measurements", Interval(4.0, 3.9, 4.1), "", Interval(saving, 0, 0), Interval(score, 0, 0))

    savings = {FIXED: gap(0.0), PLANNER: gap(planner), ADAPTING_E: gap(speed), ADAPTING_D: gap(dress)}
    return TaskGaps(task, 4.0 * (1.0 + 0.01 * off), {**savings, BEST: gap(0.0, best)})


def verdicts(*tasks):
    return [promise.verdict(tasks)[0] for promise in PROMISES]


def test_each_promise_is_judged_at_its_threshold():
    good = [gaps_of(name) for name in ("a", "b", "c", "d")]
    assert verdicts(*good) == [True] * 5
    # three tasks are enough for E, four are wanted for D
    assert verdicts(*good[:3]) == [True, True, False, True, True]
    assert verdicts(*good[:2], gaps_of("c", speed=7.9), gaps_of("d")) == [True] * 5
    assert verdicts(gaps_of("a", planner=14.9), *good[1:]) == [False, True, True, True, True]
    assert verdicts(gaps_of("a", best=97.1), *good[1:]) == [True, True, True, False, True]
    assert verdicts(gaps_of("a", off=-1.1), *good[1:]) == [True, True, True, True, False]
    assert PROMISES[0].verdict([*good[:1], gaps_of("z", planner=14.0)]) == (False, "a 20 %", "z 14 %")


def test_evaluations_in_processes_equal_evaluations_in_one(tmp_path, monkeypatch):
    alone = {name: run_seeds(make_policy(name, SIMULATION), SIMULATION, range(2_000_000, 2_000_003)) for name in PAIR}
    # only the worker processes evaluate
    monkeypatch.setattr(evaluations, "run_seeds", None)
    pair = study_options(tmp_path, ORACLE, episodes=3)
    study = Evaluations(name="pair", title="", trials=chunks(pair, lambda problem: PAIR))
    found = by_problem(study.found(replace(pair.options, jobs=2)))[ORACLE]
    assert list(found) == list(PAIR)
    for name in PAIR:
        np.testing.assert_array_equal(found[name].cost, alone[name].cost)
        np.testing.assert_array_equal(found[name].executions, alone[name].executions)


@pytest.mark.nightly
def test_the_gaps_command_writes_and_caches_its_results(tmp_path, monkeypatch, capsys):
    def command():
        words = ("--task", "oracle6", "--episodes", 3, "--jobs", 1, "--parameters", place)
        return status(monkeypatch, "gaps", *words, "--cache", tmp_path / "runs", "--results", tmp_path / "results")

    in_process(monkeypatch)
    place = parameters(tmp_path)
    assert command() == 0
    printed = capsys.readouterr().out
    assert "Cost, $ per block" in printed
    assert "the planner saves 15 %" in printed
    with (tmp_path / "results" / "gaps.csv").open(encoding="utf-8") as file:
        rows = {row["what"]: row for row in csv.DictReader(file)}
    assert list(rows) == [FIXED, SPEED, DRESS, BOTH, BEST, PLANNER, HINDSIGHT, ADAPTING_E, ADAPTING_D, *KNOWN]
    assert {row["seeds"] for row in rows.values()} == {"2000000..2000002"}
    assert float(rows[HINDSIGHT]["score"]) == pytest.approx(100.0)
    written = (tmp_path / "results" / "gaps.md").read_text(encoding="utf-8")
    # every evaluation is cached
    monkeypatch.setattr(evaluations, "run_seeds", None)
    assert command() == 0
    assert (tmp_path / "results" / "gaps.md").read_text(encoding="utf-8") == written
