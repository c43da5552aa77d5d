"""A small environment with every trait that matters to wrappers and checkers."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from tests.envs.harness import Array

LONGEST = 5


class Walk(gym.Env[Array, Array]):
    """A random walk with drift that ends at a random goal, or is cut short."""

    def __init__(self) -> None:
        self.metadata = {}  # SyncVectorEnv of Gymnasium 1.2 writes into the metadata of the class
        self.observation_space = spaces.Box(-20.0, 20.0, (2,), np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, (1,), np.float32)
        self.place, self.goal, self.age = 0.0, 0.0, 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        super().reset(seed=seed)
        self.place, self.goal, self.age = 0.0, float(self.np_random.uniform(0.5, 2.0)), 0
        return self.observe(), {"goal": self.goal}

    def observe(self) -> Array:
        return np.array([self.place, self.goal], np.float32)

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        if not self.action_space.contains(action):
            raise ValueError(f"{action} is not in {self.action_space}")
        self.place += 0.5 + float(action[0]) * float(self.np_random.random())
        self.age += 1
        info = {"parts": {"step": -0.1}, "name": f"step {self.age}", "place": self.place}
        return self.observe(), -0.1, self.place > self.goal, self.age >= LONGEST, info
