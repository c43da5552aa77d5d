"""Tunable parameters of the scripted policies, with ranges."""

from typing import Any, NamedTuple

import numpy as np

from grind_env.envs.tasks import Task
from grind_env.policies.tuned_parameters import Parameters

DIGITS = 5


class Coefficient(NamedTuple):
    """Parameter as a function of the search variable z: `start + step z`, or `start exp(step z)` if `positive`.

    `whole` is for a number of executions, `blocks` for a number of blocks. `needs` is a table that the task must have.
    """

    name: str
    start: float
    step: float
    positive: bool = False
    by_kind: bool = False
    whole: bool = False
    blocks: bool = False
    most: float = np.inf
    needs: str | None = None

    def size(self, task: Task) -> int:
        """Return the number of entries in the search vector: none if the task lacks its feature."""
        if self.needs is not None and getattr(task, self.needs) is None:
            return 0
        return len(task.kinds) if self.by_kind else 1

    def value(self, z: float, executions: int) -> float:
        """Return the parameter at z, rounded as in the file; `executions` is the largest D of the task."""
        change = self.step * z
        value = self.start * np.exp(np.clip(change, -5.0, 5.0)) if self.positive else self.start + change
        if self.blocks:
            return max(int(np.rint(value)), 1)
        return int(np.clip(np.rint(value), 0, executions)) if self.whole else rounded(min(value, self.most))


SHARPNESS = (
    Coefficient("E", 12_000.0, 0.2, positive=True, by_kind=True),
    Coefficient("A_dress", 0.015, 0.2, positive=True, by_kind=True),
    Coefficient("gA", -0.3, 0.2),
    Coefficient("gF", 0.0, 0.1),
    Coefficient("gH", 0.0, 0.1),
    Coefficient("wV", 0.0, 0.2),
    Coefficient("wH", 0.5, 0.2),
    Coefficient("gP", 0.0, 0.1, needs="due"),
    Coefficient("wP", 0.0, 0.1, needs="due"),
    Coefficient("gB", 0.0, 0.1, needs="wheel_change"),
    Coefficient("wB", 0.0, 0.1, needs="wheel_change"),
)
GROWTH = Coefficient("gK", 0.0, 0.1), Coefficient("wK", 0.3, 0.2)
ROUGHNESS = Coefficient("gR", 0.0, 0.1)
ADAPTIVE = (
    *SHARPNESS,
    Coefficient("gS", 0.0, 0.1),
    Coefficient("wS", 0.1, 0.1),
)
#: coefficients of the rules that CMA-ES tunes
RULES: dict[str, tuple[Coefficient, ...]] = {
    "constant_per_kind": (
        Coefficient("E", 12_000.0, 0.4, positive=True, by_kind=True),
        Coefficient("D", 0.5, 0.5, by_kind=True, whole=True),
    ),
    "power_threshold": (
        Coefficient("E", 12_000.0, 0.2, positive=True),
        Coefficient("upper", 60.0, 0.2, positive=True),
        Coefficient("lower", 0.9, 0.1, positive=True, most=1.0),
        Coefficient("share", 0.8, 0.1, positive=True),
    ),
    "adaptive_speed": (
        *(each for each in ADAPTIVE if each.name.startswith(("E", "g"))),
        Coefficient("D", 1.0, 0.5, whole=True),
        Coefficient("every", 4.0, 0.5, positive=True, blocks=True),
    ),
    "adaptive_dress": (
        Coefficient("E", 12_000.0, 0.2, positive=True),
        *(each for each in ADAPTIVE if not each.name.startswith(("E", "g"))),
    ),
    "adaptive_rule": ADAPTIVE,
    "belief_rule": (*SHARPNESS, *GROWTH),
    "look_ahead": (
        Coefficient("price", 1.0, 0.3, positive=True, by_kind=True),
        Coefficient("growth", 1.5, 0.2, positive=True, by_kind=True),
        Coefficient("caution", 2.0, 0.3, positive=True),
        Coefficient("haste", 0.5, 0.5, positive=True, needs="due"),
        Coefficient("calm", 0.0, 0.1, needs="due"),
        Coefficient("layer", 0.01, 0.5, positive=True, needs="wheel_change"),
        Coefficient("scarcity", 0.5, 0.3, needs="wheel_change"),
    ),
    "dullness_rule": SHARPNESS,
    "growth_rule": (*SHARPNESS, *GROWTH),
    "roughness_rule": (*SHARPNESS, ROUGHNESS),
    "full_state_rule": (*SHARPNESS, *GROWTH, ROUGHNESS),
}


def vector_size(coefficients: tuple[Coefficient, ...], task: Task) -> int:
    """Return the number of entries of the search vector."""
    return sum(each.size(task) for each in coefficients)


def from_vector(coefficients: tuple[Coefficient, ...], task: Task, vector: Any) -> Parameters:
    """Return the parameters of a rule from a search vector, which has `size(task)` entries for each coefficient."""
    result: dict[str, Any] = {}
    position = 0
    for coefficient in coefficients:
        size = coefficient.size(task)
        values = [coefficient.value(z, task.action.executions) for z in vector[position : position + size]]
        position += size
        if values:
            result[coefficient.name] = values if coefficient.by_kind else values[0]
    return result


def rounded(value: Any) -> float:
    """Return the value rounded as in the file, to `DIGITS` significant digits."""
    return float(f"{value:.{DIGITS}g}")
