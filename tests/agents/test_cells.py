from dataclasses import fields, replace

import numpy as np
import pytest

from agents import cells
from agents.cells import CHUNK, bare, behaviour, imported, kept_evaluation
from grind_env.policies.evaluation import Evaluation, evaluate
from grind_env.policies.planners import known_state
from grind_env.policies.problem import find_problem
from grind_env.policies.scripted.rules import Fixed
from tests.policies.harness import changed

PROBLEM = find_problem("oracle6")
ORACLE = PROBLEM.simulation()
PLAN = Fixed(9.0, 1, 2, "interval")
SEEDS = range(10, 10 + CHUNK + 5)


@pytest.fixture
def evaluated(monkeypatch):
    """The seeds of every evaluation that is run."""
    runs = []

    def counted(policy, simulation, seeds):
        runs.append(seeds)
        return evaluate(policy, simulation, seeds)

    monkeypatch.setattr(cells, "evaluate", counted)
    return runs


def test_a_kept_evaluation_is_the_evaluation(tmp_path):
    # of a deterministic policy the chunks cannot matter
    whole = evaluate(PLAN, ORACLE, SEEDS)
    for _ in range(2):
        result = kept_evaluation(PLAN, PROBLEM, SEEDS, tmp_path)
        for each in fields(Evaluation):
            np.testing.assert_array_equal(getattr(result, each.name), getattr(whole, each.name))


def test_only_the_chunks_that_are_missing_are_run(tmp_path, evaluated):
    done = []
    kept_evaluation(PLAN, PROBLEM, SEEDS[:CHUNK], tmp_path, advance=done.append)
    kept_evaluation(PLAN, PROBLEM, SEEDS, tmp_path, advance=done.append)
    assert evaluated == [SEEDS[:CHUNK], SEEDS[CHUNK:]]
    assert done == [CHUNK, CHUNK, 5]
    evaluated.clear()
    kept_evaluation(PLAN, PROBLEM, SEEDS, tmp_path, fresh=True)
    assert evaluated == [SEEDS[:CHUNK], SEEDS[CHUNK:]]


@pytest.mark.parametrize("text", [b"", b"PK\x03\x04 cut off"])
def test_a_damaged_file_is_made_anew(tmp_path, evaluated, text):
    kept_evaluation(PLAN, PROBLEM, SEEDS[:2], tmp_path)
    (file,) = tmp_path.rglob("*.npz")
    file.write_bytes(text)
    kept_evaluation(PLAN, PROBLEM, SEEDS[:2], tmp_path)
    kept_evaluation(PLAN, PROBLEM, SEEDS[:2], tmp_path)
    assert len(evaluated) == 2


def test_another_parameter_or_task_is_another_evaluation(tmp_path, evaluated):
    kept_evaluation(PLAN, PROBLEM, SEEDS[:2], tmp_path)
    kept_evaluation(replace(PLAN, E=9.5), PROBLEM, SEEDS[:2], tmp_path)
    kept_evaluation(PLAN, changed(PROBLEM, factors={"kA": 2.5001}), SEEDS[:2], tmp_path)
    assert len(evaluated) == 3


def test_behaviour_follows_the_task_but_not_its_reference_cost():
    code = behaviour(ORACLE)
    assert behaviour(changed(PROBLEM, reference_cost=1.0).simulation()) == code
    assert behaviour(changed(PROBLEM, factors={"kA": 2.5001}).simulation()) != code
    assert behaviour(changed(PROBLEM, dress=replace(ORACLE.task.dress, setup=8.001)).simulation()) != code


def test_comments_docstrings_and_imports_decide_nothing():
    code = "def area(x):\n    return 2 * x\n"
    told = '"""Areas."""\nimport math\n\ndef area(x):\n    """An area."""\n    return 2 * x  # twice\n'
    assert bare(told) == bare(code)
    assert bare(code.replace("2", "3")) != bare(code)


def test_a_planner_stands_on_its_rule_and_not_on_the_learners():
    found = imported(known_state.__name__)
    assert {f"grind_env.policies.{name}" for name in ("scripted.rules", "scripted.estimator", "choices")} <= found
    assert not any(name.startswith("agents.learning") for name in found)
