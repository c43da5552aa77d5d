"""Choices before a block: E and D, and all choices that a task allows."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from grind_env.array_types import Array
from grind_env.envs.tasks import Task
from grind_env.errors import GrindError


class Decision(NamedTuple):
    """E and D, float64: of the coming block, each shape (N,), or as a plan, each shape (N, blocks).

    `speeds` is E in mm/min; `executions` is D, a number of dress executions.
    """

    speeds: Array
    executions: Array


def check_speeds(policy: str, E: float | Sequence[float], task: Task, *, within: bool = False) -> None:
    """Raise a `GrindError` for an E that is meant in m/min, and with `within` for every E outside the task's range.

    The reference E of a rule may lie outside: the rule changes it before it is used.
    """
    low, high = task.action.speed_ends
    for each in np.atleast_1d(E):
        meant = each < low <= 1000.0 * each <= high
        if meant or (within and not low <= each <= high):
            proposed = f" (did you mean {1000.0 * each:g}?)" if meant else ""
            raise GrindError(f"{policy}: E is {each:g} mm/min{proposed}, but {task.name} has {low:g} to {high:g}")


def nearest_speed(task: Task, speeds: ArrayLike) -> Array:
    """Return the allowed E nearest to `speeds`, mm/min, of the same shape: whole numbers, or levels of the task."""
    wanted = np.asarray(speeds, np.float64)
    if task.action.speed_levels is not None:
        levels = np.array(task.action.speed_levels)
        return np.asarray(levels[np.abs(np.log(wanted[..., None] / levels)).argmin(axis=-1)])
    low, high = task.action.speed_ends
    return np.floor(np.clip(wanted, low, high) + 0.5)


def speed_grid(task: Task, count: int) -> Array:
    """Return E to try, mm/min, shape (values,): the levels of the task, or `count` values, geometrically spaced."""
    if task.action.speed_levels is not None:
        return np.array(task.action.speed_levels)
    return nearest_speed(task, np.geomspace(*task.action.speed_ends, count))


def all_choices(task: Task, speeds: int) -> Decision:
    """Return every pair of E and D, with the levels of the task or `speeds` values of E over its range."""
    E = speed_grid(task, speeds)
    D = np.arange(task.action.executions + 1.0)
    return Decision(np.repeat(E, len(D)), np.tile(D, len(E)))


def cheapest_choice(task: Task, n: int, speeds: int, cheapest: Callable[[Decision], Decision]) -> Decision:
    """Return the cheapest E and D of N episodes, each shape (N,).

    Args:
        task: task that limits the choices.
        n: number of episodes.
        speeds: number of E tried first, geometrically spaced; then `speeds` - 1 between the neighbours of the best E.
        cheapest: function that returns the cheapest of some choices, each shape (N, choices).
    """
    best = cheapest(Decision(*(np.tile(values, (n, 1)) for values in all_choices(task, speeds))))
    if task.action.speed_levels is not None:
        return best
    low, high = task.action.speed_ends
    ratio = (high / low) ** (1.0 / (speeds - 1))
    near = best.speeds[:, None] * np.geomspace(1.0 / ratio, ratio, speeds + 1)[1:-1]
    same = np.repeat(best.executions[:, None], speeds - 1, axis=1)
    return cheapest(Decision(nearest_speed(task, near), same))
