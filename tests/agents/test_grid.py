"""The benchmark grid: agents and rules as cells, their cost, and the conclusions from them."""

from collections import Counter
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from agents.benchmark import grid
from agents.benchmark.agent_training import code_of_training
from agents.benchmark.cell_measurement import measure
from agents.benchmark.page import page, room, verdict
from agents.benchmark.plan import KINDS, chosen_problems, planned
from agents.benchmark.plan import BenchmarkCell as Measurement
from agents.benchmark.plan import Request as Requested
from agents.benchmark.policy_effort import model_of, tuned_on
from agents.benchmark.readme import section
from agents.benchmark.results import merged, result_of
from agents.benchmark.scoring import Sampled, judged
from agents.benchmark.summary import NONE, budget, summaries
from agents.benchmark.trials import BenchmarkTrial, digest, seconds
from grind_env.envs.task_names import CORE
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.planners.hindsight import Hindsight
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.score_statistics import bootstrap
from grind_env.policies.scoring import evaluate
from grind_env.policies.tuned_parameters import ConfigError, read_tuned
from grind_env.training.gru_ppo import Settings, policy_of, train
from tests.agents.asking import evaluation

ORACLE, SLOT = find_problem("oracle6"), find_problem("slot")
RNG = np.random.default_rng(5)
SHARED = RNG.exponential(2.0, 60)
SEES = {"hindsight": "future", "mpc": "state"}


def row(policy, cost, seed=None, task="rush", **made):
    cell, sees = Measurement(find_problem(task), policy, seed), SEES.get(policy.partition("@")[0], "measurements")
    return result_of(cell, sees, evaluation(*cost), **made)


def rows(task="rush"):
    """Return rows: on plans that cost 8, the rule saves 1, agents about 2 and 3, mpc 3.5 and hindsight 4."""
    noise = RNG.normal(0.0, 0.2, (7, 60))
    costs = {"constant": 8.0, "interval": 9.0, "adaptive_rule": 7.0, "belief_planner": 5.4, "mpc": 4.5}
    costs["hindsight"] = 4.0
    found = [row(name, cost + SHARED + noise[k], task=task) for k, (name, cost) in enumerate(costs.items())]
    agents = [("plain_belief", 0, 6.5), ("plain_belief", 1, 6.1), ("plain_gru", 0, 5.0)]
    return found + [row(name, cost + SHARED + noise[6], seed, task=task) for name, seed, cost in agents]


def test_results_are_compared_on_their_common_episodes():
    full = rows()
    short = [replace(each, cost=each.cost[:20], good=each.good[:20], episodes=20) for each in full]
    every, mixed, alone = Sampled(full), Sampled([*full[:-1], short[-1]]), Sampled(short)
    for name in ("scores", "ratios", "costs"):
        for whole, part, both in zip(*(getattr(each, name)() for each in (every, alone, mixed)), strict=True):
            assert both[..., :-1] == pytest.approx(whole[..., :-1])
            assert both[..., -1] == pytest.approx(part[..., -1])
    assert mixed.gain("plain_gru", "constant") == alone.gain("plain_gru", "constant")
    assert len(merged(short, full[:1])) == len(full)
    lines = {line.policy: line for line in summaries(judged([*full[:-1], short[-1]]), "rush")}
    assert (lines["plain_gru"].score.value, lines["mpc"].runs) == (pytest.approx(judged(mixed.results)[-1].score), 1)


def test_a_gain_compares_paired_episodes():
    of = Sampled(rows())
    cost = {each.key[1:]: np.asarray(each.cost, float) for each in of.results}
    ours, theirs, fixed, best = (
        cost[name, seed]
        for name, seed in (("plain_gru", 0), ("adaptive_rule", None), ("constant", None), ("hindsight", None))
    )
    expected = bootstrap(
        lambda a, b, f, p: 100.0 * (b.mean(axis=-1) - a.mean(axis=-1)) / (f.mean(axis=-1) - p.mean(axis=-1)),
        ours,
        theirs,
        fixed,
        best,
    )
    assert of.gain("plain_gru", "adaptive_rule") == pytest.approx(expected)
    # the shared noise widens the interval of each mean cost, but not the interval of the gain
    assert expected.half_width < 5.0 < 196.0 * SHARED.std() / 60**0.5 / (fixed - best).mean()
    runs = [(theirs - cost["plain_belief", seed]).mean() for seed in (0, 1)]
    two = of.gain("plain_belief", "adaptive_rule")
    assert two.value == pytest.approx(100.0 * np.mean(runs) / (fixed - best).mean())
    assert two.half_width > expected.half_width
    assert of.gain("plain_gru", "no_such") is None
    assert Sampled(of.results[:2]).gain("constant", "interval") is None


