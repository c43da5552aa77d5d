"""The `Policy` protocol.

A policy decides E and D of the coming step for N episodes side by side, in any environment with a `Simulation`. Its
`sees` declares the information it needs.
"""

from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision

#: `measurements`: what a real machine measures; `state`: the true state before the coming block, and its true lot and
#: stock; `future`: every later lot and stock too
Sees = Literal["measurements", "state", "future"]


class Policy(Protocol):
    """Policy that decides E and D of every step of N episodes side by side."""

    @property
    def name(self) -> str:
        """Name in tables and on the command line."""

    @property
    def sees(self) -> Sees:
        """Return the information that `act` sees."""

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Forget everything; `episodes` new episodes of the simulation begin."""

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Decide the coming step.

        Args:
            observation: scaled measurements, shape (N, entries); `Simulation.read` converts them to physical units.
            episodes: None for a policy that sees measurements, else the result of `reveal`; the policy may change it.
        """
