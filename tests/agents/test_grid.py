"""The grid: agents of the reader's file and limited rules as cells, what they cost, and what is concluded of them."""

from dataclasses import replace

import numpy as np
import pytest

from agents.benchmark import grid
from agents.benchmark.judge import Sampled, judged
from agents.benchmark.measure import measure
from agents.benchmark.page import page, verdict
from agents.benchmark.plan import KINDS, LIMIT, PLAIN, chosen_problems, planned
from agents.benchmark.plan import BenchmarkCell as Measurement
from agents.benchmark.plan import Request as Requested
from agents.benchmark.price import Price, model_of, price_of, tuned_on
from agents.benchmark.readme import section
from agents.benchmark.results import merged, result_of
from agents.benchmark.summary import NONE, summaries
from agents.benchmark.trials import BenchmarkTrial, seconds
from grind_env.envs.names import CORE
from grind_env.policies.choices import Decision
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.judging import evaluate
from grind_env.policies.planners.hindsight import Hindsight, moves
from grind_env.policies.problem import find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.statistics import bootstrap
from grind_env.policies.tuned import ConfigError, read_tuned
from grind_env.training.gru_ppo import SEEN, Settings, policy_of, shown, train
from tests.agents.asking import evaluation

ORACLE, SLOT = find_problem("oracle6"), find_problem("slot")
RNG = np.random.default_rng(5)
SHARED = RNG.exponential(2.0, 60)
SEES = {"hindsight": "future", "plain_state": "state", "mpc": "state"}


def row(policy, cost, seed=None, task="rush", **made):
    cell, sees = Measurement(find_problem(task), policy, seed), SEES.get(policy, "measurements")
    return result_of(cell, sees, evaluation(*cost), price=Price(2, 5.0, 0.25), **made)


def rows(task="rush"):
    """Savings of 1 by the rule, 2 and 3 by agents, and 4 by hindsight, over plans that cost 8."""
    noise = RNG.normal(0.0, 0.2, (6, 60))
    costs = {"constant": 8.0, "interval": 9.0, "adaptive_rule": 7.0, "belief_planner": 5.4, "hindsight": 4.0}
    found = [row(name, cost + SHARED + noise[k], task=task) for k, (name, cost) in enumerate(costs.items())]
    agents = [("plain_none", 0, 6.5), ("plain_none", 1, 6.1), ("plain_gru", 0, 5.0), ("plain_state", 0, 4.5)]
    return found + [row(name, cost + SHARED + noise[5], seed, task=task) for name, seed, cost in agents]


def test_results_of_fewer_episodes_are_compared_on_those_that_all_have():
    full = rows()
    short = [replace(each, cost=each.cost[:20], good=each.good[:20], episodes=20) for each in full]
    mixed = Sampled([*full[:-1], short[-1]])
    alone = Sampled(short)
    for name in ("scores", "ratios", "costs"):
        for whole, part, both in zip(
            getattr(Sampled(full), name)(), getattr(alone, name)(), getattr(mixed, name)(), strict=True
        ):
            assert both[..., :-1] == pytest.approx(whole[..., :-1])
            assert both[..., -1] == pytest.approx(part[..., -1])
    assert mixed.gain("plain_state", "constant") == alone.gain("plain_state", "constant")
    assert len(merged(short, full[:1])) == len(full)
    lines = {line.policy: line for line in summaries(judged([*full[:-1], short[-1]]), "rush")}
    assert (lines["plain_state"].episodes, lines["plain_gru"].episodes) == (20, 60)


def test_a_gain_is_that_of_paired_episodes():
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
    # what all have in common, which makes the mean cost of each uncertain by more, does not widen it
    assert expected.half_width < 5.0 < 196.0 * SHARED.std() / 60**0.5 / (fixed - best).mean()
    runs = [(theirs - cost["plain_none", seed]).mean() for seed in (0, 1)]
    two = of.gain("plain_none", "adaptive_rule")
    assert two.value == pytest.approx(100.0 * np.mean(runs) / (fixed - best).mean())
    assert two.half_width > expected.half_width
    assert of.gain("plain_gru", "no_such") is None
    assert Sampled(of.results[:2]).gain("constant", "interval") is None
    assert of.scale().value == pytest.approx((fixed - best).mean())


def test_the_best_agent_is_held_against_the_best_rule_and_the_planner():
    found = verdict("rush", Sampled(rows()))
    assert (found.agent, found.rule) == ("plain_gru", "adaptive_rule")
    assert (found.score.value, found.over.value, found.behind.value) == pytest.approx((75.0, 50.0, 10.0), abs=3.0)
    assert found.cells[3].endswith("beats it")
    assert found.cells[4].endswith("within 3")
    worse = [replace(each, cost=each.cost + 5.0) if each.kind == "learned" else each for each in rows()]
    found = verdict("rush", Sampled(worse))
    assert found.cells[3].endswith("does not hold")
    assert found.cells[4].endswith("beyond 3")
    assert verdict("rush", Sampled(rows()[:5])) is None


