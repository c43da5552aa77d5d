"""Actions to E, D and the pre-dress, and back.

An action has one of four forms (`action=...` of the environments):

* `box`: `Box(-1, 1)`. The first component chooses E on a geometric scale over the speed range, rounded to whole mm/min
  as in a part program, or in equal bins over the speed levels of the task. The second component chooses D: 0 up to 1/3,
  above 1/3 in bins of equal width from 1 to the largest D. So an untrained Gaussian policy dresses in the minority of
  its blocks.
* `multidiscrete`: the index of a level of E, and D. The levels are those of the task, or `SPEED_LEVELS` that divide
  its range geometrically, both ends included.
* `discrete`: the numbers of `multidiscrete` as one number, in which the last component changes fastest.
* `dict`: E in mm/min, rounded to a whole number (or to the nearest level), and D as a number.

With a pre-dress a third component, factor or key says whether the block begins with a dress (G82.1).

A number beyond a bound is clipped or refused (`out_of_range`); within `ROUNDING` of the bound it is always clipped.
NaN, infinity and fractions of whole numbers are always refused.
"""

import math
import warnings
from collections.abc import Mapping
from numbers import Real
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from grind_env.array_types import Table
from grind_env.envs.tasks import Task
from grind_env.errors import GrindError, GrindWarning
from grind_env.kernel import entry, exp, log
from grind_env.message_text import listed, quoted

ACTIONS = ("box", "multidiscrete", "discrete", "dict")  #: forms of the action
SPEED_LEVELS = 24  #: levels of E of a discrete action, about 10 % apart where the range spans a decade
KEYS = ("E", "D", "predress")  #: keys of an action of the form `dict`, and names of the columns of a decoded action

NO_DRESS = float(np.float32(1.0 / 3.0))  #: highest component of a `box` that chooses D = 0: 1/3 in single precision

OUT_OF_RANGE = ("clip", "raise")  #: ways to treat a number beyond a bound of the action space
#: relative rounding error, in single precision, of wrappers that rescale actions
ROUNDING = 8.0 * float(np.finfo(np.float32).eps)

#: rule for a component of a `box`, for messages
IN_BOX = 'lie between -1 and 1: clip the action, or make the environment with out_of_range="clip"'

#: the remedy for actions in physical units
SCALED = ' E and D of a box are scaled to -1..1: action="dict" takes E in mm/min and D as a number'

LONGEST = 200  #: most characters of an action that a message repeats


class ActionError(GrindError):
    """An action that is not in the action space."""


class ActionColumn(NamedTuple):
    """One number of an action.

    `low` and `high` are in mm/min for the E of a `dict`; all others have no unit.
    """

    name: str
    low: float
    high: float
    whole: bool  #: whether it must be a whole number
    legal: str  #: rule that the number must meet, for messages


