"""Speed of the environments beside those of others, in turns: part of `make speed`."""

from time import process_time

import gymnasium as gym
import numpy as np

import grind_env
from tests.speed.turns import Ratios, in_turns, over
from tests.speed_envs import over_kernel, seconds, single_step

N, MANY = 256, 1024
"""Environments beside each other, and those that are timed beside their kernel."""
SECONDS = 5.0
"""Measured of the native ones, about, all of them together."""
STEPS = 50
"""Of a round; one after which episodes begin again costs more."""

OURS = "grind/PowerLimited-v0"
CARTPOLE = "CartPole-v1"
"""Gymnasium's own in numpy for all at once."""
TIMES = 3
"""So often the steps are measured over an empty one."""


class Native:
    """A vector environment of N, and random actions for it."""

    def __init__(self, env_id: str) -> None:
        assert grind_env.__version__
        self.envs = gym.make_vec(env_id, N, vectorization_mode="vector_entry_point")
        self.envs.reset(seed=0)
        self.envs.action_space.seed(0)
        self.actions = [self.envs.action_space.sample() for _ in range(STEPS)]

    def step(self) -> float:
        """CPU time of a step of one environment, s."""
        return seconds(process_time, lambda: [self.envs.step(action) for action in self.actions]) / (N * STEPS)


def ratios() -> Ratios:
    """What a native step costs over one of CartPole and over its kernel, and a single step over an empty one."""
    steps = in_turns({env_id: Native(env_id).step for env_id in (OURS, CARTPOLE)}, SECONDS)
    single, empty = np.transpose([single_step(OURS) for _ in range(TIMES)])
    return {
        "PowerLimited, native step over one of CartPole": over(steps[OURS], steps[CARTPOLE]),
        f"PowerLimited, vector step over its kernel, N = {MANY}": over_kernel(OURS, MANY),
        "PowerLimited, single step without its strokes over an empty one": single / empty,
    }
