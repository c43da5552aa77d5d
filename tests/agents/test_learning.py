import numpy as np
import pytest

from agents.learning.training_env import LearnerVecEnv
from grind_env.envs import any_task
from grind_env.envs.learning import eased
from grind_env.envs.tables import Outcome, reward_terms
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.policies.learned.view import LearnerView, MemoryKind
from grind_env.policies.problem import find_problem

PROBLEM = find_problem("power_limited")
SIMULATION = PROBLEM.simulation()
TASK = SIMULATION.task


def native(envs: int = 3) -> GrindVectorEnv:
    return any_task.make_vector(envs, autoreset_mode="SameStep", info="full")


@pytest.mark.parametrize("memory", ["belief", "means", "stack", "estimates"])
def test_features_are_those_of_the_episodes_one_by_one(memory: MemoryKind):
    env = LearnerVecEnv(PROBLEM, 3, memory)
    env.seed(11)
    together, ends = [env.reset()], []
    actions = np.random.default_rng(1).integers(0, [24, 4], (70, 3, 2))
    for action in actions:
        features, _, done, infos = env.step(action)
        together.append(features)
        ends += [info["terminal_observation"] for info in infos if "terminal_observation" in info]
        assert done.any() == (len(together) == 61)
    for i in range(3):
        alone = LearnerVecEnv(PROBLEM, 1, memory)
        alone.seed(11 + i)
        assert np.array_equal(alone.reset()[0], together[0][i])
        view = LearnerView(SIMULATION, memory)
        view.begin(1)
        plain = native(1)
        view.features(plain.reset(seed=11 + i, options={"split": "inner"})[0])
        for k, action in enumerate(actions):
            features, _, done, infos = alone.step(action[i : i + 1])
            assert np.array_equal(features[0], together[k + 1][i])
            if k < 60:
                decision = view.decide(action[i : i + 1])
                seen, *_, info = plain.step(plain.codec.encode(decision.speeds, decision.executions))
                last = view.features(np.stack(info["final_obs"].tolist()) if done[0] else seen)
            if done[0]:
                # what the memory shows of the last observation of the episode, not of the first of the next one
                assert np.array_equal(infos[0]["terminal_observation"], last[0])
                assert np.array_equal(ends[i], last[0])


def test_the_reward_is_shifted_and_cut():
    env, plain = LearnerVecEnv(PROBLEM, 3, "estimates", worst_reward=-2.0), native()
    env.seed(5)
    env.reset()
    plain.reset(seed=5, options={"split": "inner"})
    view = LearnerView(SIMULATION, "estimates")
    for action in np.random.default_rng(2).integers(0, [24, 4], (30, 3, 2)):
        decision = view.decide(action)
        rewards = plain.step(plain.codec.encode(decision.speeds, decision.executions))[1]
        assert env.step(action)[1] == pytest.approx(np.maximum(rewards + 1.0, -2.0), abs=1e-6)


def test_notes_are_the_means_of_what_the_environment_tells():
    env, plain = LearnerVecEnv(PROBLEM, 3, "estimates"), native()
    env.seed(5)
    env.reset()
    plain.reset(seed=5, options={"split": "inner"})
    view = LearnerView(SIMULATION, "estimates")
    infos, decisions, finished = [], [], 0
    for action in np.random.default_rng(4).integers(0, [24, 4], (40, 3, 2)):
        decisions.append(view.decide(action))
        infos.append(plain.step(plain.codec.encode(*decisions[-1]))[-1])
        env.step(action)
        finished += 3
    notes = env.take_notes()
    metrics = notes.metrics(TASK)
    for name in reward_terms(TASK):
        assert metrics[f"reward/{name}"] == pytest.approx(np.mean([info[f"reward_{name}"] for info in infos]))
    # in this task every block is a part
    assert metrics["cost/part"] == pytest.approx(np.mean([info["block_cost"] for info in infos]))
    assert metrics["parts/scrap_share"] == pytest.approx(1.0 - np.mean([info["good_parts"] for info in infos]))
    assert metrics["actions/E_mean"] == pytest.approx(np.mean([each.speeds for each in decisions]) / 1000.0)
    assert metrics["actions/D_mean"] == pytest.approx(np.mean([each.executions for each in decisions]))
    assert metrics["actions/dress_share"] == pytest.approx(np.mean([each.executions > 0 for each in decisions]))
    assert notes.totals[Outcome._fields.index("finished")] == finished
    assert env.notes.blocks == 0


def test_the_reward_of_a_learner_is_that_of_the_published_agents_to_the_bit():
    rewards = np.random.default_rng(0).normal(-3.0, 6.0, 1000).astype(np.float32)
    eased_rewards = eased(rewards)
    assert eased_rewards.dtype == np.float32 and (eased_rewards == -10.0).any()
    np.testing.assert_array_equal(eased_rewards, np.maximum(rewards + np.float32(1.0), np.float32(-10.0)))
