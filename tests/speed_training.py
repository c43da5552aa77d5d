"""Speed of training: our PPO on the native environment against PPO as most would begin. Part of `make speed`.

The other side is Stable-Baselines3 as it comes: its default batch, epochs and network, on `SubprocVecEnv(8)` of the
single environment in plain Python. Both are wall times and want an idle machine.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import gymnasium as gym
import torch
from rich.table import Table
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import SubprocVecEnv

import grind_env
from agents.learning.curve import SPENT, Point, curve_path, read_curve
from agents.learning.settings import settings_for
from agents.learning.train import train
from grind_env.policies.problem import find_problem

TASK, ENV = "power_limited", "grind/PowerLimited-v0"
ROLLOUTS = 8
SHARE = "<= 15 %"
DEFAULT_STEPS = 128
"""Steps of a rollout; fewer than the default 2048, which changes the time of a step little."""


def native() -> Point:
    """The last point of the curve of a short training with the settings of the task."""
    problem = find_problem(TASK)
    settings = settings_for("ppo", problem.name)
    steps = ROLLOUTS * settings.envs * int(settings.hyper["n_steps"])
    with TemporaryDirectory() as folder:
        path = train(problem, "ppo", 0, replace(settings, steps=steps), Path(folder), quiet=True)
        return read_curve(curve_path(path))[-1]


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
    seconds = ours.seconds - ours.aside
    result.add_row("native environment, steps/s", f"{ours.steps / seconds:.0f}", "")
    result.add_row("defaults on SubprocVecEnv(8) in plain Python, steps/s", f"{default:.0f}", "")
    result.add_row("native over defaults", f"{ours.steps / seconds / default:.0f}", ">= 20")
    for name in SPENT[:-1]:
        share = getattr(ours, name) / seconds
        result.add_row(f"share of {name}", f"{100.0 * share:.1f} %", SHARE if name == "environment" else "")
    return result
