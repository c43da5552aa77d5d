from dataclasses import replace

import numpy as np
import pytest
import torch

from agents import study
from agents.benchmark.agent_files import from_file
from agents.benchmark.cell_measurement import measure
from agents.benchmark.plan import BenchmarkCell, Request, chosen_problems, planned
from agents.benchmark.results import COLUMNS, merged, read_results, result_of, write_results
from agents.benchmark.scoring import judged
from grind_env.envs.task_names import CORE, shipped_names
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.tuned_parameters import ConfigError
from tests.agents.asking import evaluation, in_process, status

PROBLEM, SLOT = find_problem("oracle6"), find_problem("slot")
ORACLE = PROBLEM.simulation()
TINY = Request(episodes=3, interpolation_episodes=2, plants_episodes=2)


def ground(*cost):
    return evaluation(*cost, good=2.0, finished=4.0)


def found(policy, *cost, seed=None, task="oracle6", between=None, sees="measurements"):
    return result_of(BenchmarkCell(find_problem(task), policy, seed), sees, ground(*cost), between and ground(*between))


ANCHORS = [
    found("constant", 4.0, 6.0, between=(8.0,)),
    found("interval", 5.0, 6.0, between=(3.0,)),
    found("hindsight", 2.0, 2.0, between=(2.0,), sees="future"),
]


def test_the_cells_of_a_plan():
    cells = planned(chosen_problems("slot, oracle6"), ["random", "constant_per_kind"], ["ppo", "plain_gru"], 2)
    # slot has one kind of block
    assert {cell for cell in cells if cell.seed is None} == {
        *(
            BenchmarkCell(problem, name)
            for problem in (SLOT, PROBLEM)
            for name in ("random", "constant", "interval", "hindsight")
        ),
        BenchmarkCell(PROBLEM, "constant_per_kind"),
    }
    assert {cell for cell in cells if cell.seed is not None} == {
        BenchmarkCell(problem, kind, seed)
        for problem in (SLOT, PROBLEM)
        for kind in ("ppo", "plain_gru")
        for seed in (0, 1)
    }
    assert list(map(str, cells[:2])) == ["slot hindsight", "oracle6 hindsight"]
    assert len(cells) == len(set(cells))


def test_named_groups_of_tasks():
    assert tuple(problem.name for problem in chosen_problems("core")) == CORE
    assert sorted(problem.name for problem in chosen_problems("all")) == shipped_names()
    assert [problem.name for problem in chosen_problems("rush,grind/Rush-v0,rush")] == ["rush"]


def test_two_task_files_of_one_name_are_refused(tmp_path):
    (tmp_path / "sub").mkdir()
    files = [tmp_path / "shop.toml", tmp_path / "sub" / "shop.toml"]
    for path in files:
        path.write_text('base = "oracle6"', encoding="utf-8")
    assert len(chosen_problems(f"{files[0]},{files[0]},rush")) == 2
    with pytest.raises(ConfigError, match=r"shop is the name of two problems.*rename the file of one"):
        chosen_problems(",".join(map(str, files)))


def test_a_plan_with_more_agents_than_training_seeds_is_refused():
    with pytest.raises(ConfigError, match="400 training seeds"):
        planned([PROBLEM], None, ["ppo"], 400)


def test_a_measured_cell_equals_its_evaluation(tmp_path):
    measured = measure(BenchmarkCell(PROBLEM, "adaptive_rule"), replace(TINY, runs=tmp_path))
    policy = make_policy("adaptive_rule", ORACLE)
    # the cache of one split does not serve another split of the same seeds
    for found in (measured, measure(BenchmarkCell(PROBLEM, "adaptive_rule"), replace(TINY, runs=tmp_path))):
        expected = run_seeds(policy, ORACLE, episode_seeds("evaluation", 3))
        assert np.array_equal(found.cost, expected.cost.astype(np.float32))
        assert (found.E_mean, found.D_mean, found.scrap) == (expected.speed, expected.dresses, expected.scrap)
        expected = run_seeds(policy, ORACLE, episode_seeds("evaluation", 2), "interpolation")
        assert np.array_equal(found.interpolation_cost, expected.cost.astype(np.float32))
        assert np.array_equal(found.interpolation_good, expected.good.astype(np.float32))
    assert (measured.steps, measured.train_seconds) == (None, None)
    without = replace(TINY, runs=tmp_path, interpolation_episodes=0)
    assert measure(BenchmarkCell(PROBLEM, "random"), without).interpolation_episodes == 0