class ActionCodec:
    """Action space of a task, and conversion between an action and (E, D), or (E, D, pre-dress).

    Args:
        task: the task.
        action: form of the action, one of `ACTIONS`.
        predress: whether an action can ask for a dress before the first plunge.
        out_of_range: what happens to a number beyond a bound, one of `OUT_OF_RANGE`; None clips a `box` and refuses
            the other forms.

    Raises:
        ActionError: if there is no such form or treatment.
    """

    def __init__(
        self, task: Task, action: str = "box", *, predress: bool = False, out_of_range: str | None = "raise"
    ) -> None:
        if not isinstance(action, str) or action not in ACTIONS:
            raise ActionError(f"action is {action!r}, but must be one of {', '.join(ACTIONS)}")
        if out_of_range is not None and out_of_range not in OUT_OF_RANGE:
            raise ActionError(f"out_of_range is {out_of_range!r}, but must be one of {', '.join(OUT_OF_RANGE)}")
        self.clips = out_of_range == "clip" or (out_of_range is None and action == "box")
        self._warns = self.clips
        self.low, self.high = task.action.speed_ends
        self.task, self.action = task, action
        self.executions = task.action.executions
        self.names = KEYS if predress else KEYS[:2]
        self.levels = np.array(task.action.speed_levels or (), np.float64)
        if self.levels.size == 0 and action in ("multidiscrete", "discrete"):
            self.levels = np.floor(np.geomspace(self.low, self.high, SPEED_LEVELS) + 0.5)
        self.sizes = (len(self.levels), self.executions + 1, 2)[: len(self.names)]
        self.space = self._space()
        self.columns = self._columns()
        self._low = np.array([column.low for column in self.columns])
        self._high = np.array([column.high for column in self.columns])
        self._whole = np.array([column.whole for column in self.columns])
        self._shape = () if action == "discrete" else (len(self.columns),)
        self._said = " and ".join(column.name for column in self.columns)
        self.neutral = np.clip(0.0, self._low, self._high)
        """A legal row of `table`."""

    def _space(self) -> spaces.Space[Any]:
        if self.action == "box":
            return spaces.Box(-1.0, 1.0, (len(self.names),), np.float32)
        if self.action == "multidiscrete":
            return spaces.MultiDiscrete(np.array(self.sizes))
        if self.action == "discrete":
            return spaces.Discrete(int(np.prod(self.sizes)))
        numbers = {"D": self.executions + 1, "predress": 2}
        choices = {name: spaces.Discrete(numbers[name]) for name in self.names[1:]}
        return spaces.Dict({"E": spaces.Box(self.low, self.high, (1,), np.float32), **choices})

    def _columns(self) -> list[ActionColumn]:
        if self.action == "box":
            return [ActionColumn(name, -1.0, 1.0, False, IN_BOX) for name in self.names]
        if self.action == "discrete":
            return [_whole(" and ".join(self.names), int(np.prod(self.sizes)))]
        columns = [_whole(name, size) for name, size in zip(self.names, self.sizes, strict=True)]
        if self.action == "dict":
            legal = f"lie between {self.low:g} and {self.high:g} mm/min"
            columns[0] = ActionColumn("E", self.low, self.high, False, legal)
        return columns

    def table(self, actions: Any, count: int | None = None) -> Table:
        """Return a batch of actions as numbers, shape (N, columns); `count` is the required N, None for any.

        Raises:
            ActionError: if they are not numbers or have another shape.
        """
        if self.action == "dict":
            values = self._dict_table(actions)
        else:
            values = _numbers(actions)
            if self.action == "discrete" and values.ndim == 1:
                values = values[:, None]
        width = len(self.columns)
        if values.ndim != 2 or values.shape != (count or len(values), width):
            shape = np.shape(_numbers(actions)) if self.action != "dict" else values.shape
            wanted = f"({count or 'N'},)" if self.action == "discrete" else f"({count or 'N'}, {width})"
            raise ActionError(f"actions have shape {shape}, but must have shape {wanted}: {self._said} of each env")
        return values

    def _dict_table(self, actions: Any) -> Table:
        if not isinstance(actions, Mapping) or set(actions) != set(self.names):
            found = f"the keys {listed([*map(str, actions)])}" if isinstance(actions, Mapping) else quoted(actions)
            raise ActionError(f"actions are {found}, but must be a dict with the keys {', '.join(self.names)}")
        columns = [_numbers(actions[name]) for name in self.names]
        if columns[0].ndim == 2 and columns[0].shape[1] == 1:
            columns[0] = columns[0][:, 0]
        if any(column.ndim != 1 or column.shape != columns[0].shape for column in columns):
            shapes = ", ".join(f"{name} {column.shape}" for name, column in zip(self.names, columns, strict=True))
            raise ActionError(f"actions have the shapes {shapes}, but each must have one number of each env")
        return np.stack(columns, axis=1)

    def single(self, action: Any) -> Table:
        """Return one action as a batch of one, shape (1, columns).

        Raises:
            ActionError: if the action is no numbers or has another shape.
        """
        if isinstance(action, Mapping):
            return self.table({name: [value] for name, value in action.items()}, 1)
        if self.action == "dict":
            return self.table([action], 1)
        values = _numbers(action)
        if values.shape != self._shape and (values.shape != (1,) or self.action != "discrete"):
            said = f"the action has shape {values.shape}, but must have shape {self._shape}: {self._said}"
            raise ActionError(said)
        return values.reshape(1, len(self.columns))

    def choose(self, values: Table) -> tuple[Table, ...]:
        """Return E in mm/min, D and, if actions have it, 1 for a pre-dress; each shape (N,), from a `table`.

        Raises:
            ActionError: if a number is not in the action space.
        """
        choice = np.empty((len(self.names), len(values)))
        if self.action == "box":
            bad = _decode(values, self.levels, self.low, self.high, float(self.executions), choice)
        else:
            bad = _first_bad(values, self._low, self._high, self._whole)
        if bad >= 0:
            return self.choose(self._clipped(values, bad))
        if self.action == "discrete":
            return self._of_numbers(np.stack(np.unravel_index(values[:, 0].astype(np.int64), self.sizes), axis=1))
        if self.action == "multidiscrete":
            return self._of_numbers(values.astype(np.int64))
        if self.action == "dict":
            return (self._nearest(values[:, 0]), *np.ascontiguousarray(values[:, 1:].T))
        return tuple(choice)

    def _clipped(self, values: Table, bad: int) -> Table:
        clipped = np.clip(values, self._low, self._high)
        beyond = np.abs(values - clipped)
        far = beyond > ROUNDING * np.maximum(np.abs(clipped), 1.0)
        refused = ~np.isfinite(values) | (self._whole & (np.floor(clipped) != clipped))
        if not self.clips:
            refused |= far
        if refused.any():
            bad = int(refused.argmax())
        i, k = divmod(bad, len(self.columns))
        column, value = self.columns[k], float(values[i, k])
        if refused.any():
            must = f"but must {column.legal}"
            if not math.isfinite(value):
                must = "which is no number: mend what chose it, such as a network whose training has diverged"
            raise ActionError(f"action {i} has {plain(value)} for {column.name}, {must}")
        if self._warns and far.any():
            self._warns = False
            i, k = divmod(int(far.argmax()), len(self.columns))
            said = f"action {i} has {plain(values[i, k])} for {self.columns[k].name}, clipped to {plain(clipped[i, k])}"
            said += f", as later ones are.{SCALED if self.action == 'box' else ''}"
            warnings.warn(said, GrindWarning, stacklevel=2)
        return clipped

    def decode(self, actions: Any) -> tuple[Table, ...]:
        """Return E in mm/min, D and, if actions have it, 1 for a pre-dress; each shape (N,), from a batch of actions.

        Raises:
            ActionError: if they are not in the action space.
        """
        return self.choose(self.table(actions))

    def _of_numbers(self, numbers: NDArray[np.int64]) -> tuple[Table, ...]:
        return (self.levels[numbers[:, 0]], *np.ascontiguousarray(numbers[:, 1:].T.astype(np.float64)))

    def _nearest(self, speeds: Table) -> Table:
        if self.levels.size == 0:
            return np.floor(speeds + 0.5)
        return np.asarray(self.levels[np.abs(np.log(speeds[:, None] / self.levels)).argmin(axis=1)])

    def encode(self, speeds: ArrayLike, executions: ArrayLike, pre_dresses: ArrayLike = 0.0) -> Any:
        """Return a batch of actions for E in mm/min, D and the pre-dress, each shape (N,): the middle of each bin.

        Raises:
            ActionError: if one of them cannot be chosen in this task.
        """
        E, D = np.atleast_1d(_numbers(speeds)), np.atleast_1d(_numbers(executions))
        dress = np.broadcast_to(_numbers(pre_dresses), D.shape)
        most = 1 if "predress" in self.names else 0
        for name, values, high in (("D", D, self.executions), ("predress", dress, most)):
            good = np.isin(values, np.arange(high + 1))
            if not good.all():
                raise ActionError(f"{name} is {plain(values[~good][0])}, but must be a whole number from 0 to {high}")
        numbers = (self._level_of(E), D.astype(np.int64), dress.astype(np.int64))[: len(self.names)]
        if self.action == "multidiscrete":
            return np.stack(numbers, axis=1)
        if self.action == "discrete":
            return np.ravel_multi_index(numbers, self.sizes)
        if self.action == "dict":
            nearest = np.clip(np.floor(E + 0.5), self.low, self.high)[:, None].astype(np.float32)
            return {"E": nearest, **dict(zip(self.names[1:], numbers[1:], strict=True))}
        if self.levels.size > 0:
            u0 = 2.0 * (numbers[0] + 0.5) / len(self.levels) - 1.0
        else:
            u0 = 2.0 * np.log(E / self.low) / np.log(self.high / self.low) - 1.0
        bins = [_middle_of(D, self.executions), dress - 0.5][: len(self.names) - 1]
        return np.clip(np.stack([u0, *bins], axis=1), -1.0, 1.0).astype(np.float32)

    def _level_of(self, speeds: Table) -> NDArray[np.int64]:
        """Return the index of the level of each E; 0 if every E of the range can be chosen."""
        if self.levels.size > 0:
            distance = np.abs(speeds[:, None] - self.levels)
            good = distance.min(axis=1) <= 0.5
            if not good.all():
                levels = ", ".join(f"{level:g}" for level in self.levels)
                raise ActionError(f"E is {plain(speeds[~good][0])} mm/min, but must be one of {levels} mm/min")
            return np.asarray(distance.argmin(axis=1))
        good = (self.low - 0.5 <= speeds) & (self.high + 0.5 >= speeds)
        if not good.all():
            legal = f"from {self.low:g} to {self.high:g} mm/min"
            raise ActionError(f"E is {plain(speeds[~good][0])} mm/min, but must be {legal}")
        return np.zeros(len(speeds), np.int64)


