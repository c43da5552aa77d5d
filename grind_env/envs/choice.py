"""From an action to E, D and yes-or-no, for environments that run their blocks one by one.

The decoding is that of `actions`: E geometric over a range and rounded to whole mm/min, D in equal-width floor bins.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from grind_env.envs.actions import ActionError
from grind_env.kernel import entry, exp, log


class Choice(NamedTuple):
    """What an agent chooses for a block."""

    speed: float
    """E, mm/min."""
    executions: int
    """D."""
    pre_dress: bool = False
    """Whether the cycle is programmed with ``.1``."""


@dataclass(frozen=True, slots=True)
class Choices:
    """The choices that actions stand for.

    Attributes:
        low: lowest E, mm/min.
        high: highest E, mm/min.
        most: highest D.
        pre_dress: whether there is a third component, above 0 for a pre-dress.
    """

    low: float
    high: float
    most: int
    pre_dress: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """What the components of an action choose."""
        return ("E", "D", "pre-dress") if self.pre_dress else ("E", "D")

    @property
    def space(self) -> spaces.Space[NDArray[np.float32]]:
        """The action space."""
        space: spaces.Space[Any] = spaces.Box(-1.0, 1.0, (len(self.names),), np.float32)
        return space

    def decode(self, action: ArrayLike) -> Choice:
        """The choice of an action.

        Raises:
            ActionError: it has another shape, is not made of numbers or lies outside -1..1.
        """
        names = ", ".join(self.names)
        try:
            values = np.asarray(action, np.float64)
        except (TypeError, ValueError):
            raise ActionError(f"the action is {action!r}, but must be an array of numbers: {names}") from None
        if values.shape != (len(self.names),):
            raise ActionError(f"the action has shape {values.shape}, but must have shape ({len(self.names)},): {names}")
        for name, value in zip(self.names, values, strict=True):
            if not abs(value) <= 1.0:
                raise ActionError(f"the action has {value} for {name}, but must lie between -1 and 1: clip it first")
        speed = geometric(0.5 * (values[0] + 1.0), self.low, self.high)
        executions = min(int(0.5 * (values[1] + 1.0) * (self.most + 1.0)), self.most)
        return Choice(speed, executions, self.pre_dress and bool(values[2] > 0.0))

    def encode(self, choice: Choice) -> NDArray[np.float32]:
        """The action that stands for a choice, in the middle of its bin.

        Raises:
            ActionError: no action does.
        """
        if not self.low <= choice.speed <= self.high:
            raise ActionError(f"E is {choice.speed:g} mm/min, but must be from {self.low:g} to {self.high:g} mm/min")
        if choice.executions not in range(self.most + 1):
            raise ActionError(f"D is {choice.executions}, but must be a whole number from 0 to {self.most}")
        if choice.pre_dress and not self.pre_dress:
            raise ActionError("a pre-dress is asked for, but there is none to choose: make it with predress=True")
        speed = 2.0 * np.log(choice.speed / self.low) / np.log(self.high / self.low) - 1.0
        executions = 2.0 * (choice.executions + 0.5) / (self.most + 1) - 1.0
        values = (speed, executions, 0.5 if choice.pre_dress else -0.5)[: len(self.names)]
        action: NDArray[np.float32] = np.clip(np.array(values), -1.0, 1.0).astype(np.float32)
        return action


@entry
def geometric(share: float, low: float, high: float) -> float:
    """The whole number that lies at a share of the way from `low` to `high`, on a logarithmic scale."""
    return float(np.floor(low * exp(share * log(high / low)) + 0.5))


@entry
def log_normal(sigma: float, normals: Any, cut: float) -> Any:
    """Factors exp(sigma z) for standard normal numbers z, cut at `cut` standard deviations."""
    factors = np.empty_like(normals)
    for i in range(normals.size):
        factors[i] = exp(sigma * min(max(normals[i], -cut), cut))
    return factors