def test_which_kind_is_shipped_is_that_of_its_file_for_the_task():
    # plain_gru costs 5.0: it is that of job_shop, and beyond that of rush
    every = [each for task in ("job_shop", "rush") for each in (*rows(task), row("bc", 5.6 + SHARED, 0, task=task))]
    text = page(judged(every))
    assert "first training of `bc` or `plain_gru` comes with the package for each task: in 1 of 2 no other" in text
    assert "comes with the package" not in page(judged(rows()))


def test_the_page_says_what_is_worth_what_and_how_sure_the_measure_is():
    ours = rows()
    best = np.asarray(ours[4].cost, float)
    ours += [row(f"hindsight@{sweeps}", best[:30] - 0.004 * k) for k, sweeps in enumerate((1, 6, 12), start=-2)]
    text = page(judged([*ours, *rows("blades")]))
    assert "beats the best rule in 2 of 2 tasks" in text
    assert "| rush | – | " in text.partition("## What is worth what")[2], "no stack was run"
    gains = {task: Sampled(rows(task)).gain("plain_gru", "plain_none").value for task in ("rush", "blades")}
    assert all(value == pytest.approx(32.5, abs=4.0) for value in gains.values())
    # 0.4 cents of 4 $
    (line,) = [each for each in text.partition("## Hindsight")[2].splitlines() if each.startswith("| rush |")][:1]
    assert [float(each.split()[0]) for each in line.split(" | ")[1:]] == pytest.approx([-0.2, -0.1, 0.0], abs=0.01)
    assert "gains less than 0.5 points in 1 of 1 tasks." in text
    # every table but those of differences shows the score, second
    (line,) = [each for each in text.partition("### rush")[2].splitlines() if each.startswith("| policy |")][:1]
    assert line.split(" | ")[1] == "score (95 %)"
    assert "## What is worth what" not in page(judged(rows()[:5]))


@pytest.mark.nightly
def test_agents_of_the_readers_file_are_trained_once_and_play_as_they_were_trained(tmp_path):
    assert set(PLAIN.values()) == set(SEEN)
    request = Requested(episodes=3, interpolation_episodes=0, steps=7680, runs=tmp_path)
    for kind, sees in (("plain_gru", "measurements"), ("plain_state", "state")):
        first = measure(Measurement(ORACLE, kind, 1), request)
        (path,) = tmp_path.glob(f"oracle6/{kind}-1-*.safetensors")
        written = path.stat().st_mtime_ns
        problem, memory = shown(ORACLE, PLAIN[kind]), PLAIN[kind]
        policy = policy_of(*train(problem, Settings(memory=memory, steps=7680), 1), problem, memory)
        expected = run_seeds(policy, problem.simulation(), episode_seeds("evaluation", 3))
        assert np.array_equal(first.cost, expected.cost.astype(np.float32))
        assert (first.sees, first.model, first.blocks, first.trained_on) == (sees, "none", 7680, "inner")
        assert first.train_seconds > 0.0
        again = measure(Measurement(ORACLE, kind, 1), request)
        assert (again.steps, again.train_seconds) == (first.steps, first.train_seconds)
        assert path.stat().st_mtime_ns == written
    assert len(list(tmp_path.glob("oracle6/plain_*"))) == 2


def test_a_limited_rule_is_tuned_on_no_more_blocks_and_kept_apart(tmp_path, monkeypatch):
    limit = 48 * 6 * 40
    monkeypatch.setattr("agents.benchmark.measure.LIMIT", limit)
    request = Requested(episodes=3, interpolation_episodes=0, runs=tmp_path)
    limited = measure(Measurement(ORACLE, "adaptive_rule@1M", None), request)
    whole = measure(Measurement(ORACLE, "adaptive_rule", None), request)
    assert limit / 2 < limited.blocks <= limit < whole.blocks
    assert not np.array_equal(limited.cost, whole.cost)
    again = measure(Measurement(ORACLE, "adaptive_rule@1M", None), request)
    assert np.array_equal(again.cost, limited.cost)


def test_what_a_decision_costs_is_counted():
    simulation = ORACLE.simulation()
    constant, hindsight = (price_of(make_policy(name, simulation), simulation) for name in ("constant", "hindsight"))
    assert (constant.begun, constant.calls) == (0, 0.0)
    # by hand: every sweep tries 17 moves of what is left of the six blocks, and takes a step
    more = price_of(Hindsight(sweeps=4), simulation).calls - hindsight.calls
    plan = Decision(np.full((1, 6), 9000.0), np.ones((1, 6)))
    tried = len(moves(simulation.task, plan, np.random.default_rng(0)).speeds)
    assert more == pytest.approx((tried * (6 + 5 + 4 + 3 + 2 + 1) + 6) / 6)
    assert 0.0 < constant.ms < hindsight.ms


