"""What a step reports besides observation and reward: the info of the single environment, and of many in arrays."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from grind_env.arrays import Array
from grind_env.envs.tables import Outcome, reward_terms
from grind_env.envs.tasks import Task
from grind_env.kernel import entry

RATIOS = ("burn_ratio", "power_ratio", "roughness_ratio")
"""Entries that say how near to its limit a block came, for agents that learn to keep limits: 1 is at the limit."""
READ = {"block_cost": "cost", "good_parts": "good", "seconds": "seconds", **{name: name for name in RATIOS}}
"""Entries that are fields of `Outcome`."""
FINISHED, GOOD = Outcome._fields.index("finished"), Outcome._fields.index("good")


class InfoWriter:
    """Writes the info of the steps of a task.

    Args:
        task: the task.
        names: of what an action chooses, E and D and perhaps the pre-dress.
    """

    def __init__(self, task: Task, names: tuple[str, ...]) -> None:
        self.terms = reward_terms(task)
        self.names = names
        self._read = {name: Outcome._fields.index(field) for name, field in READ.items()}
        self._columns = np.array([*self.terms.values(), *self._read.values()])
        self._reference = task.reference_cost

    def single(self, outcome: Outcome, chosen: Sequence[float]) -> dict[str, Any]:
        """The info of one environment, from its outcome and what was chosen."""
        return {
            "reward_terms": {name: 0.0 - outcome[column] / self._reference for name, column in self.terms.items()},
            "cost": outcome.finished - outcome.good,
            **{name: outcome[column] for name, column in self._read.items()},
            **dict(zip(self.names, chosen, strict=True)),
        }

    def vector(self, outcomes: Array, choice: tuple[Array, ...], mask: Array) -> dict[str, Any]:
        """The info of N environments, every entry with its mask; those that are not in `mask` have none.

        No two arrays share memory, and the arrays of `choice` go into the info.
        """
        rows, masks, shown = self._rows(outcomes, mask, 2 + len(self.terms) + len(READ) + len(self.names))
        if shown < len(mask):
            choice = tuple(np.where(mask, values, 0.0) for values in choice)
        flags, values_of = iter(masks), list(rows)
        terms: dict[str, Any] = {}
        for name, values in zip(self.terms, values_of[1:], strict=False):
            terms[name], terms[f"_{name}"] = values, next(flags)
        info: dict[str, Any] = {"reward_terms": terms, "_reward_terms": next(flags)}
        info["cost"], info["_cost"] = values_of[0], next(flags)
        for name, values in zip((*READ, *self.names), (*values_of[1 + len(self.terms) :], *choice), strict=True):
            info[name], info[f"_{name}"] = values, next(flags)
        return info

    def _rows(self, outcomes: Array, mask: Array, masks: int) -> tuple[Array, Array, int]:
        rows = np.empty((1 + len(self._columns), len(mask)))
        flags = np.empty((masks, len(mask)), bool)
        shown = _fill(outcomes, mask, self._columns, len(self.terms), self._reference, rows, flags)
        return rows, flags, shown


@entry
def _fill(outcomes: Any, mask: Any, columns: Any, terms: int, reference: float, rows: Any, flags: Any) -> int:
    """Write the chance of scrap, then one row a column of the outcomes, those of the reward first; and the masks.

    Row by row, so that every loop runs in vector registers. Returns the number of environments that are shown.
    """
    n, shown = mask.size, 0
    for i in range(n):
        rows[0, i] = outcomes[i, FINISHED] - outcomes[i, GOOD] if mask[i] else 0.0
        shown += mask[i]
    for k in range(columns.size):
        column = columns[k]
        if k < terms:
            for i in range(n):
                rows[k + 1, i] = 0.0 - outcomes[i, column] / reference if mask[i] else 0.0
        else:
            for i in range(n):
                rows[k + 1, i] = outcomes[i, column] if mask[i] else 0.0
    for k in range(flags.shape[0]):
        for i in range(n):
            flags[k, i] = mask[i]
    return shown
