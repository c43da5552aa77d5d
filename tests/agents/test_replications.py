"""`python -m agents replicate`: published results on new seeds."""

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from agents.benchmark.cpu_time import DECISION
from agents.benchmark.plan import HELD_OUT, BenchmarkCell
from agents.benchmark.replication_study import check_sets, compared, page, replicate, verdicts_of
from agents.benchmark.results import Result, read_results, result_of
from agents.evaluation_cache import RESULTS
from agents.study import Options
from grind_env.envs.distribution_splits import EVERY
from grind_env.envs.task_names import CORE
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.nominal_model import model_beside, on
from grind_env.policies.policy import Sees
from grind_env.policies.policy_lookup import SHIPPED, named_policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.score_statistics import prediction
from grind_env.policies.tuned_parameters import ConfigError
from tests.agents.asking import evaluation, in_process, status

ORACLE, RUSH = find_problem("oracle6"), find_problem("rush")
FIRST = 7_000_000


def row(policy: str, cost: np.ndarray, seed: int | None = None) -> Result:
    sees: Sees = "future" if policy == "hindsight" else "measurements"
    return result_of(BenchmarkCell(RUSH, policy, seed), sees, evaluation(*cost))


@pytest.mark.nightly
def test_the_interval_covers_the_mean_on_other_seeds_at_its_confidence() -> None:
    rng = np.random.default_rng(1)
    known = [row("constant", rng.gamma(2.0, 3.0, 256)) for _ in range(40)]
    found = [{FIRST: [row("constant", rng.gamma(2.0, 3.0, 64))]} for _ in known]
    told = [compared([one], others)[0] for one, others in zip(known, found, strict=True)]
    assert sum(each.holds for each in told) >= 35
    # the width for means of normal numbers
    width = 2.0 * 1.96 * 3.0 * np.sqrt(2.0) * np.sqrt(1.0 / 256 + 1.0 / 64)
    assert np.mean([each.high - each.low for each in told]) == pytest.approx(width, rel=0.05)
    (dearer,) = compared(known[:1], {FIRST: [row("constant", 9.0 + rng.gamma(2.0, 3.0, 64))]})
    assert not dearer.holds and dearer.found > dearer.high


@pytest.mark.nightly
def test_published_rows_hold_on_other_machines_at_their_confidence() -> None:
    episodes, rows = 128, read_results(RESULTS)
    held = []
    for problem in map(find_problem, CORE):
        machines = on(problem, HELD_OUT)
        for each in rows:
            bundled = each.seed is None or (each.seed == 0 and (SHIPPED / each.policy).is_dir())
            if each.task != problem.name or not bundled or each.policy in DECISION or not len(each.plants_cost):
                continue
            policy, expected = named_policy(each.policy, problem.simulation()), prediction(each.plants_cost, episodes)
            for first in range(31_000_000, 31_000_000 + 24 * episodes, episodes):
                seeds = range(first, first + episodes)
                found = run_seeds(policy, machines.simulation(), seeds, EVERY, model_beside(machines)).cost.mean()
                held.append(expected.low <= found <= expected.high)
    print(f"{100.0 * np.mean(held):.1f} % of {len(held)} means are inside the 95 % prediction intervals")
    assert len(held) > 24 * 7 * 10 and np.mean(held) >= 0.93


