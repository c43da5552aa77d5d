"""What the rules on gauges and power monitors read of an observation."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array
from grind_env.envs.branches import coming_kinds
from grind_env.envs.simulation import Simulation


class Instruments:
    """The measured readings of N episodes, with the kinds of the coming and of the last block.

    Args:
        simulation: of the environment.
        episodes: number of episodes, all before their first block.
    """

    def __init__(self, simulation: Simulation, episodes: int) -> None:
        self.simulation = simulation
        self.kind = np.zeros(episodes, np.int64)
        self.last_kind = np.zeros(episodes, np.int64)

    def read(self, observation: NDArray[np.float32]) -> dict[str, Array]:
        """Readings in physical units by name, each shape (N,); the kinds move on by one block."""
        seen = self.simulation.read(observation)
        self.last_kind, self.kind = self.kind, coming_kinds(self.simulation.branches, seen)
        return seen

    def of_kind(self, values: tuple[Any, ...]) -> Array:
        """The entry of each episode's coming kind, from one entry a kind; shape (N,)."""
        return np.array(values, np.float64)[self.kind]