def _whole(name: str, size: int) -> ActionColumn:
    return ActionColumn(name, 0.0, size - 1.0, True, f"be a whole number from 0 to {size - 1}")


def plain(value: float) -> str:
    """Return a number with all digits that tell it from its neighbours, and no more."""
    return repr(float(value)).removesuffix(".0")


def _numbers(values: Any) -> Table:
    """Return actions as an array of numbers; None counts as NaN.

    Raises:
        ActionError: if they make no array, or some are no real numbers, such as texts or durations.
    """
    try:
        array = np.asarray(values)
        if array.dtype.kind in "biuf":
            return np.asarray(array, np.float64)
        if array.dtype.kind == "O" and all(each is None or isinstance(each, Real) for each in array.flat):
            return np.asarray(array, np.float64)
    except (TypeError, ValueError, OverflowError):
        pass
    said = " ".join(repr(values).split())
    said = said if len(said) <= LONGEST else f"{said[:LONGEST]}..."
    raise ActionError(f"actions are {said}, but must be an array of numbers, E and D of each env")


@entry
def _first_bad(values: Any, low: Any, high: Any, whole: Any) -> int:
    """Return the position of the first illegal number, counted row by row; -1 for none."""
    for i in range(values.shape[0]):
        for k in range(values.shape[1]):
            value = values[i, k]
            # false for NaN, too
            if not (low[k] <= value <= high[k]) or (whole[k] and np.floor(value) != value):
                return int(i * values.shape[1] + k)
    return -1


