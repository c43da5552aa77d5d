"""A step of many episodes shared among threads: compiled code releases Python's lock."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Table
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation


def step_shared(
    simulation: Simulation, episodes: Episodes, choice: tuple[Table, ...], active: NDArray[np.int64], threads: int
) -> Table:
    """Grind the next block of the episodes in `active` on `threads` threads; return shape (N, fields of `Outcome`).

    The result of an episode does not depend on the other episodes. With more than one thread the simulation must be
    compiled; `choice` is as for `Simulation.step`.
    """

    def outcomes_of(share: NDArray[np.int64]) -> Table:
        return simulation.step(episodes, *choice, active=share)[0]

    if threads == 1:
        return outcomes_of(active)
    shares = np.array_split(active, threads)
    with ThreadPoolExecutor(threads - 1) as pool:
        others = pool.map(outcomes_of, shares[1:])
        outcomes = outcomes_of(shares[0])
        for share, each in zip(shares[1:], others, strict=True):
            outcomes[share] = each[share]
    return outcomes
