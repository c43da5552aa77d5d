"""Trained agents from the files of a benchmark."""

from pathlib import Path
from typing import Any

from grind_env.envs.simulation import Simulation
from grind_env.policies.learned.saved import load_policy

ZIP = ".zip"


def from_file(path: Path, simulation: Simulation, name: str) -> Any:
    """Return the agent in a file, perhaps a .zip of Stable-Baselines3 made here; its repr identifies its weights."""
    if path.suffix != ZIP:
        return load_policy(path, simulation=simulation, name=name)
    # grind_env.sb3 takes seconds to import
    from grind_env.sb3 import load_zip

    policy = load_zip(path, simulation)
    policy.name = name
    return policy
