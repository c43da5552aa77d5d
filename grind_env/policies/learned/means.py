"""Running means of what was measured: what a single noisy reading does not say of a lot, a wheel or a coolant."""

import numpy as np
from numpy.typing import NDArray

MEMORIES = (0.9, 0.98)
"""Share of a mean that is left after a block: memories of about 10 and 50 blocks."""


class RunningMeans:
    """Means of every entry of the observations of N episodes so far, the older ones weighing ever less.

    Args:
        entries: of an observation.
    """

    def __init__(self, entries: int) -> None:
        self.entries = entries
        self.begin(0)

    def begin(self, n: int) -> None:
        self.sums = np.zeros((n, len(MEMORIES), self.entries))
        self.weights = np.zeros((n, len(MEMORIES), 1))

    def restart(self, mask: NDArray[np.bool_]) -> None:
        """The episodes in `mask`, shape (N,), begin with their next observation."""
        self.sums[mask] = 0.0
        self.weights[mask] = 0.0

    def take(self, observations: NDArray[np.float32], mask: NDArray[np.bool_]) -> NDArray[np.float32]:
        """Take in observations, shape (N, entries), of the episodes in `mask`; those of the others mean nothing.

        Returns:
            The means, shape (N, len(MEMORIES) * entries); a new array.
        """
        left = np.array(MEMORIES)[:, None]
        self.sums[mask] = left * self.sums[mask] + observations[mask, None]
        self.weights[mask] = left * self.weights[mask] + 1.0
        means = self.sums / np.maximum(self.weights, 1.0)
        return means.reshape(len(observations), -1).astype(np.float32)