def test_the_verdict_takes_the_agent_and_rule_published_as_best() -> None:
    rng = np.random.default_rng(2)
    costs = {"constant": 9.0, "interval": 9.5, "adaptive_rule": 7.0, "handbook": 8.0, "hindsight": 1.0}
    agents = {"plain_gru": 5.0, "plain_belief": 6.0}

    def rows(**other: float) -> list[Result]:
        shared = rng.normal(0.0, 0.1, 40)
        kinds = {**dict.fromkeys(costs), **dict.fromkeys(agents, 0)}
        return [row(name, {**costs, **agents, **other}[name] + shared, seed) for name, seed in kinds.items()]

    published, found = rows(), rows(plain_belief=4.0, handbook=6.5)
    (verdict,) = verdicts_of(published, found)
    assert (verdict.agent, verdict.rule) == ("plain_gru", "adaptive_rule")
    assert verdict.over.value == pytest.approx(25.0) and verdict.score.value == pytest.approx(50.0)
    best = row("robust", published[0].cost - 8.9, 0)  # its agent is no longer there
    text = page([*published, best], {FIRST: found}, compared(published, {FIRST: found}))
    assert "in 1 of 1 tasks" in text and "| rush | the model | 5 of 7 |" in text


def test_published_policies_are_run_on_other_seeds_and_cached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def agents(*words: object) -> str:
        assert status(monkeypatch, *words) == 0
        return capsys.readouterr().out

    in_process(monkeypatch)
    few = ("--kinds", "", "--policies", "handbook", "--episodes", 8, "--interpolation-episodes", 0)
    agents("benchmark", "--task", "oracle6", *few, "--plants-episodes", 4, "--jobs", 1, "--cache", tmp_path)
    again = ("--published", tmp_path, "--first-seed", FIRST, "--episodes", 4, "--jobs", 1, "--cache", tmp_path)
    words = ("replicate", *again)
    said = agents(*words)
    # no agent was trained
    assert "## Learned against scripted" not in said and "| oracle6 | held-out machines |" in said
    with (tmp_path / "replications.csv").open(encoding="utf-8", newline="") as file:
        rows = {(each["policy"], each["on"]): each for each in csv.DictReader(file)}
    simulation = ORACLE.simulation()
    there = run_seeds(make_policy("handbook", simulation), simulation, range(FIRST, FIRST + 4))
    assert float(rows["handbook", "the model"]["found"]) == pytest.approx(there.cost.mean())
    published = {each.policy: each for each in read_results(tmp_path)}
    assert published["handbook"].seeds == "2000000..2000007"
    assert float(rows["handbook", "the model"]["published"]) == pytest.approx(published["handbook"].cost.mean())
    assert rows["handbook", "the model"]["seeds"] == f"{FIRST}..{FIRST + 3}"
    written = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.npz")}
    agents(*words)
    assert all(path.stat().st_mtime_ns == time for path, time in written.items())


def test_agents_missing_in_the_cache_are_left_out_and_not_trained(tmp_path: Path) -> None:
    out, cost = io.StringIO(), np.full(4, 5.0)
    both = ("handbook", None), ("plain_belief", 0)
    published = [replace(row(policy, cost, seed), task="oracle6") for policy, seed in both]
    options = Options(runs=tmp_path, console=Console(file=out, width=200))
    study = replicate(published, [ORACLE], [FIRST], 2, None, options)
    assert [trial.cell.policy for trial in study.trials] == ["handbook"]
    assert "left out, because their agents are not in the cache: oracle6 plain_belief" in out.getvalue()
    assert not list(tmp_path.rglob("*.safetensors"))


@pytest.mark.parametrize(
    ("firsts", "said"),
    [
        ([2_000_000], "has the evaluation seeds, 2000000 to 2499999"),
        ([499_999 + 2_000_000], "has the evaluation seeds"),
        ([499_950], "has the training seeds"),
        ([FIRST, FIRST + 63], f"has seeds of the set from {FIRST}"),
    ],
)
def test_used_or_overlapping_seeds_are_refused(firsts: list[int], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        check_sets(firsts, 64)
    check_sets([2_500_000, FIRST, FIRST + 64], 64)


def test_missing_results_are_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ended = status(monkeypatch, "replicate", "--published", tmp_path, "--cache", tmp_path)
    said = capsys.readouterr().err
    assert (ended, said.count("\n")) == (2, 1) and "run `python -m agents benchmark` first" in said
    assert not list(tmp_path.iterdir())
