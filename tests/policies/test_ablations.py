"""The adaptive rule without one of its decisions, and the rule on the state without some of its knowledge."""

import numpy as np
import pytest

from grind_env.policies.evaluation import episode_seeds, start_episodes
from grind_env.policies.planners.known_state import FullStateRule
from grind_env.policies.policy import Policy
from grind_env.policies.registry import ABLATIONS, TUNED, make_policy, policy_names
from grind_env.policies.scripted.rules import AdaptiveRule, Fixed
from grind_env.policies.tuned_parameters import ConfigError
from tests.policies.harness import simulated

SPEED = {"E": (9e3, 14e3, 20e3), "gA": -0.5, "gF": 0.1, "gH": -0.2, "gS": 0.1, "gP": 0.3}
DRESS = {"A_dress": (0.011, 0.013, 0.016), "wV": 0.2, "wH": 0.4, "wS": 0.3, "wP": -0.1}
RUSH = simulated("rush")


def decisions(policies: list[Policy], steps: int) -> np.ndarray:
    """Return the decisions of all policies in the episodes of the first, shape (policies, steps, 2, episodes)."""
    episodes = start_episodes(RUSH, episode_seeds("training", 4))
    for policy in policies:
        policy.begin(RUSH, 4)
    found = []
    for _ in range(steps):
        observation = RUSH.observe(episodes)
        found.append([policy.act(observation, None) for policy in policies])
        RUSH.step(episodes, *found[-1][0])
    return np.array(found).swapaxes(0, 1)


def test_an_ablation_takes_one_decision_from_the_rule_and_one_from_a_plan() -> None:
    both = AdaptiveRule(**SPEED, **DRESS)
    speed = TUNED["adaptive_speed"](**SPEED, D=2, every=3)
    dress = TUNED["adaptive_dress"](E=11_000.0, **DRESS)
    plan = Fixed(E=9000.0, D=2, every=3)
    of_both, of_speed, of_dress, of_plan = decisions([both, speed, dress, plan], 40)
    np.testing.assert_array_equal(of_speed[:, 0], of_both[:, 0])
    np.testing.assert_array_equal(of_speed[:, 1], of_plan[:, 1])
    np.testing.assert_array_equal(of_dress[:, 1], of_both[:, 1])
    assert set(np.unique(of_dress[:, 0])) == {11000.0}
    assert len(np.unique(of_both[:, 0])) > 10
    assert 0.0 < of_both[:, 1].mean() < 1.0


def test_an_ablated_state_rule_equals_the_full_rule_with_zero_terms() -> None:
    terms = {name: value for name, value in (SPEED | DRESS).items() if not name.endswith("S")}
    known = {"growth_rule": {"gK": 0.4, "wK": 0.6}, "roughness_rule": {"gR": -0.8}, "dullness_rule": {}}
    full = FullStateRule(**terms, gK=0.4, gR=-0.8, wK=0.6)
    all_zero = {"gK": 0.0, "gR": 0.0, "wK": 0.0}
    for name, of_it in known.items():
        rule, same = TUNED[name](**terms, **of_it), FullStateRule(**terms, **{**all_zero, **of_it})
        episodes = start_episodes(RUSH, episode_seeds("training", 8))
        RUSH.step(episodes, np.full(8, 9000.0), np.zeros(8))
        for policy in (full, rule, same):
            policy.begin(RUSH, 8)
        np.testing.assert_array_equal(rule.act(None, episodes), same.act(None, episodes))
        assert not np.array_equal(rule.act(None, episodes).speeds, full.act(None, episodes).speeds)


def test_ablations_are_not_listed_but_suggested_in_an_error() -> None:
    assert not set(ABLATIONS) & set(policy_names(RUSH))
    with pytest.raises(
        ConfigError, match=r"there is no policy 'adaptive' .* for rush: choose from random, .*adaptive_dress"
    ):
        make_policy("adaptive", RUSH)


def test_the_name_of_a_trained_agent_has_an_error_of_its_own() -> None:
    with pytest.raises(ConfigError, match=r"^'plain_gru' is a trained agent and is read from a file: name it to"):
        make_policy("plain_gru", RUSH)
    with pytest.raises(ConfigError, match=r"^bc was renamed to plain_gru$"):
        make_policy("bc", RUSH)