@pytest.mark.nightly
def test_a_cell_trains_once_and_its_weights_identify_the_agent(tmp_path, monkeypatch):
    cell, request = BenchmarkCell(PROBLEM, "ppo", 1), replace(TINY, runs=tmp_path, steps=7680)
    first = measure(cell, request)
    assert (first.steps, first.trained_on, first.model) == (7680, "all", "nominal")
    assert first.train_seconds > 0.0
    files = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.zip")}
    assert len(files) == 1
    assert np.array_equal(measure(cell, request).cost, first.cost)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.zip")} == files
    (path,) = files
    agent = from_file(path, ORACLE, "ppo-1")
    assert repr(agent) == repr(from_file(path, ORACLE, "ppo-1"))
    with torch.no_grad():
        agent.model.policy.action_net.bias += 1.0
    assert repr(agent) != repr(from_file(path, ORACLE, "ppo-1"))


def test_the_numbers_of_a_row():
    run = ground(3.0, 5.0)
    run.speeds[:] = [[5000.0, 6000.0], [7000.0, 8000.0]]
    row = result_of(BenchmarkCell(SLOT, "ppo", 3), "measurements", run, steps=30, train_seconds=60.0)
    assert (row.kind, row.seed, row.episodes, row.seeds) == ("learned", 3, 2, "2000000..2000001")
    assert (row.interpolation_episodes, row.interpolation_scrap, row.interpolation_seeds) == (0, None, None)
    assert (row.scrap, row.E_mean, row.D_mean) == (0.5, 6500.0, 1.0)
    assert (row.steps, row.train_seconds) == (30, 60.0)
    assert [found(name, 1.0).kind for name in ("handbook", "mpc", "hindsight")] == ["scripted", "planner", "planner"]


def test_scores_are_anchored_at_the_best_fixed_plan_on_the_same_episodes():
    rows = {each.policy: each for each in judged([*ANCHORS, found("ppo", 3.5, 3.5, seed=0, between=(2.5,))])}
    assert rows["constant"].score == 0.0
    assert rows["hindsight"].score == 100.0
    assert rows["interval"].score == pytest.approx(-100.0 / 6.0)
    assert (rows["ppo"].score, rows["ppo"].cost_per_good_part, rows["ppo"].cost_ratio) == (50.0, 1.75, 0.7)
    # in the interpolation contexts the other plan is better
    scores = [rows[name].interpolation_score for name in ("ppo", "interval", "constant")]
    assert scores == [50.0, 0.0, -500.0]
    # resamples: (3.5, 3.5) of constant (4, 4), (4, 6), (6, 6)
    assert (rows["ppo"].score_low, rows["ppo"].score_high) == (25.0, pytest.approx(62.5))


def test_a_plan_per_kind_of_block_counts_as_a_fixed_plan():
    rows = {each.policy: each for each in judged([*ANCHORS, found("constant_per_kind", 3.5, 3.5)])}
    assert (rows["constant_per_kind"].score, rows["hindsight"].score) == (0.0, 100.0)
    assert rows["constant"].score < 0.0


def test_without_an_anchor_there_is_no_score():
    row, _ = judged([found("constant", 4.0, 6.0), found("ppo", 3.0, 3.0, seed=0)])
    assert (row.score, row.score_low, row.cost_ratio) == (None, None, None)
    assert row.cost_per_good_part == 2.5


