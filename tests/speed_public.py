"""What users wait for, through what users call, so that every commit can be measured: part of `make speed BASE=`.

A fresh process runs this file within the tree to be measured and prints one JSON object, a number a measure. Times are
CPU times, so that other work on the machine counts less.
"""

import gc
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np

import grind_env
from grind_env.control import Control, execute

VECTORS = {
    "PowerLimited": ((256, 100), (1024, 60), (65536, 4)),
    "Reciprocation": ((256, 60),),
    "WidePlates": ((256, 2),),
    "Job": ((256, 2),),
}
"""Environments beside each other, and steps."""

BLOCKS = 20_000


def measured() -> dict[str, float]:
    """Every measure by name."""
    found: dict[str, float] = {}
    for task, sizes in VECTORS.items():
        for n, steps in sizes:
            found |= vector(task, n, steps)
    found |= single("PowerLimited")
    found |= control()
    found |= search()
    plate = grind_env.examples.path("plate_g82.nc")
    found["grind run of one plate: s"] = child([sys.executable, "-m", "grind_env", "run", str(plate)])
    return found


def cold() -> dict[str, float]:
    """What a newcomer does first: a process each, with an empty cache; those that these start apart."""
    commands = {
        f"grind run {name}, cold: s": ["-m", "grind_env", "run", str(grind_env.examples.path(name))]
        for name in grind_env.examples.names()
    }
    for env_id in (name for name in gym.registry if name.startswith("grind/")):
        code = f"import gymnasium, grind_env; e = gymnasium.make('{env_id}'); e.reset(seed=0); "
        commands[f"{env_id}, first step, cold: s"] = ["-c", code + "e.step(e.action_space.sample())"]
    found = {}
    for name, arguments in commands.items():
        with tempfile.TemporaryDirectory() as folder:
            found[name] = child([sys.executable, *arguments], NUMBA_CACHE_DIR=folder)
    return found


def seconds(call: Callable[..., object], *arguments: Any) -> float:
    """CPU time of one call, s."""
    begin = time.process_time()
    call(*arguments)
    return time.process_time() - begin


def child(command: list[str], **environment: str) -> float:
    """CPU time of a process, s."""
    begin = sum(os.times()[2:4])
    subprocess.run(command, check=True, env={**os.environ, **environment}, stdout=subprocess.DEVNULL)
    return sum(os.times()[2:4]) - begin


def vector(task: str, n: int, steps: int) -> dict[str, float]:
    """A step of one environment among n, with the resets at the ends of episodes, and a reset."""
    env = gym.make_vec(f"grind/{task}-v0", num_envs=n, autoreset_mode="SameStep")
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1.0, 1.0, (steps, *env.action_space.shape)).astype(np.float32)
    env.step(actions[0])
    spent = sum(seconds(env.step, action) for action in actions)
    reset = min(seconds(env.reset) for _ in range(3))
    name = f"{task}, N = {n}"
    return {f"{name}: us a step": 1e6 * spent / (steps * n), f"{name}: us a reset": 1e6 * reset / n}


def single(task: str) -> dict[str, float]:
    """A step of the single environment."""
    env = gym.make(f"grind/{task}-v0")
    env.action_space.seed(0)

    def episodes() -> int:
        made = 0
        for seed in range(10):
            env.reset(seed=seed)
            over = False
            while not over:
                over = env.step(env.action_space.sample())[2]
                made += 1
        return made

    episodes()
    gc.collect()
    gc.freeze()  # or a collection of all that is loaded, 0.1 s, falls into one tree and not into the other
    begin = time.process_time()
    made = episodes()
    return {f"{task}, single: us a step, resets included": 1e6 * (time.process_time() - begin) / made}


def control() -> dict[str, float]:
    """A block of a zigzag of short lines, as a profile of a form wheel is written, plain and compensated."""
    found = {}
    for name, code in (("plain", "G40"), ("compensated", "G41")):
        lines = (f"N{number} G01 Z{number}.5 X{number % 2}.25" for number in range(BLOCKS))
        text = "\n".join([f"G18 G90 G94 {code} F600.", *lines, "M30\n"])
        settings = Control(radius=0.1, block_budget=2 * BLOCKS)
        programs = grind_env.parse_program(text)

        def run(programs: Any = programs, settings: Any = settings) -> None:
            for _ in execute(programs, settings):
                pass

        found[f"control, {name}: us a block"] = 1e6 * seconds(run) / BLOCKS
    return found


def search() -> dict[str, float]:
    """A search that ends before its budget does."""
    plate = grind_env.examples.path("plate_g82.nc")
    grind_env.optimise(plate, budget=1.0)
    return {"optimise, one plate: s": min(seconds(lambda: grind_env.optimise(plate, budget=60.0)) for _ in range(2))}


if __name__ == "__main__":
    print(json.dumps(measured() if sys.argv[1:] != ["cold"] else cold()))
