from dataclasses import replace

import numpy as np
import pytest

from agents.reference import reciprocation_scores
from agents.reference.reciprocation_scores import FeedHindsight, FeedThreshold, FeedTuner, score_reciprocation
from grind_env.envs.observations import physical
from grind_env.envs.reciprocation.env import ReciprocationEnv
from grind_env.envs.reciprocation.simulation import ReciprocationSimulation
from grind_env.envs.tasks import read_task
from grind_env.policies.evaluation import episode_seeds, roll_out, start_episodes
from grind_env.policies.scripted.rules import Fixed, handbook
from grind_env.scores import Mean, Reference, read_references, write_text

TASK = read_task("reciprocation")
SEEDS = episode_seeds("evaluation", 3)
SMALL = Reference(
    zero=-60.0,
    hundred=-40.0,
    ratio=False,
    fixed_plan="constant",
    best_scripted="power_threshold",
    J_fix=240.0,
    J_plan=160.0,
    returns={"random": Mean(-300.0, 2.5)},
)


def test_a_plan_costs_what_the_environment_says():
    simulation = ReciprocationSimulation(TASK)
    found = roll_out(handbook(TASK), simulation, start_episodes(simulation, SEEDS))
    env = ReciprocationEnv()
    env.reset(seed=SEEDS[1])
    action = env.codec.encode(12_000.0, 1.0)[0]
    rewards = [env.step(action)[1] for _ in range(TASK.blocks)]
    assert found.cost[1] == pytest.approx(-TASK.reference_cost * sum(rewards), rel=1e-12)


def test_the_rule_reads_power_and_speed_at_their_places():
    simulation = ReciprocationSimulation(TASK)
    episodes = start_episodes(simulation, SEEDS)
    simulation.step(episodes, np.full(3, 9000.0), np.zeros(3))
    observation = simulation.observe(episodes)
    seen = physical(observation, simulation.entries)
    removal = 50.0 * seen["last_pick"] * 9000.0 / 60.0
    energy = seen["mean_power"] / removal
    assert (energy > 10.0).all()
    for factor, dress in ((0.999, 1.0), (1.001, 0.0)):
        rule = FeedThreshold(E=9.0, upper=float(factor * energy[0]), lower=1.0, share=100.0)
        rule.begin(TASK, 3)
        decision = rule.act(observation, None)
        assert decision.executions[0] == dress
        assert decision.speeds.tolist() == [9000.0] * 3


def test_the_tuner_counts_the_blocks_of_this_environment():
    simulation = ReciprocationSimulation(TASK)
    tuner = FeedTuner(simulation, 2)
    plan = Fixed(9.0, 1)
    costs = roll_out(plan, simulation, start_episodes(simulation, episode_seeds("training", 2))).cost
    assert tuner.cost(plan) == costs.mean()


def test_the_plan_found_is_the_cheapest_of_the_grid():
    tuner = FeedTuner(ReciprocationSimulation(replace(TASK, blocks=6)), 2)
    found = tuner.fixed("interval", 3, (1, 2), (2, 3))
    # the grid over 3 to 30 m/min, both ends included
    grid = [Fixed(E, D, every) for E in (3.0, 9.487, 30.0) for D in (1, 2) for every in (2, 3)]
    assert tuner.cost(found) <= min(tuner.cost(plan) for plan in grid)
    assert found.name == "interval" and found.D in (1, 2) and found.every in (2, 3)


def test_the_planner_is_far_below_the_best_plan_known():
    task = replace(TASK, blocks=12)
    simulation = ReciprocationSimulation(task)
    start = start_episodes(simulation, SEEDS)
    planned = roll_out(FeedHindsight(sweeps=1), simulation, start).cost
    fixed = min(roll_out(Fixed(E, D), simulation, start).cost.mean() for E in (9.0, 12.0, 15.0) for D in (0, 1))
    assert planned.mean() < 0.9 * fixed


def test_other_scores_are_kept(tmp_path, monkeypatch):
    data = tmp_path / "scores.toml"

    def measured():
        # somebody else's scores, written while these are being measured
        data.write_text(write_text({"grind/A-v0": SMALL}), encoding="utf-8")
        return SMALL

    monkeypatch.setattr(reciprocation_scores, "reciprocation_reference", measured)
    score_reciprocation(data)
    assert read_references(data) == {"grind/A-v0": SMALL, "grind/Reciprocation-v0": SMALL}
