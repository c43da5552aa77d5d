"""Time to the first result, in new processes with an empty cache: part of `make speed`."""

import os
import subprocess
import sys
import tempfile

import gymnasium as gym
from rich.table import Table

import grind_env


def cold() -> dict[str, float]:
    """Return the CPU time of the first commands of a newcomer, s: each in a new process with an empty cache."""
    commands = {
        f"grind run {name}, cold: s": ["-m", "grind_env", "run", str(grind_env.examples.path(name))]
        for name in grind_env.examples.names()
    }
    for env_id in (name for name in gym.registry if name.startswith("grind/")):
        code = f"import gymnasium, grind_env; e = gymnasium.make('{env_id}'); e.reset(seed=0); "
        commands[f"{env_id}, first step, cold: s"] = ["-c", code + "e.step(e.action_space.sample())"]
    found = {}
    for name, arguments in commands.items():
        begin = sum(os.times()[2:4])
        with tempfile.TemporaryDirectory() as folder:
            environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
            subprocess.run([sys.executable, *arguments], check=True, env=environment, stdout=subprocess.DEVNULL)
        found[name] = sum(os.times()[2:4]) - begin
    return found


def table() -> Table:
    """Return a table of the CPU times and their targets."""
    result = Table(title="First results")
    for name in ("measure", "value", "target"):
        result.add_column(name, justify="left" if name == "measure" else "right")
    for name, taken in cold().items():
        result.add_row(name, f"{taken:.2f} s", "<= 1.2" if name.startswith("grind run") else "<= 1.5")
    return result
