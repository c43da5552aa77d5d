"""Power laws of power, roughness and size, updated from a shop's readings."""

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array, Numbers

#: level and exponents of power before the first reading, and their standard deviations; the level is unknown
FIRST, SPREAD = np.array([0.0, 0.7, 0.15]), np.array([30.0, 0.2, 0.15])
SCATTER = 0.05  #: standard deviation of a reading around the law, in logarithms
FORGETTING = 0.97  #: factor on the weight of a reading with each further reading
WORN_IN = 10.0  #: volume, mm3/mm, that a freshly dressed wheel counts as having ground
LEAST_EXPONENT = 0.2  #: least exponent of the removal rate, when the law is solved for the removal rate
#: aimed mean of a part's value over its limit: 2.5 standard deviations below the limit, with an Ra scatter of 17 %
AIM = 0.65


class PowerLaw:
    """Law of the peak power P of N machines by removal rate Q and volume V' ground since the dress.

        ln P = c + f ln Q + g ln(V' + 10 mm3/mm)

    Recursive least squares with exponential forgetting (Astrom and Wittenmark, Adaptive Control, section 2.2).
    """

    def __init__(self, machines: int) -> None:
        self.found = np.tile(FIRST, (machines, 1))  # c, f and g, shape (N, 3)
        self.known = np.zeros(machines, bool)  # whether a machine has been read, shape (N,)
        # forecast of the logarithm of the last reading, from before the law learned the reading, and the standard
        # deviation of this forecast, shape (N,)
        self.expected, self.spread = np.zeros(machines), np.ones(machines)
        self._covariance = np.tile(np.diag(SPREAD**2), (machines, 1, 1))

    def learn(self, power: Array, removal: Array, volume: Array, read: NDArray[np.bool_]) -> None:
        """Learn the readings of the machines in `read`: W, mm3/s and mm3/mm, each shape (N,)."""
        x = np.stack([np.ones(len(removal)), np.log(np.maximum(removal, 1e-9)), np.log(volume + WORN_IN)], axis=1)
        covariance = self._covariance / FORGETTING
        along = np.einsum("nij,nj->ni", covariance, x)
        self.expected = np.einsum("ni,ni->n", x, self.found)
        self.spread = np.sqrt(SCATTER**2 + np.einsum("ni,ni->n", x, along))
        gain = along / self.spread[:, None] ** 2
        surprise = np.log(np.maximum(power, 1.0)) - self.expected
        covariance = covariance - gain[:, :, None] * along[:, None, :]
        # forgetting must not make any direction less certain than before the first reading
        spread = np.sqrt(np.maximum(np.einsum("nii->ni", covariance), 1e-12))
        least = np.minimum(1.0, SPREAD / spread)
        covariance *= least[:, :, None] * least[:, None, :]
        self.found = np.where(read[:, None], self.found + gain * surprise[:, None], self.found)
        self._covariance = np.where(read[:, None, None], covariance, self._covariance)
        self.known = self.known | read

    def removal(self, power: Array, volume: Array) -> Array:
        """Return the removal rate, mm3/s, at which a wheel after `volume` takes `power`, W; each shape (N,)."""
        level, rate, dulling = self.found.T
        wanted = (np.log(power) - level - dulling * np.log(volume + WORN_IN)) / np.maximum(rate, LEAST_EXPONENT)
        return np.asarray(np.exp(np.clip(wanted, -50.0, 50.0)))


class PartLaw:
    """Law of a gauged value over its limit, c E^x, for N machines and kinds of part; E in units of a usual E.

    Args:
        machines: number N of machines.
        limits: limit of each kind of part, 0 for none, shape (kinds,).
        exponent: exponent x.
        usual: c before the first reading.
        memory: number of parts after which the level is a running mean.
        aim: aimed share of a limit, in the mean.
    """

    def __init__(
        self, machines: int, limits: Array, *, exponent: float, usual: float, memory: float, aim: float = AIM
    ) -> None:
        self._exponent, self._least, self._memory, self._aim = exponent, 0.1 * usual, memory, aim
        self._level = np.tile(np.where(limits > 0.0, np.log(usual), -np.inf), (machines, 1))
        self._parts = np.ones(self._level.shape)

    def learn(self, ratio: Array, kinds: Numbers, speeds: Array, read: NDArray[np.bool_]) -> None:
        """Learn the gauged values over their limits of parts of these kinds, ground with these E; each shape (N,)."""
        at = np.flatnonzero(read), kinds[read]
        self._parts[at] = np.minimum(self._parts[at] + 1.0, self._memory)
        level = np.log(np.maximum(ratio[read], self._least)) - self._exponent * np.log(speeds[read])
        self._level[at] += (level - self._level[at]) / self._parts[at]

    def speed(self, kinds: Numbers) -> Array:
        """Return the E at which parts of these kinds reach the aimed share of their limit, shape (N,), or infinity."""
        level = self._level[np.arange(len(kinds)), kinds]
        return np.asarray(np.exp((np.log(self._aim) - level) / self._exponent))
