"""Speed of training: our PPO on the native environment against PPO as most would begin. Part of `make speed`.

The other side is Stable-Baselines3 as it comes: its default batch, epochs and network, on `SubprocVecEnv(8)` of the
single environment in plain Python. Both are wall times and want an idle machine.
"""

import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple
from unittest.mock import patch

import gymnasium as gym
import torch
from rich.table import Table
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import SubprocVecEnv

import grind_env
from agents.train_sb3 import train
from grind_env.policies.problem import find_problem
from grind_env.sb3 import SB3VecEnv

TASK, ENV = "power_limited", "grind/PowerLimited-v0"
STEPS = 8 * 128 * 60
"""Eight rollouts of the recipe."""
DEFAULT_STEPS = 128
"""Steps of a rollout; fewer than the default 2048, which changes the time of a step little."""


class Spent(NamedTuple):
    """Wall time of a training, s: all of it, and that in steps of the environment."""

    whole: float
    environment: float


def native() -> Spent:
    """Times of a short training by the recipe."""
    step, environment = SB3VecEnv.step_wait, [0.0]

    def timed(self: SB3VecEnv) -> Any:
        begin = time.perf_counter()
        result = step(self)
        environment[0] += time.perf_counter() - begin
        return result

    begin = time.perf_counter()
    with TemporaryDirectory() as folder, patch.object(SB3VecEnv, "step_wait", timed):
        train(find_problem(TASK), "ppo", 0, STEPS, Path(folder, "agent.zip"))
    return Spent(time.perf_counter() - begin, environment[0])


def make() -> gym.Env:
    """The single environment."""
    assert grind_env.__version__
    return gym.make(ENV)


def default_steps_per_second() -> None:
    """Print the training steps a second of the defaults."""
    torch.set_num_threads(1)
    env = SubprocVecEnv([make] * 8)
    model = PPO("MlpPolicy", env, n_steps=DEFAULT_STEPS, device="cpu", seed=0)
    model.learn(8 * DEFAULT_STEPS)
    begin = time.perf_counter()
    model.learn(8 * DEFAULT_STEPS)
    print(8 * DEFAULT_STEPS / (time.perf_counter() - begin))
    env.close()


def table(fresh_process: Callable[..., list[float]]) -> Table:
    """Steps a second, their ratio, and where the time of our training goes."""
    result = Table(title="Training of PPO")
    for name in ("measure", "value", "target"):
        result.add_column(name, justify="left" if name == "measure" else "right")
    native()
    ours = native()
    call = "from tests.speed_training import default_steps_per_second; default_steps_per_second()"
    (default,) = fresh_process(call, NUMBA_DISABLE_JIT="1")
    steps = STEPS / ours.whole
    result.add_row("native environment, steps/s", f"{steps:.0f}", "")
    result.add_row("defaults on SubprocVecEnv(8) in plain Python, steps/s", f"{default:.0f}", "")
    result.add_row("native over defaults", f"{steps / default:.0f}", ">= 20")
    result.add_row("share of environment and belief", f"{100.0 * ours.environment / ours.whole:.1f} %", "")
    return result
