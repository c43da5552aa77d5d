"""The action of `grind/Wen-v0` as a setting, and arguments that mean something in the other ids only."""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from grind_env.arrays import Array
from grind_env.envs.actions import IN_BOX, ActionError, check_shape, illegal, real_numbers
from grind_env.envs.arguments import check_flags, is_full, refuse_cycle, refuse_predress
from grind_env.envs.tasks import TaskError
from grind_env.envs.wen.model import HIGHEST, LOWEST, Setting

LOW, HIGH = np.array(LOWEST), np.array(HIGHEST)
"""Bounds of a setting."""


def action_space() -> spaces.Box[np.float32]:
    """One number from -1 to 1 for each part of a setting."""
    return spaces.Box(-1.0, 1.0, (len(Setting._fields),), np.float32)


def check_arguments(
    action: object, observation: object, show_block: object, predress: bool, cycle: object, plant: object
) -> None:
    """Check arguments that all ids share.

    Args:
        action: form of the action.
        observation: `"measured"` or `"full"`, which are the same here.
        show_block: False.
        predress: False.
        cycle: None.
        plant: None.

    Raises:
        ActionError: the form is not `"box"`, or a pre-dress is asked for.
        TaskError: there is no such observation, or the text of a block, a cycle or a machine is asked for.
    """
    if not isinstance(action, str) or action != "box":
        raise ActionError(
            f"action is {action!r}, but must be 'box' in grind/Wen-v0: its settings are continuous, and none is E or D"
        )
    is_full(observation)
    check_flags(show_block=show_block, predress=predress)
    refuse_predress(predress, "in grind/Wen-v0 nothing is dressed")
    refuse_cycle(cycle, "grind/Wen-v0 runs no program")
    if plant is not None:
        raise TaskError(f"plant is {plant!r}, but grind/Wen-v0 has the model that it was published with: leave it out")
    if show_block:
        raise TaskError(f"show_block is {show_block!r}, but grind/Wen-v0 runs no block of a program: leave it out")


def action_array(actions: ArrayLike, count: int) -> NDArray[Any]:
    """Actions as numbers, shape (count, fields of `Setting`).

    Raises:
        ActionError: if they are not numbers or have another shape.
    """
    names = ", ".join(Setting._fields)
    values = real_numbers(actions, names)
    if values.shape != (count, len(Setting._fields)):
        raise ActionError(
            f"actions have shape {values.shape}, but must have shape ({count}, {len(Setting._fields)}): "
            f"{names} of each env"
        )
    return values


def single_array(action: ArrayLike) -> NDArray[Any]:
    """One action as a batch of one, shape (1, fields of `Setting`).

    Raises:
        ActionError: if it is not numbers or has another shape.
    """
    names = ", ".join(Setting._fields)
    values = real_numbers(action, names)
    check_shape(values, (len(Setting._fields),), names)
    return values[None]


def decode(values: Array) -> Array:
    """Settings, shape (N, fields of `Setting`), of actions of that shape: linear from -1..1 onto the bounds.

    Raises:
        ActionError: if an action is not a number or lies outside -1..1.
    """
    good = np.abs(values) <= 1.0
    if not good.all():
        i, k = np.argwhere(~good)[0]
        name = Setting._fields[k]
        raise illegal(int(i), name, float(values[i, k]), IN_BOX)
    settings: Array = LOW + 0.5 * (values + 1.0) * (HIGH - LOW)
    return settings