def test_results_are_read_as_written(tmp_path):
    rows = judged([*ANCHORS, found("ppo", 3.5, 3.5, seed=0)])
    write_results(rows, tmp_path)
    again = read_results(tmp_path)
    for old, new in zip(rows, again, strict=True):
        assert all(np.array_equal(getattr(old, name), getattr(new, name)) for name in (*COLUMNS, "cost", "good"))
    write_results(judged(again), tmp_path / "again")
    for name in ("benchmark.csv", "benchmark.parquet"):
        assert (tmp_path / name).read_bytes() == (tmp_path / "again" / name).read_bytes()
    lines = (tmp_path / "benchmark.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].split(",") == COLUMNS
    assert len(lines) == 5
    (tmp_path / "benchmark.parquet").write_bytes(b"damaged")
    with pytest.raises(ConfigError, match="is damaged"):
        read_results(tmp_path)


def test_new_results_replace_old_ones():
    old = [*ANCHORS, found("ppo", 3.0, 3.0, seed=0, between=(2.0,)), found("ppo", 3.0, 3.0, seed=1, between=(2.0,))]
    new = [found("ppo", 2.0, 2.0, seed=1, between=(2.0,))]
    costs = {each.key: each.cost.tolist() for each in merged([*old, found("random", 9.0, task="slot")], new)}
    assert costs["oracle6", "ppo", 0] == [3.0, 3.0]
    assert costs["oracle6", "ppo", 1] == [2.0, 2.0]
    assert costs["slot", "random", None] == [9.0]
    assert len(costs) == 6
    # a row of three episodes is compared on the two common ones
    assert len(merged(old, [found("ppo", 1.0, 1.0, 1.0, seed=2)])) == len(old) + 1


def test_the_benchmark_command_writes_results_and_a_report(tmp_path, monkeypatch, capsys):
    in_process(monkeypatch)
    episodes = ("--episodes", 3, "--interpolation-episodes", 2, "--plants-episodes", 2)
    tiny = ("benchmark", "--tasks", "oracle6", "--kinds", "", *episodes, "--cache", tmp_path, "--jobs", 1)
    assert status(monkeypatch, *tiny, "--policies", "handbook, adaptive_rule") == 0
    printed = capsys.readouterr().out
    assert "adaptive_rule" in printed
    assert "3 paired episodes" in printed
    first = read_results(tmp_path)
    plans = {"constant", "interval", "constant_per_kind"}
    assert {each.policy for each in first} == {"handbook", "adaptive_rule", "hindsight", *plans}
    assert {each.policy: each.score for each in first}["hindsight"] == 100.0
    csv = (tmp_path / "benchmark.csv").read_bytes()
    assert status(monkeypatch, *tiny, "--policies", "handbook") == 0
    assert (tmp_path / "benchmark.csv").read_bytes() == csv
    assert status(monkeypatch, "benchmark", "--report", "--results", tmp_path) == 0
    assert (tmp_path / "figures/iqm.png").exists()


def test_published_rows_are_not_run_again_and_an_interrupt_writes_finished_rows(tmp_path, monkeypatch, capsys):
    in_process(monkeypatch)
    episodes = ("--episodes", 2, "--interpolation-episodes", 0, "--plants-episodes", 0)
    words = ("benchmark", "--tasks", "oracle6", "--kinds", "", *episodes, "--results", tmp_path, "--policies")
    made = []

    def stopped(trials, run, jobs, console, ray, done):
        for trial in trials[:2]:
            done(trial, run(trial))
            made.append(trial.cell.policy)
        raise KeyboardInterrupt

    monkeypatch.setattr(study, "run_all", stopped)
    assert status(monkeypatch, *words, "handbook", "--cache", tmp_path / "one") == 130
    assert sorted(each.policy for each in read_results(tmp_path)) == sorted(made)
    in_process(monkeypatch)
    capsys.readouterr()
    assert status(monkeypatch, *words, "handbook", "--cache", tmp_path / "two", "--hours") == 0
    assert capsys.readouterr().out == "benchmark: 5 runs, 3 to do: about 0.0 core-hours\n"
    assert status(monkeypatch, *words, "handbook", "--cache", tmp_path / "two") == 0
    assert len(read_results(tmp_path)) == 5 and len(list((tmp_path / "two").glob("benchmark/*.json"))) == 3


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("benchmark", "--tasks", "no_such"), "there is no problem 'no_such'"),
        (("benchmark", "--policies", "no_such"), "there is no policy 'no_such'"),
        (("benchmark", "--kinds", "no_such"), "no_such"),
        (("benchmark", "--report", "--results", "no_such"), "there are no results in no_such"),
        (("tune", "--policies", "no_such"), "'no_such' cannot be tuned"),
    ],
)
def test_a_users_mistake_gives_one_sentence(monkeypatch, capsys, arguments, sentence):
    assert status(monkeypatch, *arguments) == 2
    message = capsys.readouterr().err
    assert sentence in message
    assert message.count("\n") == 1
