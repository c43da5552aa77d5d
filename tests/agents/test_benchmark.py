import csv
import json
import sys

import numpy as np
import pytest
from rich.console import Console

from agents import __main__, benchmark
from agents.benchmark import kept_evaluation, table_rows
from agents.evaluate import Evaluation
from agents.scripted.rules import Fixed, Random
from grind_env.envs.tasks import load_task

ORACLE = load_task("oracle6")
NAMES = ["random", "handbook", "constant", "interval", "constant_per_kind", "hindsight"]


def evaluation(*cost):
    n = len(cost)
    return Evaluation(np.array(cost), np.ones(n), np.ones(n), np.full((n, 2), 9000.0), np.ones((n, 2)))


def compare(folder, **settings):
    quiet = Console(quiet=True)
    return benchmark.benchmark(ORACLE, NAMES, episodes=3, folder=folder, console=quiet, **settings)


def run(monkeypatch, *arguments):
    """Exit status of the command line."""
    monkeypatch.setattr(sys, "argv", ["agents", *map(str, arguments)])
    with pytest.raises(SystemExit) as stopped:
        __main__.main()
    return stopped.value.code or 0


def test_the_table_is_anchored_at_the_better_fixed_plan():
    costs = {"constant": (4.0, 6.0), "interval": (5.0, 6.0), "hindsight": (2.0, 2.0), "learned": (3.5, 3.5)}
    results = {name: evaluation(*cost) for name, cost in costs.items()}
    rows = {row.policy: row for row in table_rows([Fixed(9.0, 1, name=name) for name in costs], results)}
    assert rows["constant"].score.value == 0.0
    assert rows["hindsight"].score.value == 100.0
    assert rows["interval"].score.value == pytest.approx(-100.0 / 6.0)
    assert rows["learned"].score.value == 50.0
    assert rows["learned"].cost.value == 3.5
    assert (rows["learned"].speed, rows["learned"].executions, rows["learned"].scrap) == (9.0, 1.0, 0.0)


def test_a_benchmark_repeats_bit_by_bit(tmp_path):
    compare(tmp_path / "a")
    compare(tmp_path / "b")
    for name in ("benchmark.csv", "benchmark.md"):
        assert (tmp_path / "a/oracle6" / name).read_bytes() == (tmp_path / "b/oracle6" / name).read_bytes()
    with (tmp_path / "a/oracle6/benchmark.csv").open(encoding="utf-8") as file:
        rows = {row["policy"]: row for row in csv.DictReader(file)}
    assert list(rows) == NAMES
    assert float(rows["hindsight"]["score"]) == 100.0
    assert float(rows["interval"]["score"]) == 0.0
    assert rows["random"]["seeds"] == "2000000..2000002"


def test_a_benchmark_takes_up_finished_policies_and_runs_learned_ones(tmp_path, monkeypatch):
    first = compare(tmp_path)
    evaluated = []

    def counted(policy, *arguments):
        evaluated.append(policy.name)
        return evaluate(policy, *arguments)

    evaluate = benchmark.evaluate
    monkeypatch.setattr(benchmark, "evaluate", counted)
    rows = compare(tmp_path, learned=[Fixed(6.0, 1, name="PPO")])
    assert evaluated == ["PPO"]
    (learned,) = [row for row in rows if row.policy == "PPO"]
    assert [row for row in rows if row is not learned] == first
    assert learned.cost == rows[2].cost
    assert [row.sees for row in rows] == sorted((row.sees for row in rows), key=benchmark.KNOWLEDGE.index)
    evaluated.clear()
    compare(tmp_path, fresh=True)
    assert evaluated == NAMES


def test_what_is_kept_belongs_to_its_parameters_and_seeds(tmp_path):
    def cost(policy, seeds):
        return kept_evaluation(policy, ORACLE, seeds, tmp_path, fresh=False).cost

    first = cost(Random(seed=1), range(2))
    assert not np.array_equal(cost(Random(seed=2), range(2)), first)
    assert len(cost(Random(seed=2), range(3))) == 3
    assert np.array_equal(cost(Random(seed=1), range(2)), first)


def test_command_line(tmp_path, monkeypatch, capsys):
    configs, runs = ("--configs", tmp_path / "configs"), ("--runs", tmp_path / "runs")
    tiny = ("--task", "oracle6", "--episodes", 1)
    assert run(monkeypatch, "tune", *tiny, *configs, "--evaluations", 10) == 0
    assert (
        run(monkeypatch, "benchmark", *tiny, *configs, *runs, "--agents", 0, "--policies", "handbook, adaptive_rule")
        == 0
    )
    printed = capsys.readouterr().out
    assert "adaptive_rule" in printed
    assert "hindsight" in printed
    assert (tmp_path / "runs/oracle6/benchmark.md").exists()
    assert run(monkeypatch, "evaluate", *tiny, *configs, "--policy", "constant", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["E"], answer["D"], answer["split"]) == (6.0, 1.0, "evaluation")
    assert run(monkeypatch, "evaluate", *tiny, *configs, "--policy", "constant") == 0
    assert "$ per good part" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("evaluate", "--policy", "handbook", "--task", "no_such"), "there is no task 'no_such'"),
        (("evaluate", "--policy", "no_such"), "there is no policy 'no_such'"),
        (("evaluate", "--policy", "handbook", "--split", "no_such"), "there is no split 'no_such'"),
        (("evaluate", "--policy", "mpc", "--configs", "no_such"), "full_state_rule has no parameters in no_such"),
        (("benchmark", "--agents", "0", "--policies", "no_such"), "there is no policy 'no_such'"),
        (("tune", "--policies", "no_such"), "'no_such' cannot be tuned"),
    ],
)
def test_a_users_mistake_is_one_sentence(monkeypatch, capsys, arguments, sentence):
    assert run(monkeypatch, *arguments) == 2
    message = capsys.readouterr().err
    assert sentence in message
    assert message.count("\n") == 1


def test_a_damaged_file_is_made_anew(tmp_path):
    first = kept_evaluation(Random(seed=1), ORACLE, range(2), tmp_path, fresh=False)
    (path,) = tmp_path.glob("*.npz")
    path.write_bytes(path.read_bytes()[:100])
    again = kept_evaluation(Random(seed=1), ORACLE, range(2), tmp_path, fresh=False)
    assert np.array_equal(first.cost, again.cost)
