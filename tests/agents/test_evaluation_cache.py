from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from agents import evaluation_cache
from agents.evaluation_cache import CHUNK, bare, behaviour, cached_evaluation, imported, sources
from grind_env.belief import ensemble_filter as filter_
from grind_env.belief import wheel_belief
from grind_env.envs import filter_members
from grind_env.policies.evaluation import Evaluation, run_seeds
from grind_env.policies.learned.network import LearnedPolicy
from grind_env.policies.planners import dynamic_programming, hindsight, known_state
from grind_env.policies.planners.hindsight import Hindsight
from grind_env.policies.planners.known_state import ModelPredictive
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import TUNED, UNTUNED
from grind_env.policies.scripted import belief_rule, handbook, rules, sharpness_estimator
from grind_env.policies.scripted.belief_rule import BeliefRule
from grind_env.policies.scripted.handbook import Handbook
from grind_env.policies.scripted.rules import Fixed
from tests.examples import few
from tests.policies.harness import changed

PROBLEM = find_problem("oracle6")
ORACLE = PROBLEM.simulation()
PLAN = Fixed(9000.0, 1, 2, "interval")
SEEDS = range(10, 10 + CHUNK + 5)
BELIEVING = BeliefRule(E=(11e3, 7e3), A_dress=(0.02, 0.012), gA=-0.4, gF=0.1, gH=0.2, wV=0.3, wH=0.6, gK=0.2, wK=0.5)


@pytest.fixture
def evaluated(monkeypatch):
    """Return a list that collects the seeds of every evaluation."""
    runs = []

    def counted(policy, simulation, seeds, split, model):
        runs.append(seeds)
        return run_seeds(policy, simulation, seeds, split, model)

    monkeypatch.setattr(evaluation_cache, "run_seeds", counted)
    return runs


def test_a_cached_evaluation_equals_a_fresh_one(tmp_path):
    # for a deterministic policy the chunks do not matter
    whole = run_seeds(PLAN, ORACLE, SEEDS)
    for _ in range(2):
        result = cached_evaluation(PLAN, PROBLEM, SEEDS, tmp_path)
        for each in fields(Evaluation):
            np.testing.assert_array_equal(getattr(result, each.name), getattr(whole, each.name))


def test_only_missing_chunks_are_run(tmp_path, evaluated):
    cached_evaluation(PLAN, PROBLEM, SEEDS[:CHUNK], tmp_path)
    cached_evaluation(PLAN, PROBLEM, SEEDS, tmp_path)
    assert evaluated == [SEEDS[:CHUNK], SEEDS[CHUNK:]]
    evaluated.clear()
    cached_evaluation(PLAN, PROBLEM, SEEDS, tmp_path, fresh=True)
    assert evaluated == [SEEDS[:CHUNK], SEEDS[CHUNK:]]


@pytest.mark.parametrize("text", [b"", b"PK\x03\x04 cut off"])
def test_an_evaluation_in_a_damaged_file_is_run_again(tmp_path, evaluated, text):
    cached_evaluation(PLAN, PROBLEM, SEEDS[:2], tmp_path)
    (file,) = tmp_path.rglob("*.npz")
    file.write_bytes(text)
    cached_evaluation(PLAN, PROBLEM, SEEDS[:2], tmp_path)
    cached_evaluation(PLAN, PROBLEM, SEEDS[:2], tmp_path)
    assert len(evaluated) == 2


def test_another_parameter_or_task_causes_another_evaluation(tmp_path, evaluated):
    cached_evaluation(PLAN, PROBLEM, SEEDS[:2], tmp_path)
    cached_evaluation(replace(PLAN, E=9500.0), PROBLEM, SEEDS[:2], tmp_path)
    cached_evaluation(PLAN, changed(PROBLEM, factors={"kA": 2.5001}), SEEDS[:2], tmp_path)
    assert len(evaluated) == 3


def test_behaviour_follows_the_task_but_not_its_reference_cost():
    code = behaviour(ORACLE)
    assert behaviour(changed(PROBLEM, reference_cost=1.0).simulation()) == code
    assert behaviour(changed(PROBLEM, factors={"kA": 2.5001}).simulation()) != code
    assert behaviour(changed(PROBLEM, dress=replace(ORACLE.task.dress, setup=8.001)).simulation()) != code


def test_bare_code_ignores_comments_docstrings_and_imports():
    code = "def area(x):\n    return 2 * x\n"
    told = '"""Areas."""\nimport math\n\ndef area(x):\n    """An area."""\n    return 2 * x  # twice\n'
    assert bare(told) == bare(code)
    assert bare(code.replace("2", "3")) != bare(code)


def test_the_code_of_a_planner_includes_its_rule():
    found = imported(known_state.__name__)
    names = "scripted.rules", "scripted.sharpness_estimator", "choices"
    assert {f"grind_env.policies.{name}" for name in names} <= {*found}


DECIDING = [
    (Handbook(), handbook),
    (BELIEVING, rules),
    (BELIEVING, belief_rule),
    (BELIEVING, sharpness_estimator),
    (BELIEVING, filter_),
    (BELIEVING, wheel_belief),
    (BELIEVING, filter_members),
    (Hindsight(sweeps=0), hindsight),
    (Hindsight(sweeps=0), dynamic_programming),
]


@pytest.mark.parametrize(("policy", "edited"), few(DECIDING, 3), ids=lambda each: getattr(each, "__name__", None))
def test_an_edit_of_deciding_code_causes_an_evaluation_and_a_comment_does_not(
    policy: Policy, edited: ModuleType, tmp_path: Path, evaluated: list[range], monkeypatch: pytest.MonkeyPatch
) -> None:
    read, more = Path.read_text, [""]

    def with_edit(path: Path, *arguments: Any, **options: Any) -> str:
        return read(path, *arguments, **options) + (more[0] if path.samefile(str(edited.__file__)) else "")

    monkeypatch.setattr(Path, "read_text", with_edit)
    count = 0
    for text, anew in (("", True), ("# a comment\n", False), ('"""A text."""\n', False), ("EDITED = 1\n", True)):
        more[0] = text
        sources.cache_clear()
        cached_evaluation(policy, PROBLEM, SEEDS[:1], tmp_path)
        count += anew
        assert len(evaluated) == count, text
    sources.cache_clear()


def test_the_code_of_a_rule_excludes_other_rules() -> None:
    found = imported(rules.__name__)
    assert not any(name.endswith(("hindsight", "belief_rule", "judging")) for name in found)


def test_the_code_of_a_policy_includes_its_own_module() -> None:
    makers = [*TUNED.values(), *UNTUNED.values(), ModelPredictive, LearnedPolicy]
    modules = {(each.func if isinstance(each, partial) else each).__module__ for each in makers}
    assert len(modules) >= 9
    for name in modules:
        assert name in imported(name)
        assert sources(name) != sources("agents.evaluation_cache.nothing")
