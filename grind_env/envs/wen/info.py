"""What a step of `grind/Wen-v0` tells beside observation and reward."""

from typing import Any

from grind_env.arrays import Array
from grind_env.envs.wen.judging import OBJECTIVE, VIOLATION
from grind_env.envs.wen.model import Setting, WenVerdict


def report(settings: Array, verdicts: Array) -> dict[str, Any]:
    """The info of N steps as columns, shape (N,) each."""
    return {
        "reward_terms": {
            "objective": 0.0 - verdicts[:, OBJECTIVE],
            "violation": 0.0 - verdicts[:, VIOLATION],
        },
        "cost": verdicts[:, VIOLATION].copy(),
        **{name: verdicts[:, k].copy() for k, name in enumerate(WenVerdict._fields[:OBJECTIVE])},
        **{name: settings[:, k].copy() for k, name in enumerate(Setting._fields)},
    }


def with_masks(columns: dict[str, Any], mask: Array) -> dict[str, Any]:
    """A vector info: every entry with its mask beside it, in nested dicts too."""
    info: dict[str, Any] = {}
    for name, value in columns.items():
        info[name] = with_masks(value, mask) if isinstance(value, dict) else value
        info[f"_{name}"] = mask.copy()
    return info
