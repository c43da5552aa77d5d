"""A small environment with every trait that matters to wrappers and checkers, in single and in vector form."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from tests.envs.harness import Array

LONGEST = 5


class Walk(gym.Env[Array, Array]):
    """A random walk with drift that ends at a random goal, or is cut short: the single form of `Walks`."""

    def __init__(self) -> None:
        self.metadata = {}  # the SyncVectorEnv of Gymnasium 1.2 writes into that of the class
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


class Walks(VectorEnv[Array, Array, Array]):
    """Three walks, done right: what `SyncVectorEnv` would do, by way of plain single environments."""

    def __init__(self, mode: AutoresetMode) -> None:
        self.num_envs = 3
        self.mode = mode
        self.metadata = {"autoreset_mode": mode}
        self.walks = [Walk() for _ in range(self.num_envs)]
        self.single_observation_space = self.walks[0].observation_space
        self.single_action_space = self.walks[0].action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.over = np.zeros(self.num_envs, bool)
        self.observations = np.zeros((self.num_envs, 2), np.float32)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> Any:
        seeds = [seed + i for i in range(3)] if isinstance(seed, int) else [None] * 3 if seed is None else seed
        mask = (options or {}).get("reset_mask", np.ones(3, bool))
        info: dict[str, Any] = {}
        for i, (walk, each) in enumerate(zip(self.walks, seeds, strict=True)):
            if mask[i]:
                self.observations[i], found = walk.reset(seed=each)
                info = self._add_info(info, found, i)
        self.over &= ~mask
        return self.observations.copy(), info

    def step(self, actions: Array) -> Any:
        if len(actions) != 3:
            raise ValueError(f"{len(actions)} actions, but must be 3")
        rewards, flags, info = np.zeros(3), np.zeros((2, 3), bool), {}
        for i, walk in enumerate(self.walks):
            if self.over[i]:
                self.observations[i], found = walk.reset()
            else:
                observation, rewards[i], flags[0, i], flags[1, i], found = walk.step(actions[i])
                self.observations[i] = observation
                if flags[:, i].any() and self.mode is AutoresetMode.SAME_STEP:
                    info = self._add_info(info, {"final_obs": observation, "final_info": found}, i)
                    self.observations[i], found = walk.reset()
            info = self._add_info(info, found, i)
        self.over = flags.any(axis=0) & (self.mode is not AutoresetMode.SAME_STEP)
        return self.observations.copy(), rewards, flags[0].copy(), flags[1].copy(), info
