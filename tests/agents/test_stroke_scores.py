import math

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from agents.reference import stroke_scores
from agents.reference.stroke_scores import (
    Constant,
    FullState,
    Handbook,
    Threshold,
    Uniform,
    full_state_of,
    in_hindsight,
    reference_of_returns,
    returns,
    score_stroke,
    stroke_reference,
)
from grind_env.scores import read_references

gym.register_envs(grind_env)

SEEN = {"mean_power": 3000.0, "last_speed": 9.0, "starts_part": 0.0, "strokes_left": 5.0, "remaining": 0.5}


def test_returns_are_those_of_the_registered_environment():
    env = gym.make("grind/Stroke-v0")
    env.reset(seed=5)
    total, made, terminated = 0.0, 0, False
    while not terminated:
        made += 1
        # E of 9487 mm/min is the middle of the range
        _, reward, terminated, _, _ = env.step(np.array([0.0, 0.5 if made % 20 == 0 else -0.5], np.float32))
        total += reward
    assert returns(Constant(9487.0, 20), [5])[0] == pytest.approx(total, rel=1e-12)


def test_a_rule_forgets_the_episode_before():
    plan = Constant(9000.0, 25)
    assert returns(plan, [1, 2])[1] == returns(plan, [2])[0]


def test_what_the_plans_decide():
    plan = Constant(8000.0, 3)
    assert [plan.decide(SEEN) for _ in range(4)] == [(8000.0, k == 2) for k in range(4)]
    handbook = Handbook()
    assert handbook.decide(SEEN) == (12_000.0, False)
    assert handbook.decide({**SEEN, "starts_part": 1.0}) == (12_000.0, True)
    uniform = Uniform(3000.0, 30_000.0)
    drawn = [uniform.decide(SEEN) for _ in range(2000)]
    assert np.mean(np.log([E for E, _ in drawn])) == pytest.approx(math.log(9487.0), abs=0.05)
    assert np.mean([dress for _, dress in drawn]) == pytest.approx(0.5, abs=0.05)


def test_the_plan_is_chosen_on_the_validation_episodes_from_the_best_of_training(monkeypatch):
    monkeypatch.setattr(stroke_scores, "SHORTLIST", 3)
    monkeypatch.setattr(stroke_scores, "INTERVALS", (20, 30))
    training = {(1.0, 20): 5.0, (1.0, 30): 3.0, (2.0, 20): 4.0, (2.0, 30): 1.0, (3.0, 20): 2.0, (3.0, 30): 9.0}
    # the others are not asked for
    validation = {(2.0, 30): 8.0, (3.0, 20): 6.0, (1.0, 30): 7.0}

    def looked_up(table):
        return lambda plan: table[plan.E, plan.every]

    found = stroke_scores.constant(looked_up(training), looked_up(validation), [1.0, 2.0, 3.0])
    assert (found.E, found.every) == (3.0, 20)


def test_what_the_power_rule_decides():
    # 3000 W at 1 mm2 and 150 mm/s: 20 J/mm3
    assert Threshold(9000.0, 19.9, 0.8, 1.0, 7500.0).decide(SEEN) == (9000.0, True)
    assert Threshold(9000.0, 20.1, 0.8, 1.0, 7500.0).decide(SEEN) == (9000.0, False)
    # at 27 m/min it would be 9000 W, half more than 0.8 of the limit
    assert Threshold(27_000.0, 20.1, 0.8, 1.0, 7500.0).decide(SEEN)[0] == pytest.approx(18_000.0)
    assert not Threshold(9000.0, 20.1, 0.8, 1.0, 7500.0).decide({**SEEN, "mean_power": 0.0})[1]


def test_what_the_rule_on_the_state_decides():
    rule = FullState(9000.0, 0.03, -0.5, 0.0, 0.0, 0.1)
    sharp, dull = ({**SEEN, "wear_flat": area, "growth": 1.0} for area in (0.015, 0.06))
    assert rule.decide(sharp) == (9000.0, False)
    assert rule.decide(dull) == (pytest.approx(4500.0), True)
    assert not rule.decide({**dull, "remaining": 0.1})[1]
    # a lot that dulls the wheel fast is worth a dress sooner
    assert FullState(9000.0, 0.08, 0.0, 0.5, 0.0, 0.0).decide({**dull, "growth": 4.0})[1]


def test_hindsight_is_no_worse_than_the_rule_it_starts_from():
    vector = np.zeros(6)
    assert in_hindsight(vector, 3, 4) >= returns(full_state_of(vector), [3])[0]


def test_a_reference_by_hand(tmp_path, monkeypatch):
    found = {"constant": np.array([-150.0, -160.0]), "hindsight": np.array([-130.0, -130.0])}
    scale = reference_of_returns(found, 0.2)
    assert (scale.zero, scale.hundred) == (-155.0, -130.0)
    assert (scale.J_fix, scale.J_plan) == (31.0, 26.0)
    assert scale.returns["constant"] == (-155.0, 5.0)
    monkeypatch.setattr(stroke_scores, "stroke_reference", lambda: scale)
    score_stroke(tmp_path / "scores.toml")
    assert read_references(tmp_path / "scores.toml") == {"grind/Stroke-v0": scale}


def test_a_small_run_measures_every_policy(monkeypatch):
    monkeypatch.setattr(stroke_scores, "SPEEDS", 2)
    monkeypatch.setattr(stroke_scores, "INTERVALS", (30,))
    scale = stroke_reference(episodes=2, training=1, validation=1, evaluations=3, hindsight=2)
    assert list(scale.returns) == ["random", "handbook", "constant", "power_threshold", "full_state_rule", "hindsight"]
    assert scale.returns["random"].value < scale.zero
    assert scale.hundred >= scale.returns["full_state_rule"].value
