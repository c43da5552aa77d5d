"""Judgements of policies: costs, scores, seeds and splits."""

import json

import numpy as np
import pytest

from grind_env.errors import GrindError
from grind_env.policies import scoring
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.evaluation import run_seeds as run
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.scoring import Judgement, evaluate
from grind_env.policies.scripted.rules import Fixed
from grind_env.policies.tuned_parameters import ConfigError
from grind_env.score_scale import find_reference, normalise
from tests.command import Grind

PLATES = find_problem("power_limited")
SIMULATION = PLATES.simulation()
SCALE = find_reference(PLATES.id)
EPISODES = 6


def judged(name: str, **seeds: object) -> Judgement:
    return evaluate(make_policy(name, SIMULATION), PLATES, episodes=EPISODES, **seeds)


def test_a_score_compares_with_the_fixed_plan_on_the_same_episodes() -> None:
    found = judged("adaptive_rule")
    seeds = episode_seeds("evaluation", EPISODES)
    mine, fixed = (
        run(make_policy(name, SIMULATION), SIMULATION, seeds) for name in ("adaptive_rule", SCALE.fixed_plan)
    )
    # 100 is the share of the cost that the planner saves in the reference scores
    saved, most = 1.0 - mine.cost.mean() / fixed.cost.mean(), 1.0 - SCALE.hundred / SCALE.zero
    assert found.score.value == pytest.approx(100.0 * saved / most)
    assert found.score.low < found.score.value < found.score.high
    assert (found.paired, found.seeds, found.split, found.sees) == (True, "evaluation", "all", "measurements")
    np.testing.assert_array_equal(found.evaluation.cost, mine.cost)
    assert found.evaluation.cost_per_good_part.value == pytest.approx(mine.cost.sum() / mine.good.sum())


def test_the_fixed_plan_scores_zero() -> None:
    assert judged(SCALE.fixed_plan).score == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("asked", "title", "paired"),
    [
        ({}, "evaluation seeds, split all", True),
        ({"seeds": "evaluation", "split": "all"}, "evaluation seeds, split all", True),
        ({"first_seed": 2_000_000}, "seeds 2000000 to 2000005, split all", True),
        ({"seeds": "validation"}, "validation seeds, split all", False),
        ({"split": "interpolation"}, "evaluation seeds, split interpolation", False),
        ({"seeds": "training", "split": "inner"}, "training seeds, split inner", False),
        ({"first_seed": 77}, "seeds 77 to 82, split all", False),
        ({"first_seed": 2_000_001}, "seeds 2000001 to 2000006, split all", False),
        ({"first_seed": 2_000_000, "split": "inner"}, "seeds 2000000 to 2000005, split inner", False),
        ({"first_seed": 3_000_000}, "seeds 3000000 to 3000005, split all", False),
    ],
)
def test_a_judgement_states_its_seeds_split_and_pairing(asked: dict[str, object], title: str, paired: bool) -> None:
    found = judged("handbook", **asked)
    numbers = found.numbers()
    assert (found.paired, numbers["paired"]) == (paired, paired)
    first, line, _, last = str(found).splitlines()
    assert first.startswith("handbook in power_limited: ") and found.title in found._repr_html_()
    assert last == found.basis == f"{EPISODES} episodes, {title}; sees measurements"
    seeds, _, split = title.rpartition(", split ")
    assert (
        (numbers["seeds"], numbers["split"])
        == (found.seeds, found.split)
        == (seeds.replace("seeds", "").strip(), split)
    )
    assert line.startswith("score ")
    assert ("unpaired: 100 is taken from other episodes (evaluation seeds, split all)" in line) == (not paired)


def test_a_split_uses_the_evaluation_seeds_with_its_own_contexts() -> None:
    plan, seeds = make_policy("handbook", SIMULATION), episode_seeds("evaluation", EPISODES)
    costs = {name: judged("handbook", split=name).evaluation.cost for name in ("all", "inner", "interpolation")}
    for name, cost in costs.items():
        np.testing.assert_array_equal(cost, run(plan, SIMULATION, seeds, name).cost)
    assert not any((costs["all"] == costs[name]).any() for name in ("inner", "interpolation"))
    # the fixed plan grinds the contexts of the split, too
    assert judged(SCALE.fixed_plan, split="interpolation").score == (0.0, 0.0, 0.0)


def test_the_extrapolation_split_has_no_score() -> None:
    found = judged("handbook", split="extrapolation")
    seeds = episode_seeds("evaluation", EPISODES)
    cost = run(make_policy("handbook", SIMULATION), SIMULATION, seeds, "extrapolation").cost
    np.testing.assert_array_equal(found.evaluation.cost, cost)
    assert (found.score, "score" in str(found), "score" in found.numbers()) == (None, False, False)


def test_without_a_tuned_fixed_plan_a_score_uses_the_reference_means(monkeypatch: pytest.MonkeyPatch) -> None:
    rule = make_policy("adaptive_rule", SIMULATION)

    def untuned(*arguments: object) -> None:
        raise ConfigError("nothing is tuned")

    monkeypatch.setattr(scoring, "make_policy", untuned)
    found = evaluate(rule, PLATES, episodes=EPISODES)
    wanted = normalise(PLATES.id, -found.evaluation.cost.mean() / SIMULATION.task.reference_cost)
    assert found.score.value == pytest.approx(wanted)
    assert found.score.low < wanted < found.score.high
    assert not found.paired
    assert "unpaired" in str(found)


def test_a_task_with_nothing_to_gain_has_no_score() -> None:
    found = evaluate(Fixed(9000.0, 1), "slot", episodes=2)
    assert found.score is None
    assert "score" not in str(found)
    assert not {"score", "paired"} & set(found.numbers())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"episodes": 1}, "1 episodes have no interval: evaluate 2 at least"),
        ({"split": "exam"}, "split is 'exam', but must be one of all, inner, interpolation, extrapolation"),
        ({"split": "training"}, "it names contexts; training, validation and evaluation are seeds"),
        ({"split": "test"}, "split is 'test', which is called 'interpolation' now"),
        ({"seeds": "exam"}, "there are no seeds 'exam': the seeds are training, validation, evaluation"),
        ({"seeds": "test"}, "contexts are named by the split, all, inner, interpolation, extrapolation"),
        ({"seeds": "training", "first_seed": 5}, "seeds is 'training', and the first seed is 5: give one of both"),
        ({"episodes": 10**6}, "1000000 episodes are asked for, but there are 1 to 500000 evaluation seeds"),
        ({"first_seed": -1}, "the first seed is -1: give 0 or more"),
    ],
)
def test_invalid_arguments_are_refused_in_one_sentence(arguments: dict[str, object], sentence: str) -> None:
    with pytest.raises(GrindError) as caught:
        evaluate("handbook", "power_limited", **arguments)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_without_good_parts_evaluate_says_so_and_its_json_has_null_costs(grind: Grind) -> None:
    words = ("evaluate", "--policy", "E30000D0", "--task", "power_limited", "--episodes", "2")
    status, said, error = grind(*words)
    assert (status, error) == (0, "") and ": no good part\n" in said and "\n100.00 % scrap" in said
    found = json.loads(grind(*words, "--json")[1], parse_constant=pytest.fail)
    assert [found[name] for name in ("cost_per_good_part", "low", "high")] == [None] * 3
