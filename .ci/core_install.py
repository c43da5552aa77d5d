"""Check a core install: without torch and Stable-Baselines3, every environment is made and stepped.

Run by `make core` from outside the checkout, with the Python of the environment that holds the install alone.
"""

import importlib.util
import sys
from pathlib import Path

import gymnasium as gym
from gymnasium.vector import AutoresetMode

import grind_env

HEAVY = ("torch", "stable_baselines3", "matplotlib", "pandas")


def main() -> str | None:
    """Return what is wrong, or print one line and return None."""
    present = [name for name in HEAVY if importlib.util.find_spec(name) is not None]
    if present:
        return f"not a core install: {', '.join(present)} can be imported"
    if Path(grind_env.__file__).parents[1] == Path(__file__).resolve().parents[1]:
        return f"not the installed package: {grind_env.__file__} belongs to the checkout"

    ids = [name for name in gym.registry if name.startswith("grind/")]
    if not ids:
        return "importing grind_env registered no environment"
    for name in ids:
        env = gym.make(name)
        env.reset(seed=0)
        env.step(env.action_space.sample())
        for mode in AutoresetMode:
            vector = gym.make_vec(name, num_envs=4, autoreset_mode=mode)
            vector.reset(seed=0)
            vector.step(vector.action_space.sample())
    print(f"OK: core install of grind_env {grind_env.__version__}, {len(ids)} environments stepped")
    return None


if __name__ == "__main__":
    sys.exit(main())
