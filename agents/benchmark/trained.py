"""A trained agent among the policies of a benchmark."""

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.files import read_bytes
from grind_env.policies.choices import Decision
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.policy import Policy, Sees

ZIP = ".zip"


@dataclass
class Trained:
    """A trained agent that goes by the hash of its file, so that what is kept of it belongs to these very weights."""

    name: str
    digest: str
    policy: Policy = field(repr=False)
    sees: Sees = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.sees = self.policy.sees

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.policy.begin(simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        return self.policy.act(observation, episodes)


def from_file(path: Path, simulation: Simulation, name: str) -> Trained:
    """The trained agent in a file, which may be a .zip of Stable-Baselines3 that was made here."""
    digest = hashlib.sha256(read_bytes(path)).hexdigest()
    if path.suffix == ZIP:
        # it takes seconds to import
        from grind_env.sb3 import load_zip

        return Trained(name, digest, load_zip(path, simulation))
    return Trained(name, digest, load_policy(path, simulation=simulation, name=name))
