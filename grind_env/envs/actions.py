"""From an action to E and D, and back.

The default action is `Box(-1, 1, (2,))`. Its first component chooses E, geometrically over the speed range
(or in equal bins over the speed levels) and rounded to whole mm/min, as a part program would say it; the
second chooses D in equal-width floor bins, so that a uniform action gives every D the same chance.
"""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from grind_env.envs.tasks import Task
from grind_env.errors import GrindError
from grind_env.kernel import entry, exp, log


class ActionError(GrindError):
    """An action that is not in the action space."""


def action_array(actions: ArrayLike, count: int | None = None) -> NDArray[np.float64]:
    """Actions as numbers, shape (count, 2); any count if none is given.

    Raises:
        ActionError: if they are not numbers or have another shape.
    """
    try:
        values = np.asarray(actions, np.float64)
    except (TypeError, ValueError):
        raise ActionError(f"actions are {actions!r}, but must be an array of numbers, E and D of each env") from None
    if values.ndim != 2 or values.shape != (count or len(values), 2):
        raise ActionError(
            f"actions have shape {values.shape}, but must have shape ({count or 'N'}, 2): E and D of each env"
        )
    return values


class ActionCodec:
    """The action space of a task and the way between an action and (E, D)."""

    def __init__(self, task: Task) -> None:
        low, high = task.action.speed_range or (0.0, 0.0)
        self.levels = 1000.0 * np.array(task.action.speed_levels or (), np.float64)
        self.low, self.high = 1000.0 * low, 1000.0 * high
        self.executions = task.action.executions
        self.space = spaces.Box(-1.0, 1.0, (2,), np.float32)

    def decode(self, actions: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """E in mm/min and D, each shape (N,), of actions of shape (N, 2).

        Raises:
            ActionError: if an action has another shape, is not a number or lies outside -1..1.
        """
        values = action_array(actions)
        good = np.abs(values) <= 1.0
        if not good.all():
            i, k = np.argwhere(~good)[0]
            name = ("E", "D")[k]
            raise ActionError(f"action {i} has {values[i, k]} for {name}, but must lie between -1 and 1: clip it first")
        speeds, executions = np.empty(len(values)), np.empty(len(values))
        _decode(values, self.levels, self.low, self.high, float(self.executions), speeds, executions)
        return speeds, executions

    def encode(self, speeds: ArrayLike, executions: ArrayLike) -> NDArray[np.float32]:
        """Actions, shape (N, 2), that choose E in mm/min and D, each shape (N,); the middle of every bin.

        Raises:
            ActionError: if E or D cannot be chosen in this task.
        """
        E = np.atleast_1d(np.asarray(speeds, np.float64))
        D = np.atleast_1d(np.asarray(executions, np.float64))
        good = np.isin(D, np.arange(self.executions + 1))
        if not good.all():
            raise ActionError(f"D is {D[~good][0]:g}, but must be a whole number from 0 to {self.executions}")
        if len(self.levels):
            distance = np.abs(E[:, None] - self.levels)
            good = distance.min(axis=1) <= 0.5
            if not good.all():
                levels = ", ".join(f"{level:g}" for level in self.levels)
                raise ActionError(f"E is {E[~good][0]:g} mm/min, but must be one of {levels} mm/min")
            u0 = 2.0 * (distance.argmin(axis=1) + 0.5) / len(self.levels) - 1.0
        else:
            good = (self.low - 0.5 <= E) & (self.high + 0.5 >= E)
            if not good.all():
                raise ActionError(f"E is {E[~good][0]:g} mm/min, but must be from {self.low:g} to {self.high:g} mm/min")
            u0 = 2.0 * np.log(E / self.low) / np.log(self.high / self.low) - 1.0
        u1 = 2.0 * (D + 0.5) / (self.executions + 1) - 1.0
        actions: NDArray[np.float32] = np.clip(np.stack([u0, u1], axis=1), -1.0, 1.0).astype(np.float32)
        return actions


@entry
def _decode(actions: Any, levels: Any, low: float, high: float, most: float, speeds: Any, executions: Any) -> None:
    for i in range(actions.shape[0]):
        u = 0.5 * (actions[i, 0] + 1.0)
        if levels.size > 0:
            speeds[i] = levels[min(int(u * levels.size), levels.size - 1)]
        else:
            speeds[i] = np.floor(low * exp(u * log(high / low)) + 0.5)
        executions[i] = min(np.floor(0.5 * (actions[i, 1] + 1.0) * (most + 1.0)), most)
