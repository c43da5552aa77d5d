"""Speed of the environments compared with CartPole and with their own kernel: part of `make speed`."""

from time import process_time

import gymnasium as gym
import numpy as np

import grind_env
from tests.speed.turns import Ratios, in_turns, over
from tests.speed_envs import over_kernel, seconds, single_step

N, MANY = 256, 1024  #: numbers of environments in a vector: for the comparison with CartPole, and with the kernel
SECONDS = 5.0  #: duration of all measurements of vector environments together, about, s
STEPS = 50  #: steps of a round; a step that starts new episodes costs more

OURS = "grind/PowerLimited-v0"
CARTPOLE = "CartPole-v1"  #: gymnasium's own vector environment, written in numpy
TIMES = 3  #: repetitions of the comparison of a step with an empty step


class Native:
    """Vector environment of N environments, with random actions for it."""

    def __init__(self, env_id: str) -> None:
        assert grind_env.__version__
        self.envs = gym.make_vec(env_id, N, vectorization_mode="vector_entry_point")
        self.envs.reset(seed=0)
        self.envs.action_space.seed(0)
        self.actions = [self.envs.action_space.sample() for _ in range(STEPS)]

    def step(self) -> float:
        """Return the CPU time of a step of one environment, s."""
        return seconds(process_time, lambda: [self.envs.step(action) for action in self.actions]) / (N * STEPS)


def ratios() -> Ratios:
    """Return the time of a native step relative to CartPole and to its kernel, and of a single step to an empty one."""
    steps = in_turns({env_id: Native(env_id).step for env_id in (OURS, CARTPOLE)}, SECONDS)
    single, empty = np.transpose([single_step(OURS) for _ in range(TIMES)])
    return {
        "PowerLimited, native step over one of CartPole": over(steps[OURS], steps[CARTPOLE]),
        f"PowerLimited, vector step over its kernel, N = {MANY}": over_kernel(OURS, MANY),
        "PowerLimited, single step without its strokes over an empty one": single / empty,
    }
