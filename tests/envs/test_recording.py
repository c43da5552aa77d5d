"""Gymnasium's recorders of statistics work with every environment; vectors show the pictures of single environments."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import RecordEpisodeStatistics
from gymnasium.wrappers.vector import RecordEpisodeStatistics as VectorStatistics

from tests.envs.harness import MODES, every_id, native

every_environment = pytest.mark.parametrize("env_id", every_id())


def episode(env: Any, most: int = 10_000) -> tuple[list[float], dict[str, Any]]:
    """Rewards of an episode, or of its first steps, and the last info."""
    env.action_space.seed(0)
    env.reset(seed=3)
    rewards, info, over = [], {}, False
    while not over and len(rewards) < most:
        _, reward, terminated, truncated, info = env.step(env.action_space.sample())
        rewards.append(reward)
        over = terminated or truncated
    return rewards, info


@every_environment
def test_the_statistics_of_an_episode_are_its_sums(env_id: str) -> None:
    rewards, info = episode(RecordEpisodeStatistics(gym.make(env_id)))
    assert info["episode"]["l"] == len(rewards)
    assert info["episode"]["r"] == pytest.approx(sum(rewards), rel=1e-12)


@pytest.mark.parametrize("mode", MODES)
@every_environment
def test_the_statistics_of_a_vector_are_the_sums_of_each_episode(env_id: str, mode: AutoresetMode) -> None:
    env = VectorStatistics(native(env_id, 2, mode))
    env.action_space.seed(0)
    env.reset(seed=3)
    sums, lengths, begins = np.zeros(2), np.zeros(2, int), np.zeros(2, bool)
    found = 0
    while found < 4:
        if mode is AutoresetMode.DISABLED and begins.any():
            env.reset(options={"reset_mask": begins.copy()})
        _, rewards, terminated, _, info = env.step(env.action_space.sample())
        counts = ~begins if mode is AutoresetMode.NEXT_STEP else np.ones(2, bool)
        sums, lengths = sums + rewards * counts, lengths + counts
        for i in np.flatnonzero(terminated):
            assert info["_episode"][i]
            assert info["episode"]["l"][i] == lengths[i]
            assert info["episode"]["r"][i] == pytest.approx(sums[i], rel=1e-12)
        found += int(terminated.sum())
        sums[terminated], lengths[terminated], begins = 0.0, 0, terminated.copy()
    assert env.episode_count == found


@every_environment
def test_the_pictures_of_a_vector_are_those_of_the_single_environments(env_id: str) -> None:
    vector = native(env_id, 2, render_mode="ansi")
    singles = [gym.make(env_id, render_mode="ansi") for _ in range(2)]
    vector.reset(seed=4)
    for i, env in enumerate(singles):
        env.reset(seed=4 + i)
    vector.action_space.seed(0)
    for _ in range(2):
        assert vector.render() == tuple(env.render() for env in singles)
        actions = vector.action_space.sample()
        vector.step(actions)
        for env, action in zip(singles, actions, strict=True):
            env.step(action)
    assert vector.render() == tuple(env.render() for env in singles)


def test_an_episode_begun_anew_shows_nothing_of_the_last_one() -> None:
    env = native("grind/Oracle6-v0", 2, "NextStep", render_mode="ansi")
    env.reset(seed=0)
    for _ in range(6):
        env.step(np.zeros((2, 2)))
    assert all("block 6 of 6" in text for text in env.render())
    env.step(np.zeros((2, 2)))
    assert all("block 0 of 6" in text for text in env.render())
