"""The trace of an episode agrees with the evaluation, the environment and the belief."""

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.envs.actions import ActionError
from grind_env.envs.wrappers import BeliefFilter
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision
from grind_env.policies.episode_trace import follow
from grind_env.policies.evaluation import SEEDS, episode_seeds, run_seeds
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.problem_lookup import find_problem

FLAGSHIP = "grind/PowerLimited-v0"


class Always:
    """Policy that decides the same in every block."""

    name, sees = "always", "measurements"

    def __init__(self, speed, executions):
        self.decided = speed, executions

    def begin(self, simulation, episodes): ...

    def act(self, observation, episodes):
        return Decision(*(np.full(len(observation), value) for value in self.decided))


def test_a_trace_has_the_costs_and_decisions_of_the_evaluation():
    simulation = find_problem(FLAGSHIP).simulation()
    judged = run_seeds(named_policy("belief_rule", simulation), simulation, episode_seeds("evaluation", 3))
    found = follow("belief_rule", FLAGSHIP, beside=["full_state_rule", "belief_rule"], episodes=3)
    np.testing.assert_allclose(found.cost.sum(axis=1), judged.cost)
    np.testing.assert_array_equal(found.chosen.speeds, judged.speeds)
    np.testing.assert_array_equal(found.chosen.executions, judged.executions)
    # the same policy beside it decides the same; a policy that sees the truth does not
    np.testing.assert_array_equal(found.beside["belief_rule"].speeds, found.chosen.speeds)
    assert not np.array_equal(found.beside["full_state_rule"].speeds, found.chosen.speeds)


@pytest.mark.parametrize("decided", [(np.nan, 0.0), (9000.0, np.nan), (1.0, 0.0), (9000.0, 0.5)])
def test_invalid_actions_are_refused_as_in_an_evaluation(decided):
    for run in (grind_env.evaluate, follow):
        with pytest.raises(ActionError, match=r"^[ED] is .*, but must be"):
            run(Always(*decided), FLAGSHIP, episodes=2)


def test_a_trace_shows_a_fractional_E_as_rounded():
    found, judged = (run(Always(7213.4, 1.0), FLAGSHIP, episodes=2) for run in (follow, grind_env.evaluate))
    assert (found.chosen.speeds == 7213.0).all()
    np.testing.assert_allclose(found.cost.sum(axis=1), judged.evaluation.cost)


def test_traced_truth_and_belief_match_the_environment():
    found = follow("E6000D1", FLAGSHIP, episodes=2)
    for k in range(2):
        full = gym.make(FLAGSHIP, observation="full", action="dict")
        believing = BeliefFilter(gym.make(FLAGSHIP, action="dict"))
        action = {"E": np.array([6000.0], np.float32), "D": 1}
        shown, believed = (env.reset(seed=SEEDS["evaluation"] + k)[0] for env in (full, believing))
        names = [entry.name for entry in believing.unwrapped.observation_info()] + ["belief_wear_flat"]
        for block in range(60):
            truth = full.unwrapped.simulation.read(shown[None])
            assert found.wear_flat[k, block] == pytest.approx(truth["wear_flat"][0], rel=1e-5)
            assert found.dulling[k, block] == pytest.approx(np.log(truth["growth"][0]), abs=1e-5)
            assert found.belief.wear_flat[k, block] == pytest.approx(0.05 * believed[len(names) - 1], rel=1e-5)
            shown, believed = full.step(action)[0], believing.step(action)[0]


def test_the_data_frame_has_a_row_for_every_block_and_units():
    found = follow("E6000D1", "grind/Rush-v0", beside=["handbook"], episodes=2)
    frame = found.to_dataframe()
    assert len(frame) == np.isfinite(found.cost).sum()
    assert frame["cost [$]"].sum() == pytest.approx(np.nansum(found.cost))
    assert {"E [mm/min]", "D", "E of handbook [mm/min]", "D of handbook", "wear-flat area"} <= set(frame)


def test_policies_with_the_same_name_are_refused():
    with pytest.raises(GrindError, match=r"several policies beside it are called 'handbook'; give each a name"):
        follow("E6000D1", FLAGSHIP, beside=["handbook", "handbook"], episodes=1)
