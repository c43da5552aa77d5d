"""Random steps in every environment, many at a time and one at a time: nothing is NaN, outside its space, or grows.

A case is one environment with one form of its actions; what its episodes keep, and how fast it is, is compared between
the first and the last part of it.
"""

import time
from typing import Any

import gymnasium as gym
import numpy as np

from grind_env.pages import summary
from tests.envs.harness import FORMS, every_id, quiet
from tests.soak.part import Part, Tried, broken, memory

SECONDS = 6.0
"""s of processor time of a case."""
SIZES = (4096, 1, 64)
"""Environments side by side; 1 stands for the single environment."""
EXTREME = 0.2
"""Share of actions at the corners of their space, where they are a box."""
GROWTH = 24.0
"""MB that a case may grow by."""
SLOWED = 0.4
"""Share of its first speed below which a case has slowed down; other processes disturb it, too."""


def attempt(seed: int) -> Tried:
    """Play the environment of a seed."""
    ids = every_id()
    env_id, turn = ids[seed % len(ids)], seed // len(ids)
    size = SIZES[turn % len(SIZES)]

    words = {"action": FORMS[turn // len(SIZES) % len(FORMS)]}
    space_is_box = words["action"] == FORMS[0]
    rng = np.random.default_rng(seed)
    play = _Single(env_id, words, seed) if size == 1 else _Many(env_id, size, words, seed)
    least, most = summary(env_id).reward
    low, high = play.bounds
    quarters, steps = list[tuple[float, float]](), 0  # steps a second and memory, quarter by quarter
    for _ in range(5):
        began, taken = time.process_time(), 0
        while time.process_time() - began < SECONDS / 5:
            observations, rewards = play.step(_corners(play.sample(), rng) if space_is_box else play.sample())
            if not (np.isfinite(observations).all() and np.isfinite(rewards).all()):
                return broken(f"{env_id}: not finite", f"{observations}\n{rewards}")
            if not ((observations >= low) & (observations <= high)).all():
                return broken(f"{env_id}: observation outside its space", observations)
            if np.min(rewards) < (-np.inf if least is None else least) or np.max(rewards) > most:
                return broken(f"{env_id}: reward outside its range", f"{np.min(rewards)} to {np.max(rewards)}")
            taken += size
        quarters.append((taken / (time.process_time() - began), memory()))
        steps += taken
    (first, before), (last, after) = quarters[1], quarters[-1]  # in the first one everything is new
    if after - before > GROWTH:
        return broken(f"{env_id}: memory grows", f"{before:.0f} MB, then {after:.0f} MB, {size} at a time")
    if last < SLOWED * first:
        return broken(f"{env_id}: slows down", f"{first:.0f} steps/s, then {last:.0f}, {size} at a time")
    kind = "single" if size == 1 else f"{size} at a time"
    return Tried(
        "accepted",
        sums={
            "steps": steps,
            f"steps of {env_id}": steps,
            f"steps/s at the begin, {kind}, summed over cases": first,
            f"steps/s at the end, {kind}, summed over cases": last,
        },
        most={"growth of resident memory, MB": after - before, "slowdown": first / last},
    )


def _corners(action: Any, rng: np.random.Generator) -> Any:
    """Some actions at the corners of the box."""
    extreme = rng.random(action.shape[:-1]) < EXTREME
    return np.where(extreme[..., None], np.where(action < 0.0, -1.0, 1.0).astype(action.dtype), action)


class _Many:
    """Environments side by side."""

    def __init__(self, env_id: str, size: int, words: dict[str, Any], seed: int) -> None:
        self.env = gym.make_vec(env_id, size, autoreset_mode="SameStep", **words)
        self.env.reset(seed=seed)
        self.env.action_space.seed(seed)
        space = self.env.single_observation_space
        self.bounds, self.sample = (space.low, space.high), self.env.action_space.sample

    def step(self, action: Any) -> tuple[Any, Any]:
        return self.env.step(action)[:2]


class _Single:
    """One environment."""

    def __init__(self, env_id: str, words: dict[str, Any], seed: int) -> None:
        self.env = gym.make(env_id, **quiet(env_id), **words)
        self.env.reset(seed=seed)
        self.env.action_space.seed(seed)
        space = self.env.observation_space
        self.bounds, self.sample = (space.low, space.high), self.env.action_space.sample

    def step(self, action: Any) -> tuple[Any, Any]:
        observation, reward, terminated, truncated, _ = self.env.step(action)
        if terminated or truncated:
            self.env.reset()
        return observation, reward


PART = Part(name="steps", attempt=attempt, share=1.0, seconds=300.0)