def test_the_verdict_compares_the_best_small_agent_with_the_best_rule_or_planner():
    found = verdict("rush", Sampled([*rows(), row("plain_gru@3M", 4.2 + SHARED, 0, blocks=3_000_000)]))
    assert (found.agent, found.rule) == ("plain_gru", "belief_planner")
    assert (found.score.value, found.over.value) == pytest.approx((75.0, 10.0), abs=3.0)
    worse = [replace(each, cost=each.cost + 5.0) if each.kind == "learned" else each for each in rows()]
    assert verdict("rush", Sampled(worse)).over.low < 0.0 and "in 0 of 1 tasks and worse in 1" in page(worse)
    assert verdict("rush", Sampled(rows()[:5])) is None


def test_the_room_lies_between_the_best_policy_and_the_planner_on_the_state():
    longer = row("plain_gru@3M", 4.8 + SHARED, 0, blocks=3_000_000)
    ours = rows()
    more = row("hindsight@12", np.asarray(ours[5].cost, float)[:30] - 0.008)
    found = room("rush", Sampled([*ours, longer, more]))
    assert (found.best_known, found.budget) == ("plain_gru@3M", "open")
    assert found.score.value == pytest.approx(80.0, abs=3.0)
    assert found.room.value == pytest.approx(found.on_state.value - found.score.value)
    # 0.8 cents of 4 $
    assert found.searched.value == pytest.approx(0.2, abs=0.01)
    text = page(judged([*ours, longer, more]))
    assert "with 12 (`hindsight@12`) it scores at most 100.2 in any task" in text
    assert "| rush | orders with due dates | lot's dulling rate | 8" in text and "(plain_gru@3M)" in text
    assert page(judged(rows()[:2])).count("##") == 2, "no score, no table of scores"


@pytest.mark.parametrize(("blocks", "said"), [(None, "–"), (0, "1M"), (1_006_080, "1M"), (1_100_000, "open")])
def test_the_budget_class_follows_from_the_blocks(blocks, said):
    assert budget(blocks) == said


@pytest.mark.nightly
def test_a_plain_agent_is_trained_once_and_acts_as_trained(tmp_path):
    request = Requested(episodes=3, interpolation_episodes=0, steps=7680, runs=tmp_path)
    cell = Measurement(ORACLE, "plain_gru", 1)
    first = measure(cell, request)
    (path,) = tmp_path.glob("oracle6/plain_gru-1-*.safetensors")
    written = path.stat().st_mtime_ns
    policy = policy_of(*train(ORACLE, Settings(steps=7680), 1), ORACLE, "gru")
    expected = run_seeds(policy, ORACLE.simulation(), episode_seeds("evaluation", 3))
    assert np.array_equal(first.cost, expected.cost.astype(np.float32))
    assert (first.sees, first.model, first.blocks, first.trained_on) == ("measurements", "none", 7680, "inner")
    assert first.train_seconds > 0.0
    # one update: the only point of the curve is the trained agent
    score = evaluate(policy, ORACLE, seeds="validation", episodes=64).score.value
    assert (first.curve_steps.tolist(), first.curve_score.tolist()) == ([7680], [pytest.approx(score)])
    again = measure(cell, request)
    assert (again.steps, again.train_seconds) == (first.steps, first.train_seconds)
    assert path.stat().st_mtime_ns == written and len(list(tmp_path.glob("oracle6/plain_*"))) == 1


def test_a_longer_training_is_a_variant_with_its_own_trial():
    request = Requested()
    cells = [Measurement(ORACLE, kind, 0) for kind in ("plain_gru", "plain_gru@1M", "plain_gru@3M")]
    assert [cell.steps for cell in cells] == [None, 1_000_000, 3_000_000]
    usual, same, longer = (code_of_training(cell, request) for cell in cells)
    assert usual == same != longer
    assert len({digest(BenchmarkTrial(cell, request)) for cell in cells}) == 3


def test_tuning_effort_and_model_of_each_policy():
    simulation, tuned = ORACLE.simulation(), read_tuned("oracle6")
    assert tuned_on("adaptive_rule", simulation) == tuned["adaptive_rule"].evaluations * 48 * 6
    assert tuned_on("mpc", simulation) == tuned_on("full_state_rule", simulation)
    assert tuned_on("random", simulation) == 0
    holds = {name: model_of(Measurement(ORACLE, name)) for name in ("constant", "look_ahead@1M", "mpc")}
    assert holds == {"constant": "none", "look_ahead@1M": "nominal", "mpc": "exact"}
    assert {kind: model_of(Measurement(ORACLE, kind, 0)) for kind in KINDS} == {
        kind: "nominal" if kind in ("plain_belief", "ppo") else "none" for kind in KINDS
    }