def test_a_table_that_is_made_before_is_counted_whatever_is_kept(tmp_path):
    request = Requested(episodes=2, interpolation_episodes=0, runs=tmp_path)
    cell = Measurement(ORACLE, "belief_planner")
    first, again = (measure(cell, request) for _ in range(2))
    assert first.making_calls > 0
    assert (again.making_calls, again.decision_calls) == (first.making_calls, first.decision_calls)


def test_what_policies_were_made_with():
    simulation, tuned = ORACLE.simulation(), read_tuned("oracle6")
    assert tuned_on("adaptive_rule", simulation) == tuned["adaptive_rule"].evaluations * 48 * 6
    assert tuned_on("mpc", simulation) == tuned_on("full_state_rule", simulation)
    assert tuned_on("random", simulation) == 0
    holds = {name: model_of(Measurement(ORACLE, name)) for name in ("constant", "look_ahead@1M", "mpc")}
    assert holds == {"constant": "none", "look_ahead@1M": "nominal", "mpc": "exact"}
    assert {kind: model_of(Measurement(ORACLE, kind, 0)) for kind in KINDS} == {
        kind: "nominal" if kind in ("plain_belief", "ppo") else "none" for kind in KINDS
    }


def test_the_grid_has_every_kind_and_its_hours_are_kept():
    cells = grid.grid(chosen_problems("core"), None, None, None)
    assert len(cells) == len(set(cells))
    seeds = {(task, kind): sum((each.task, each.policy) == (task, kind) for each in cells)
             for task in CORE for kind in KINDS}  # fmt: skip
    assert {count for (task, kind), count in seeds.items() if kind != "ppo" and task != "power_limited"} == {5}
    assert {count for (task, kind), count in seeds.items() if kind != "ppo" and task == "power_limited"} == {10}
    assert {count for (_, kind), count in seeds.items() if kind == "ppo"} == {5}
    names = {each.policy for each in cells if each.task == "rush"}
    assert {"belief_planner", "hindsight", "look_ahead", "belief_rule@1M"} <= names
    # the shipped one was tuned on fewer
    assert "look_ahead@1M" not in names
    assert tuned_on("look_ahead", find_problem("rush").simulation()) < LIMIT
    request = Requested(episodes=grid.EPISODES, interpolation_episodes=grid.INTERPOLATION_EPISODES)
    assert sum(seconds(BenchmarkTrial(cell, request)) for cell in cells) <= 9.0 * 3600.0
    few = grid.grid([ORACLE], ["handbook"], ["plain_gru"], 2)
    assert [cell.name for cell in few if cell.trains] == ["plain_gru-0", "plain_gru-1"]


def test_more_search_is_a_variant_on_the_first_episodes(tmp_path):
    request = Requested(episodes=70, interpolation_episodes=2, runs=tmp_path)
    more = measure(Measurement(ORACLE, "hindsight@5"), request)
    expected = run_seeds(Hindsight(5), ORACLE.simulation(), episode_seeds("evaluation", 64)).cost.astype(np.float32)
    assert np.array_equal(more.cost, expected)
    assert (more.interpolation_episodes, more.kind, more.model) == (0, "planner", "exact")
    today = measure(Measurement(ORACLE, "hindsight"), request)
    assert today.episodes == 70
    again = measure(Measurement(ORACLE, "hindsight@5"), request)
    assert np.array_equal(again.cost, expected)


@pytest.mark.parametrize("name", ["hindsight@", "hindsight@x", "mpc@3", "handbook@2M"])
def test_a_variant_that_cannot_be(name):
    with pytest.raises(ConfigError, match=f"'{name}' is no variant: give RULE@1M or hindsight@SWEEPS"):
        planned([ORACLE], [name], [], 0)
    with pytest.raises(ConfigError, match="no policy 'nobody'"):
        planned([ORACLE], ["nobody@1M"], [], 0)
    assert Measurement(ORACLE, "adaptive_rule@1M") in planned([ORACLE], ["adaptive_rule@1M"], [], 0)


def test_what_sees_measurements_is_judged_on_machines_that_are_held_out_too(tmp_path):
    """As one evaluates it there, the model in its hands; a yardstick that sees more is not."""
    request = Requested(episodes=2, interpolation_episodes=0, plants_episodes=3, runs=tmp_path)
    found = measure(Measurement(ORACLE, "look_ahead"), request)
    there = evaluate("look_ahead", "oracle6", plant="held-out", episodes=3).evaluation
    there = there.cost.astype(np.float32).tolist()
    assert found.plants_cost.tolist() == there
    assert found.cost.tolist() != there[:2]
    again = measure(Measurement(ORACLE, "look_ahead"), request)
    assert again.cost.tolist() == found.cost.tolist()
    assert measure(Measurement(ORACLE, "mpc"), request).plants_episodes == 0


def test_the_readme_shows_a_good_part_on_other_machines_beside_the_model():
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