def _middle_of(D: Table, most: int) -> Table:
    """Return the middle of the bin of each D for a component of a `box`, shape (N,)."""
    above = NO_DRESS + (D - 0.5) / max(most, 1) * (1.0 - NO_DRESS)
    return np.where(D > 0.0, above, 0.5 * (NO_DRESS - 1.0))


@entry
def _decode(actions: Any, levels: Any, low: float, high: float, most: float, choice: Any) -> int:
    """Write the choices of `box` actions; return the position of an illegal number as `_first_bad` does."""
    width = actions.shape[1]
    for i in range(actions.shape[0]):
        for k in range(width):
            # false for NaN, too
            if not -1.0 <= actions[i, k] <= 1.0:
                return int(i * width + k)
        u = 0.5 * (actions[i, 0] + 1.0)
        if levels.size > 0:
            choice[0, i] = levels[min(int(u * levels.size), levels.size - 1)]
        else:
            choice[0, i] = np.floor(low * exp(u * log(high / low)) + 0.5)
        a = actions[i, 1]
        choice[1, i] = min(np.ceil((a - NO_DRESS) / (1.0 - NO_DRESS) * most), most) if a > NO_DRESS else 0.0
        if choice.shape[0] > 2:
            choice[2, i] = 1.0 if actions[i, 2] > 0.0 else 0.0
    return -1
