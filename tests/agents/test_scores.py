import csv
import shutil
from dataclasses import replace

import pytest

from agents import evaluations
from agents.evaluation_cache import RESULTS
from agents.reference import score_study
from agents.reference.score_study import mean_return, reference_of
from grind_env.envs.task_names import shipped_names
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import make_policy, policy_names
from grind_env.policies.tuned_parameters import CONFIGS, ConfigError
from grind_env.score_scale import read_references, reference
from tests.agents.asking import evaluation, in_process, status, study_options

PROBLEM = find_problem("oracle6")
ORACLE = PROBLEM.simulation()
SCORED = [*map(find_problem, shipped_names())]


def copied_parameters(folder):
    """Return a folder with a copy of the tuned parameters: tuning of a further policy writes there."""
    return shutil.copytree(CONFIGS, folder / "parameters", dirs_exist_ok=True)


def run(folder):
    made = study_options(folder / "results", PROBLEM, episodes=4)
    made = replace(made, configs=copied_parameters(folder), options=replace(made.options, runs=folder / "runs"))
    score_study.study(made).publish_to(folder / "results", made.options)


def test_a_score_run_writes_the_table_and_the_reference_scores(tmp_path, monkeypatch):
    evaluated = []

    def counted(policy, *arguments):
        evaluated.append(policy.name)
        return run_seeds(policy, *arguments)

    in_process(monkeypatch)
    monkeypatch.setattr(evaluations, "run_seeds", counted)
    run(tmp_path)
    assert evaluated == policy_names(ORACLE)
    with (tmp_path / "results/oracle6.csv").open(encoding="utf-8") as file:
        rows = {row["policy"]: row for row in csv.DictReader(file)}
    assert list(rows) == policy_names(ORACLE)
    assert {row["task"] for row in rows.values()} == {"oracle6"}
    assert (rows["random"]["seeds"], rows["hindsight"]["seeds"]) == ("2000000..2000003", "2000000..2000003")
    scale = read_references(tmp_path / "results" / "scores.toml")["grind/Oracle6-v0"]
    # the exact optimum of six parts
    assert scale.J_plan == pytest.approx(12.3664, rel=1e-3)
    assert scale.hundred == pytest.approx(-12.3664 / ORACLE.task.reference_cost, rel=1e-3)
    assert scale.fixed_plan == "constant_per_kind"
    assert float(rows["constant_per_kind"]["score"]) == 0.0
    assert float(rows["interval"]["score"]) == pytest.approx(
        100.0 * (scale.zero - scale.returns["interval"].value) / (scale.zero - scale.hundred), rel=1e-3
    )
    # finished evaluations are read from the cache
    (tmp_path / "runs/oracle6/cells/handbook/2000000.npz").unlink()
    evaluated.clear()
    run(tmp_path)
    assert evaluated == ["handbook"]


def test_missing_parameters_are_tuned_in_the_folder_of_runs(tmp_path, monkeypatch):
    asked = []

    def stopped(problem, names, **settings):
        asked.append((problem.name, settings["runs"]))
        raise ConfigError("tuned")

    monkeypatch.setattr(score_study, "tune", stopped)
    with pytest.raises(ConfigError, match="tuned"):
        run(tmp_path)
    assert asked == [("oracle6", tmp_path / "runs")]


def test_references_are_anchored_at_the_best_plan_and_the_planner():
    task = replace(ORACLE.task, reference_cost=2.0)
    costs = {
        "constant": (10.0, 12.0, 30.0),
        "interval": (11.0, 13.0, 14.0),
        "adaptive_rule": (8.0, 8.0, 8.0),
        "full_state_rule": (7.0, 7.0, 7.0),
        "hindsight": (6.0, 4.0, 5.0),
    }
    found = {name: evaluation(*cost, blocks=6) for name, cost in costs.items()}
    scale = reference_of(task, [make_policy(name, ORACLE) for name in costs], found)
    assert (scale.fixed_plan, scale.best_scripted) == ("interval", "adaptive_rule")
    assert (scale.zero, scale.hundred) == (-6.3333, -2.5)
    assert (scale.J_fix, scale.J_plan) == (pytest.approx(38.0 / 3.0, abs=1e-4), 5.0)
    # -5.5, -6.5, -7: mean -6.3333, standard deviation 0.76376, over the root of 3
    assert scale.returns["interval"] == (-6.3333, 0.441)
    assert mean_return(task, evaluation(3.0)) == (-1.5, 0.0)


@pytest.mark.parametrize(("planner", "ratio"), [(99.0, True), (98.0, True), (97.9, False), (60.0, False)])
def test_a_planner_with_hardly_any_saving_gives_a_ratio(planner, ratio):
    costs = {"constant": (99.0, 101.0), "interval": (120.0, 130.0), "hindsight": (planner - 1.0, planner + 1.0)}
    found = {name: evaluation(*cost, blocks=6) for name, cost in costs.items()}
    task = replace(ORACLE.task, reference_cost=2.0)
    assert reference_of(task, [make_policy(name, ORACLE) for name in costs], found).ratio is ratio


def test_only_tasks_with_hardly_any_saving_of_the_planner_have_a_ratio():
    ratios = {problem.name for problem in SCORED if reference(problem.id).ratio}
    saved = {problem.name: 1.0 - reference(problem.id).J_plan / reference(problem.id).J_fix for problem in SCORED}
    assert ratios == {name for name, share in saved.items() if share <= 0.02} == {"slot"}


def checked_in(table):
    with (RESULTS / f"{table}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("problem", SCORED, ids=lambda problem: problem.name)
def test_the_checked_in_tables_have_every_policy_of_their_task(problem):
    names = policy_names(problem.simulation())
    assert [row["policy"] for row in checked_in(problem.name)] == names
    assert list(reference(problem.id).returns) == names


def test_the_scores_command_writes_references_of_package_tasks_only(tmp_path, monkeypatch, capsys):
    def command(*arguments):
        return status(monkeypatch, "scores", *arguments, "--results", tmp_path, "--cache", tmp_path / "runs", *configs)

    in_process(monkeypatch)
    configs = ("--parameters", copied_parameters(tmp_path))
    assert command("--task", "oracle6", "--episodes", 2) == 0
    assert set(read_references(tmp_path / "scores.toml")) == {"grind/Oracle6-v0"}
    capsys.readouterr()
    # a user's task file gets no reference scores
    shop = tmp_path / "shop.toml"
    shop.write_text('base = "oracle6"\n', encoding="utf-8")
    assert command("--task", shop) == 2
    assert "shop has no reference scores" in capsys.readouterr().err
    assert set(read_references(tmp_path / "scores.toml")) == {"grind/Oracle6-v0"}
