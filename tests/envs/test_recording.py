"""Vectors show the pictures of single environments."""

import gymnasium as gym
import numpy as np
import pytest

from tests.envs.harness import every_id, native

every_environment = pytest.mark.parametrize("env_id", every_id())


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
