"""The `info` of a step, for the single environment and, in arrays, for the vector environment.

All entries but the text `block` of `show_block=True` are numbers. `reward_time` and the other `reward_` entries add up
to the reward. By default the entries are what a shop knows: readings of gauges and meter, costs, and whether a part was
found good. With `info="full"`, probabilities replace the verdicts on parts, and true ratios replace the readings.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.arguments import is_full
from grind_env.envs.cost import Outcome, reward_terms
from grind_env.envs.simulation import Simulation
from grind_env.kernel import entry, inlined
from grind_env.kernel.dispatch import as_written
from grind_env.process.cost import SCRAP_BELOW

#: entries that are readings in their units, as far as the environment shows them
READINGS = ("power", "mean_power", "first_power", "peak_power", "size_error", "diameter")
#: entries with the ratio of a reading to its limit, each with its reading, for agents that learn to keep limits. The
#: roughness is that of the last gauged part
READ = {"power_ratio": "peak_power", "roughness_ratio": "roughness"}
RATIOS = ("burn_ratio", *READ)  #: entries with true ratios; no gauge shows the burn ratio
#: entries that are fields of `Outcome`; with `info="measured"`, good parts are counted instead
CAME = {"block_cost": "cost", "good_parts": "good", "seconds": "seconds"}
FINISHED, GOOD = Outcome._fields.index("finished"), Outcome._fields.index("good")


@inlined
def found_bad(finished: float, good: float) -> float:
    """Return the number of parts that a step has finished and that are found bad: more likely scrap than not."""
    return float(math.ceil(finished - good - (1.0 - SCRAP_BELOW)))


_found_bad = as_written(found_bad)  # a call of `Inlined` from Python takes a tenth of a step


class InfoWriter:
    """Writer of the info of the steps of a simulation.

    Args:
        simulation: the simulation.
        names: names of the choices: E, D and perhaps the pre-dress.
        info: `"measured"` or `"full"`.

    Raises:
        TaskError: `info` is neither.
    """

    def __init__(self, simulation: Simulation, names: tuple[str, ...], info: str = "measured") -> None:
        task, self.full = simulation.task, is_full(info, "info")
        self._terms = {f"reward_{name}": column for name, column in reward_terms(task).items()}
        self.names = names
        came = CAME | ({name: name for name in RATIOS} if self.full else {})
        self._came = {name: Outcome._fields.index(field) for name, field in came.items()}
        self._columns = np.array([*self._terms.values(), *self._came.values()])
        self._reference = task.reference_cost
        entries = {entry.name: (k, entry.offset, entry.scale) for k, entry in enumerate(simulation.entries)}
        self._read = {name: entries[name] for name in READINGS if name in entries}
        if not self.full:  # observations show these over their limits
            self._read |= {name: (entries[read][0], 0.0, 1.0) for name, read in READ.items() if read in entries}
        self._entries = np.array([k for k, _, _ in self._read.values()], np.int64)
        self._scales = np.array([scaling for _, *scaling in self._read.values()]).reshape(-1, 2)

    def single(self, outcome: Outcome, observation: NDArray[np.float32], chosen: Sequence[float]) -> dict[str, Any]:
        """Return the info of one environment: from its outcome, the observation after it, and what was chosen."""
        finished, good, shown = outcome.finished, outcome.good, observation.tolist()
        bad = finished - good if self.full else _found_bad(finished, good)
        info = {
            **{name: 0.0 - outcome[column] / self._reference for name, column in self._terms.items()},
            "cost": bad,
            **{name: outcome[column] for name, column in self._came.items()},
            **{name: offset + scale * shown[k] for name, (k, offset, scale) in self._read.items()},
            **dict(zip(self.names, chosen, strict=True)),
        }
        if not self.full:
            info["good_parts"] = finished - bad
        return info

    def vector(
        self, outcomes: Array, observations: NDArray[np.float32], choice: tuple[Array, ...], mask: Array
    ) -> dict[str, Any]:
        """Return the info of N environments, every entry with its mask; environments outside `mask` have no entries.

        No two arrays share memory, and the arrays of `choice` go into the info.
        """
        named = (*self._terms, "cost", *self._came, *self._read, *self.names)
        masks = np.empty((len(named), len(mask)), bool)
        rows = np.empty((len(named) - len(self.names), len(mask)))
        columns, entries = (self._columns, len(self._terms), self._reference), (self._entries, self._scales)
        if _fill(outcomes, observations, mask, *columns, *entries, self.full, rows, masks) < len(mask):
            choice = tuple(np.where(mask, values, 0.0) for values in choice)
        info: dict[str, Any] = {}
        for name, values, flags in zip(named, (*rows, *choice), masks, strict=True):
            info[name], info[f"_{name}"] = values, flags
        return info


@entry
def _fill(
    outcomes: Any,
    observations: Any,
    mask: Any,
    columns: Any,
    terms: int,
    reference: float,
    entries: Any,
    scales: Any,
    full: bool,
    rows: Any,
    flags: Any,
) -> int:
    """Write terms of the reward, bad parts, further results, readings and masks; return the number in `mask`.

    The function writes row by row, so that every loop runs in vector registers.
    """
    n, shown = mask.size, 0
    for k in range(terms):
        column = columns[k]
        for i in range(n):
            rows[k, i] = 0.0 - outcomes[i, column] / reference if mask[i] else 0.0
    for i in range(n):
        finished, good = outcomes[i, FINISHED], outcomes[i, GOOD]
        bad = finished - good if full else found_bad(finished, good)
        rows[terms, i] = bad if mask[i] else 0.0
        shown += mask[i]
    for k in range(terms, columns.size):
        column = columns[k]
        for i in range(n):
            value = outcomes[i, FINISHED] - rows[terms, i] if column == GOOD and not full else outcomes[i, column]
            rows[k + 1, i] = value if mask[i] else 0.0
    for k in range(entries.size):
        column, offset, scale = entries[k], scales[k, 0], scales[k, 1]
        for i in range(n):
            value = offset + scale * np.float64(observations[i, column])
            rows[columns.size + 1 + k, i] = value if mask[i] else 0.0
    for k in range(flags.shape[0]):
        for i in range(n):
            flags[k, i] = mask[i]
    return shown
