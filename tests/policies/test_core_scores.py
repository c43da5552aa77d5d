"""A policy in all core tasks: its scores, their mean, and the published rows beside it."""

import json
from pathlib import Path

import numpy as np
import pytest

import grind_env
from grind_env.envs.task_names import CORE, environment_id
from grind_env.policies.core_scores import BoardRow
from grind_env.policies.scripted.rules import Fixed
from grind_env.score_scale import normalise, reference
from tests.command import Grind

PAGE = Path(grind_env.__file__).parents[1] / "docs" / "benchmark" / "submit.md"
POLICY = PAGE.read_text(encoding="utf-8").partition("%%writefile my_rule.py\n")[2].partition("```")[0]


@pytest.mark.nightly
def test_the_example_policy_is_compared_with_published_rows_and_verified(
    grind: Grind, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my_rule.py").write_text(POLICY, encoding="utf-8")
    assert len(POLICY.splitlines()) <= 25
    words = ("evaluate", "--core", "--policy", "my_rule:MyRule", "--episodes", 2)
    status, out, err = grind(*words, "--json", "--submit", "rows.json")
    assert (status, err) == (0, "")
    found = json.loads(out)
    assert list(found) == ["my_rule", "best tuned", "plain_gru (bundled)", "mpc"]
    for task in CORE:
        alone = json.loads(grind("evaluate", "--task", task, *words[2:], "--json")[1])
        assert found["my_rule"][task]["value"] == pytest.approx(alone["score"])
        assert found["my_rule"][task]["low"] == pytest.approx(alone["score_low"])
        for row, name in (("best tuned", reference(environment_id(task)).best_scripted), ("mpc", "mpc")):
            mean, error = reference(environment_id(task)).returns[name]
            value, low, high = found[row][task].values()
            ends = [normalise(environment_id(task), mean + side * 1.96 * error) for side in (-1.0, 1.0)]
            assert value == pytest.approx(normalise(environment_id(task), mean))
            assert (low, high) == pytest.approx(ends, abs=0.1 * (high - low))
    middle = sorted(max(found["my_rule"][task]["value"], -100.0) for task in CORE)[1:-1]
    assert found["my_rule"]["IQM"]["value"] == pytest.approx(np.mean(middle))
    status, out, err = grind("verify", "rows.json", "--policy", "my_rule:MyRule")
    assert (status, err) == (0, "") and out.count("re-run of 2 episodes: ") == len(CORE)


def test_the_interval_of_the_mean_treats_tasks_as_independent() -> None:
    draws = np.random.default_rng(1).normal(50.0, 4.0, (4000, 7))
    value, low, high = BoardRow(np.full(7, 50.0), draws).iqm()
    # the mean of the middle five of seven normal numbers has .42 of the deviation of one
    assert value == 50.0 and (low, high) == pytest.approx((50.0 - 1.96 * 1.6, 50.0 + 1.96 * 1.6), abs=0.3)


def test_an_agent_for_each_task_is_named_by_a_pattern(grind: Grind) -> None:
    status, _, err = grind("evaluate", "--core", "--policy", "no_such/{task}.safetensors")
    assert status == 2 and "no_such/power_limited.safetensors" in err


@pytest.mark.parametrize("words", [("--task", "power_limited"), ("--split", "inner"), ("--first-seed", 3)])
def test_core_scores_refuse_another_task_split_or_first_seed(words: tuple[object, ...], grind: Grind) -> None:
    status, out, err = grind("evaluate", "--core", *words)
    assert (status, out) == (2, "") and err.endswith(f"leave out {words[0]}\n")


def test_evaluate_core_accepts_one_policy_for_each_task() -> None:
    policies = {task: Fixed(E=9000.0, D=1, name=f"of {task}") for task in CORE}
    found = grind_env.evaluate_core(policies, episodes=2)
    assert {task: each.policy for task, each in found.judgements.items()} == {task: f"of {task}" for task in CORE}
    assert "| IQM |" in str(found) and "best tuned" in str(found)
