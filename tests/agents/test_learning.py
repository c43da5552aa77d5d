import itertools

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

from agents.learning.sb3_adapter import SB3VecEnv
from agents.learning.training_env import LearnerVecEnv
from agents.learning.view import LearnerView, Memory
from grind_env.envs.rows import Outcome, reward_terms
from grind_env.envs.tasks import load_task
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.errors import GrindError

TASK = load_task("power_limited")


def native(envs: int = 3) -> GrindVectorEnv:
    return GrindVectorEnv(envs, autoreset_mode="SameStep")


def test_the_adapter_is_what_dummy_vec_env_makes_of_the_single_env():
    adapter = SB3VecEnv(native())
    dummy = DummyVecEnv([lambda: gym.make("grind/PowerLimited-v0") for _ in range(3)])
    for env in (adapter, dummy):
        env.seed(7)
    assert np.array_equal(adapter.reset(), dummy.reset())
    rng = np.random.default_rng(0)
    ends = 0
    for _ in range(130):
        actions = rng.uniform(-1, 1, (3, 2)).astype(np.float32)
        ours, theirs = adapter.step(actions), dummy.step(actions)
        for mine, other in zip(ours[:3], theirs[:3], strict=True):
            assert mine.dtype == other.dtype
            assert np.array_equal(mine, other)
        for mine, other, done in zip(ours[3], theirs[3], ours[2], strict=True):
            assert mine.get("TimeLimit.truncated", False) == other["TimeLimit.truncated"]
            if done:
                ends += 1
                assert np.array_equal(mine["terminal_observation"], other["terminal_observation"])
    assert ends == 6


def test_the_adapter_takes_options_as_dummy_vec_env_does():
    adapter = SB3VecEnv(native())
    dummy = DummyVecEnv([lambda: gym.make("grind/PowerLimited-v0") for _ in range(3)])
    action, shown = np.zeros((3, 2), np.float32), []
    # what an environment is not told anew holds on
    for options in (
        [{"context": {"kA": 5.0, "stock": 1.2}}, {}, {"split": "test"}],
        [{}, {"context": {"kA": 0.5}}, {}],
        {"context": "nominal"},
    ):
        for env in (adapter, dummy):
            env.seed(7)
            env.set_options(options)
            shown.append([env.reset(), *(env.step(action)[0] for _ in range(2))])
    assert np.array_equal(shown[0::2], shown[1::2])
    assert not any(np.array_equal(before, after) for before, after in itertools.pairwise(shown[0::2]))


def test_the_adapter_hands_out_arrays_of_its_own():
    env = SB3VecEnv(native())
    observations = env.reset()
    kept = observations.copy()
    _, rewards, _, _ = env.step(np.zeros((3, 2), np.float32))
    first = rewards.copy()
    env.step(np.ones((3, 2), np.float32))
    assert np.array_equal(observations, kept)
    assert np.array_equal(rewards, first)


def test_the_adapter_works_under_vec_monitor():
    env = VecMonitor(SB3VecEnv(native()))
    env.reset()
    for _ in range(60):
        *_, infos = env.step(np.zeros((3, 2), np.float32))
    assert all(info["episode"]["l"] == 60 for info in infos)


def test_the_adapter_refuses_other_autoreset_modes():
    with pytest.raises(GrindError, match="SameStep"):
        SB3VecEnv(GrindVectorEnv(2))


@pytest.mark.parametrize("memory", ["belief", "means", "stack", "estimates"])
def test_features_are_those_of_the_episodes_one_by_one(memory: Memory):
    env = LearnerVecEnv(TASK, 3, memory)
    env.seed(11)
    together, ends = [env.reset()], []
    actions = np.random.default_rng(1).integers(0, [24, 4], (70, 3, 2))
    for action in actions:
        features, _, done, infos = env.step(action)
        together.append(features)
        ends += [info["terminal_observation"] for info in infos if "terminal_observation" in info]
        assert done.any() == (len(together) == 61)
    for i in range(3):
        alone = LearnerVecEnv(TASK, 1, memory)
        alone.seed(11 + i)
        assert np.array_equal(alone.reset()[0], together[0][i])
        view = LearnerView(TASK, memory)
        view.begin(1)
        plain = native(1)
        view.features(plain.reset(seed=11 + i, options={"split": "train"})[0])
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
    env, plain = LearnerVecEnv(TASK, 3, "estimates", worst_reward=-2.0), native()
    env.seed(5)
    env.reset()
    plain.reset(seed=5, options={"split": "train"})
    view = LearnerView(TASK, "estimates")
    for action in np.random.default_rng(2).integers(0, [24, 4], (30, 3, 2)):
        decision = view.decide(action)
        rewards = plain.step(plain.codec.encode(decision.speeds, decision.executions))[1]
        assert env.step(action)[1] == pytest.approx(np.maximum(rewards + 1.0, -2.0), abs=1e-6)


def test_notes_are_the_means_of_what_the_environment_tells():
    env, plain = LearnerVecEnv(TASK, 3, "estimates"), native()
    env.seed(5)
    env.reset()
    plain.reset(seed=5, options={"split": "train"})
    view = LearnerView(TASK, "estimates")
    infos, decisions, finished = [], [], 0
    for action in np.random.default_rng(4).integers(0, [24, 4], (40, 3, 2)):
        decisions.append(view.decide(action))
        infos.append(plain.step(plain.codec.encode(*decisions[-1]))[-1])
        env.step(action)
        finished += 3
    notes = env.simulation.take_notes()
    metrics = notes.metrics(TASK)
    for name in reward_terms(TASK):
        assert metrics[f"reward/{name}"] == pytest.approx(np.mean([info["reward_terms"][name] for info in infos]))
    # in this task every block is a part
    assert metrics["cost/part"] == pytest.approx(np.mean([info["block_cost"] for info in infos]))
    assert metrics["parts/scrap_share"] == pytest.approx(1.0 - np.mean([info["good_parts"] for info in infos]))
    assert metrics["actions/E_mean"] == pytest.approx(np.mean([each.speeds for each in decisions]) / 1000.0)
    assert metrics["actions/D_mean"] == pytest.approx(np.mean([each.executions for each in decisions]))
    assert metrics["actions/dress_share"] == pytest.approx(np.mean([each.executions > 0 for each in decisions]))
    assert notes.totals[Outcome._fields.index("finished")] == finished
    assert env.simulation.notes.blocks == 0
