"""Peak power as a power law of what was ground, learned from readings as they come."""

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array

FIRST, SPREAD = np.array([0.0, 0.7, 0.15]), np.array([30.0, 0.2, 0.15])
"""Level and exponents before anything has been read, and how well they are known: the level not at all."""
SCATTER = 0.05
"""Of a reading about the law, in logarithms."""
FORGETTING = 0.97
"""Weight of a reading when the next one has come."""
WORN_IN = 10.0
"""mm3/mm; a freshly dressed wheel is as dull as one that has ground so much."""
LEAST_EXPONENT = 0.2
"""Of the removal rate, when it is asked for."""


class PowerLaw:
    """Peak power P of N machines over their removal rates Q and the volume V' ground since the dress.

        ln P = c + f ln Q + g ln(V' + 10 mm3/mm)

    Recursive least squares with exponential forgetting (Astrom and Wittenmark, Adaptive Control, section 2.2).

    Attributes:
        found: c, f and g, shape (N, 3).
        known: which of the machines have been read, shape (N,).
    """

    def __init__(self, machines: int) -> None:
        self.found = np.tile(FIRST, (machines, 1))
        self.known = np.zeros(machines, bool)
        self._covariance = np.tile(np.diag(SPREAD**2), (machines, 1, 1))

    def learn(self, power: Array, removal: Array, volume: Array, read: NDArray[np.bool_]) -> None:
        """Take readings of the machines in `read`: W, mm3/s and mm3/mm, each shape (N,)."""
        x = np.stack([np.ones(len(removal)), np.log(np.maximum(removal, 1e-9)), np.log(volume + WORN_IN)], axis=1)
        covariance = self._covariance / FORGETTING
        along = np.einsum("nij,nj->ni", covariance, x)
        gain = along / (SCATTER**2 + np.einsum("ni,ni->n", x, along))[:, None]
        surprise = np.log(np.maximum(power, 1.0)) - np.einsum("ni,ni->n", x, self.found)
        covariance = covariance - gain[:, :, None] * along[:, None, :]
        # what is never tried must not be forgotten beyond what was known before anything was read
        spread = np.sqrt(np.maximum(np.einsum("nii->ni", covariance), 1e-12))
        least = np.minimum(1.0, SPREAD / spread)
        covariance *= least[:, :, None] * least[:, None, :]
        self.found = np.where(read[:, None], self.found + gain * surprise[:, None], self.found)
        self._covariance = np.where(read[:, None, None], covariance, self._covariance)
        self.known = self.known | read

    def removal(self, power: float, volume: Array) -> Array:
        """The removal rate at which a wheel that has ground `volume`, shape (N,), takes `power`, W; in mm3/s."""
        level, rate, dulling = self.found.T
        wanted = (np.log(power) - level - dulling * np.log(volume + WORN_IN)) / np.maximum(rate, LEAST_EXPONENT)
        return np.asarray(np.exp(np.clip(wanted, -50.0, 50.0)))
