"""Speed of the environments beside those of others and of plain Python, in turns: part of `make speed`."""

import time

import gymnasium as gym
import numpy as np

import grind_env
from tests.speed.turns import Ratios, fresh_process, in_turns, over, seconds_of
from tests.speed_envs import over_kernel, single_step

N, MANY = 256, 1024
"""Environments beside each other, and those that are timed beside their kernel."""
SECONDS = 5.0
"""Measured of the native ones, about, all of them together."""
STEPS = 50
"""Of a round; one after which episodes begin again costs more."""

OURS = "grind/PowerLimited-v0"
CARTPOLE = "CartPole-v1"
"""Gymnasium's own in numpy for all at once."""
WORKERS, ROUNDS, PLAIN_STEPS = 2, 5, 5
"""Of the asynchronous environments in plain Python: how many, and how long."""
TIMES = 3
"""So often the steps are measured over an empty one."""
PLAIN = "from tests.speed.others import plain_steps; plain_steps()"


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
        return seconds_of(lambda: [self.envs.step(action) for action in self.actions]) / (N * STEPS)


class Timed(gym.Wrapper):
    """Says how long its process has worked."""

    def spent(self) -> float:
        """CPU time, s."""
        return time.process_time()


def plain_steps() -> None:
    """Print the time of a step of one of the asynchronous environments, s: a number a round.

    It is CPU time, that of the slower worker and of the process that waits for it: the wall time of an idle machine.
    """
    envs = gym.make_vec(OURS, WORKERS, vectorization_mode="async", wrappers=[Timed])
    envs.reset(seed=0)
    envs.action_space.seed(0)
    envs.step(envs.action_space.sample())

    def spent() -> np.ndarray:
        return time.process_time() + np.array(envs.call("spent"))

    for _ in range(ROUNDS):
        before = spent()
        for _ in range(PLAIN_STEPS):
            envs.step(envs.action_space.sample())
        print(max(spent() - before) / (WORKERS * PLAIN_STEPS))
    envs.close()


def ratios() -> Ratios:
    """What a native step costs over one of CartPole, and one in plain Python over it."""
    steps = in_turns({env_id: Native(env_id).step for env_id in (OURS, CARTPOLE)}, SECONDS)
    plain = fresh_process(PLAIN, NUMBA_DISABLE_JIT="1")
    single, empty = np.transpose([single_step(OURS) for _ in range(TIMES)])
    return {
        "PowerLimited, native step over one of CartPole": over(steps[OURS], steps[CARTPOLE]),
        "PowerLimited, AsyncVectorEnv(2) in plain Python over a native step": over(plain, steps[OURS]),
        f"PowerLimited, vector step over its kernel, N = {MANY}": over_kernel(OURS, MANY),
        "PowerLimited, single step without its strokes over an empty one": single / empty,
    }
