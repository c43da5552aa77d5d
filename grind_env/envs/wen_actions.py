"""What `grind/Wen-v0` is given: the one form of its action, and arguments that mean something in the other ids only."""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from grind_env.envs.actions import ActionError
from grind_env.envs.arguments import check_flags, is_full, refuse_predress
from grind_env.envs.tasks import TaskError
from grind_env.process.wen import Setting


def action_space() -> spaces.Box[np.float32]:
    """One number from -1 to 1 for each part of a setting."""
    return spaces.Box(-1.0, 1.0, (len(Setting._fields),), np.float32)


def check_arguments(action: object, observation: object, show_block: object, predress: bool) -> None:
    """Check arguments that all ids share.

    Args:
        action: form of the action.
        observation: `"measured"` or `"full"`, which are the same here.
        show_block: False.
        predress: False.

    Raises:
        ActionError: the form is not `"box"`, or a pre-dress is asked for.
        TaskError: there is no such observation, or the text of a block is asked for.
    """
    if not isinstance(action, str) or action != "box":
        raise ActionError(
            f"action is {action!r}, but must be 'box' in grind/Wen-v0: its settings are continuous, and none is E or D"
        )
    is_full(observation)
    check_flags(show_block=show_block, predress=predress)
    refuse_predress(predress, "in grind/Wen-v0 nothing is dressed")
    if show_block:
        raise TaskError(f"show_block is {show_block!r}, but grind/Wen-v0 runs no block of a program: leave it out")


def action_array(actions: ArrayLike, count: int) -> NDArray[Any]:
    """Actions as numbers, shape (count, fields of `Setting`).

    Raises:
        ActionError: if they are not numbers or have another shape.
    """
    names = ", ".join(Setting._fields)
    try:
        values = np.asarray(actions, np.float64)
    except (TypeError, ValueError):
        raise ActionError(f"actions are {actions!r}, but must be an array of numbers, {names} of each env") from None
    if values.shape != (count, len(Setting._fields)):
        raise ActionError(
            f"actions have shape {values.shape}, but must have shape ({count}, {len(Setting._fields)}): "
            f"{names} of each env"
        )
    return values
