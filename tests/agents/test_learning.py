from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

from agents.__main__ import app
from agents.evaluate import episode_seeds, evaluate
from agents.learning.features import LearnerVecEnv, LearnerView
from agents.learning.sb3_adapter import SB3VecEnv
from agents.learning.train import LAST_SEED, SEED_STRIDE, TRAINING_SEEDS, LearnedPolicy, Training, train_ppo
from grind_env.envs.tasks import load_task
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.errors import GrindError

TASK = load_task("power_limited")
TINY = Training(steps=2 * 4 * 60, envs=4, batch=120, epochs=1, hidden=(8,))


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


def test_features_are_those_of_the_episodes_one_by_one():
    env = LearnerVecEnv(native(), worst_reward=-10.0)
    env.seed(11)
    together = [env.reset()]
    actions = np.random.default_rng(1).integers(0, [24, 4], (70, 3, 2))
    for action in actions:
        together.append(env.step(action)[0])
    for i in range(3):
        alone = LearnerVecEnv(native(1), worst_reward=-10.0)
        alone.seed(11 + i)
        assert np.array_equal(alone.reset()[0], together[0][i])
        for k, action in enumerate(actions):
            assert np.array_equal(alone.step(action[i : i + 1])[0][0], together[k + 1][i])


def test_the_reward_is_shifted_and_cut():
    env, plain = LearnerVecEnv(native(), worst_reward=-2.0), native()
    env.seed(5)
    env.reset()
    plain.reset(seed=5)
    view = LearnerView(TASK)
    for action in np.random.default_rng(2).integers(0, [24, 4], (30, 3, 2)):
        decision = view.decide(action)
        rewards = plain.step(plain.codec.encode(decision.speeds, decision.executions))[1]
        assert env.step(action)[1] == pytest.approx(np.maximum(rewards + 1.0, -2.0), abs=1e-6)


def test_training_is_reproducible_and_its_agent_sees_measurements_only(tmp_path: Path):
    results = []
    for name in ("one.zip", "two.zip"):
        train_ppo(TASK, 3, tmp_path / name, TINY)
        policy = LearnedPolicy(tmp_path / name)
        assert policy.sees == "measurements"
        results.append(evaluate(policy, TASK, episode_seeds("validation", 4)))
    assert np.array_equal(results[0].cost, results[1].cost)
    assert np.array_equal(results[0].speeds, results[1].speeds)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.zip", "two.zip"]


def test_training_episodes_are_of_the_training_split():
    last = TRAINING_SEEDS + SEED_STRIDE * LAST_SEED + Training().envs
    assert last < episode_seeds("validation", 1)[0]
    assert Training().envs <= SEED_STRIDE


def test_no_agent_no_policy(tmp_path: Path):
    with pytest.raises(GrindError, match="run `python -m agents train` first"):
        LearnedPolicy(tmp_path / "none.zip")


def test_a_file_that_is_no_agent_is_refused(tmp_path: Path):
    path = tmp_path / "bad.zip"
    path.write_bytes(b"no agent")
    with pytest.raises(GrindError, match=r"bad\.zip holds no agent"):
        LearnedPolicy(path)


def test_an_agent_of_another_task_is_refused(tmp_path: Path):
    path = tmp_path / "agent.zip"
    train_ppo(load_task("oracle6"), 0, path, TINY)
    with pytest.raises(GrindError, match="was not trained for power_limited"):
        evaluate(LearnedPolicy(path), TASK, episode_seeds("validation", 2))


def test_the_train_command_keeps_an_agent_of_the_same_settings(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    arguments = ["train", "--steps", "20", "--runs", str(tmp_path)]
    app(arguments, standalone_mode=False)
    (path,) = (tmp_path / "power_limited").glob("ppo-0-*.zip")
    made = path.stat().st_mtime_ns
    app(arguments, standalone_mode=False)
    assert path.stat().st_mtime_ns == made
    assert str(path) in capsys.readouterr().out