def test_the_grid_has_every_kind_and_stays_within_its_hours():
    cells = grid.grid(chosen_problems("core"), None, None, None)
    assert len(cells) == len(set(cells))
    trained = Counter((each.task, each.policy) for each in cells if each.trains)
    long = [(task, "plain_gru@3M") for task in CORE]
    long += [(task, "plain_gru@10M") for task in ("power_limited", "wide_plates", "blades")]
    assert trained == {**dict.fromkeys(product(CORE, KINDS), 5), **dict.fromkeys(long, 3)}
    names = {each.policy for each in cells if each.task == "rush"}
    assert {"belief_planner", "hindsight", "hindsight@12", "look_ahead"} <= names
    request = Requested(episodes=grid.EPISODES, interpolation_episodes=grid.INTERPOLATION_EPISODES)
    assert sum(seconds(BenchmarkTrial(cell, request)) for cell in cells) <= 10.0 * 3600.0
    few = grid.grid([ORACLE], ["handbook"], ["plain_gru"], 2)
    assert [cell.name for cell in few if cell.trains] == ["plain_gru-0", "plain_gru-1"]


def test_a_longer_search_is_a_variant_on_the_first_episodes(tmp_path):
    request = Requested(episodes=70, interpolation_episodes=2, runs=tmp_path)
    more = measure(Measurement(ORACLE, "hindsight@5"), request)
    expected = run_seeds(Hindsight(5), ORACLE.simulation(), episode_seeds("evaluation", 64)).cost.astype(np.float32)
    assert np.array_equal(more.cost, expected)
    assert (more.interpolation_episodes, more.kind, more.model) == (0, "planner", "exact")
    today = measure(Measurement(ORACLE, "hindsight"), request)
    assert today.episodes == 70
    again = measure(Measurement(ORACLE, "hindsight@5"), request)
    assert np.array_equal(again.cost, expected)


@pytest.mark.parametrize("name", ["hindsight@", "hindsight@x", "mpc@3", "handbook@1M"])
def test_an_invalid_variant_is_refused(name):
    with pytest.raises(ConfigError, match=f"'{name}' is no variant: give hindsight@SWEEPS or AGENT@STEPS"):
        planned([ORACLE], [name], [], 0)
    with pytest.raises(ConfigError, match="no policy 'nobody'"):
        planned([ORACLE], ["nobody"], [], 0)
    with pytest.raises(ConfigError, match="no kind of agent 'plain_gru@x'"):
        planned([ORACLE], [], ["plain_gru@x"], 1)


def test_policies_on_measurements_are_also_judged_on_held_out_machines(tmp_path):
    request = Requested(episodes=2, interpolation_episodes=0, plants_episodes=3, runs=tmp_path)
    found = measure(Measurement(ORACLE, "look_ahead"), request)
    there = evaluate("look_ahead", "oracle6", plant="held-out", episodes=3).evaluation
    there = there.cost.astype(np.float32).tolist()
    assert found.plants_cost.tolist() == there
    assert found.cost.tolist() != there[:2]
    again = measure(Measurement(ORACLE, "look_ahead"), request)
    assert again.cost.tolist() == found.cost.tolist()
    assert measure(Measurement(ORACLE, "mpc"), request).plants_episodes == 0


def test_the_readme_shows_the_cost_per_good_part_on_held_out_machines():
    plain = judged(rows("power_limited"))
    assert all(each.plants_cost_per_good_part is None for each in plain)
    there = np.linspace(5.0, 7.0, 4, dtype=np.float32)
    some = {"plants_episodes": 4, "plants_cost": there, "plants_good": np.ones(4, np.float32), "plants_scrap": 0.021}
    results = judged([replace(each, **some) if each.policy == "belief_planner" else each for each in plain])
    of = {each.policy: each for each in results}
    assert of["belief_planner"].plants_cost_per_good_part == pytest.approx(6.0)
    assert of["constant"].plants_cost_per_good_part is None
    lines = {line.split(" | ")[0][2:]: line for line in section(results).splitlines()}
    assert " | 6.00 ± " in lines["belief_planner"]
    assert lines["constant"].endswith(f" | {NONE} |")
