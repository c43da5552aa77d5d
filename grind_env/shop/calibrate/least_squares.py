"""Least squares of measurement residuals, with their derivatives."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats
from grind_env.errors import GrindError
from grind_env.shop.calibrate.fitted_constants import Parameter

OUTLIER = 5.0  #: residual above which a measurement is left out, in standard deviations
MOST_OUTLIERS = 0.1  #: greatest share of the measurements of a kind that may be left out
#: step of derivatives, in prior spreads; the long one is for a model with jumps, over which it averages
STEP, LONG_STEP = 0.03, 0.5
#: part of the loose error of power that all strokes share, as a share of the root mean square of their power
LOOSE = 0.01
HOPELESS = 1e3  #: residual if the process model gives no number for some constants
#: distance from the point of the derivatives, in prior spreads, up to which a solution needs no new derivatives
NEAR = 0.25
#: greatest move of a constant in one step, in prior spreads; greatest number of steps of a solution, and of times that
#: its derivatives are taken anew
LONGEST_STEP, MOST_STEPS, MOST_SLOPES = 2.0, 40, 4
#: least decrease of half the sum of squares that a further step must promise: relative, relative in a rough solution,
#: absolute
LITTLE, LITTLE_ROUGHLY, LEAST_LITTLE = 1e-4, 1e-2, 2e-3
STEPS_WITHOUT = 2  #: number of steps of a fit without some parts
FARTHEST = 2.0  #: greatest distance of a nuisance from its prior, in prior spreads
TINY = 1e-6  #: relative step of the predictions in the derivatives of the residuals

Changes: TypeAlias = Mapping[str, Mapping[str, float]]  #: changed values of constants, by kind of entry and by field
Predict: TypeAlias = Callable[[Changes], Floats]  #: function from changed constants to predicted measurements

#: kinds of measurement with additive errors and a meter scale; kinds not here or in `ABSOLUTE` have relative errors
LINEAR = ("power",)
ABSOLUTE = ("size", "diameter")  #: kinds of measurement with additive errors and without a meter scale
GAUGED = (*ABSOLUTE, "Ra")  #: kinds of measurement of single parts
YES_OR_NO = "burn"  #: kind of measurement with the values 1 and 0; its prediction is the logit of the probability


@dataclass(frozen=True, slots=True)
class Data:
    """Measurements; each array has a value for each measurement."""

    value: Floats  #: measured value
    # standard error, in the unit of the value for kinds with additive errors, else relative; for yes or no the share of
    # yes that passes for no
    error: Floats
    kind: NDArray[np.str_]  #: kind of measurement, such as power or Ra
    part: NDArray[np.int64]  #: number of its part, from 1, or of its setting in a table

    @property
    def kinds(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(self.kind.tolist()))

    @property
    def loose_error(self) -> Floats:
        """Standard errors with an allowance for errors of the model, with which weak strokes count little."""
        power = self.kind == "power"
        usual = np.sqrt(np.mean(np.square(self.value[power]))) if power.any() else 0.0
        return np.where(power, np.hypot(self.error, LOOSE * usual), self.error)


def bounded(x: Floats) -> Floats:
    """Return nuisances limited to `FARTHEST` spreads, so that a known meter is not changed to fit a model."""
    return np.asarray(FARTHEST * np.tanh(x / FARTHEST))


def changes_of(parameters: Sequence[Parameter], z: Floats) -> Changes:
    """Return the values of parameters by kind and key."""
    changes: dict[str, dict[str, float]] = {}
    for each, place in zip(parameters, z.tolist(), strict=True):
        changes.setdefault(each.kind, {})[each.key] = each.value(place)
    return changes


class Solver:
    """Residuals and derivatives; variables are parameters, then nuisances, in spreads of the prior.

    A nuisance is a factor on measurements that is no constant of a catalogue, given as the change of the logarithm of
    each measurement per spread of the prior. `jumps` marks predictions that jump with constants, as under a wheel that
    crosses; a solver `like` this one has the same data and shares its predictions.
    """

    def __init__(
        self,
        parameters: tuple[Parameter, ...],
        nuisances: Sequence[Floats],
        data: Data,
        predict: Predict,
        *,
        jumps: bool = False,
        like: "Solver | None" = None,
    ) -> None:
        self.parameters, self.data, self._predict = parameters, data, predict
        self._step = LONG_STEP if jumps else STEP
        self.size = len(parameters) + len(nuisances)
        self._of_kind = {kind: data.kind == kind for kind in data.kinds}
        self._effects = np.array(nuisances).reshape(len(nuisances), data.value.size)
        # predictions by the names and values of the constants that differ from the catalogue
        self._known: dict[tuple[tuple[str, float], ...], Floats] = {} if like is None else like._known
        self._at: Floats | None = None
        self._slopes: Floats | None = None

    def predicted(self, x: Floats) -> Floats:
        """Return the predicted measurements, in the shape of the values."""
        count = len(self.parameters)
        changes = changes_of(self.parameters, x[:count])
        values = ((each, changes[each.kind][each.key]) for each in self.parameters)
        key = tuple((each.name, value) for each, value in values if value != each.prior)
        if key not in self._known:
            try:
                self._known[key] = np.array(self._predict(changes), np.float64)
            except GrindError:
                self._known[key] = np.full(self.data.value.size, np.nan)
        return np.asarray(self._known[key] * np.exp(bounded(x[count:]) @ self._effects))

    def residuals(self, predicted: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> Floats:
        """Return the residuals of the used measurements, in errors."""
        data, result = self.data, np.zeros(self.data.value.size)
        for kind, chosen in self._of_kind.items():
            value, error, guess = data.value[chosen], data.error[chosen] * factors[kind], predicted[chosen]
            if kind == YES_OR_NO:
                with np.errstate(divide="ignore"):
                    missed = np.where(value > 0.5, 0.0, np.logaddexp(0.0, guess + np.log(data.error[chosen])))
                unlikely = np.logaddexp(0.0, np.where(value > 0.5, -guess, guess)) - missed
                result[chosen] = np.sqrt(2.0 * np.maximum(unlikely, 0.0))
            elif kind in LINEAR or kind in ABSOLUTE:
                result[chosen] = (value - guess) / error
            else:
                with np.errstate(divide="ignore", invalid="ignore"):
                    result[chosen] = np.log(value / guess) / error
        return np.nan_to_num(result[used], nan=HOPELESS, posinf=HOPELESS, neginf=-HOPELESS)

    def solve(
        self,
        x: Floats,
        used: NDArray[np.bool_],
        factors: Mapping[str, float],
        free: NDArray[np.bool_],
        *,
        roughly: bool = False,
    ) -> Floats:
        """Return the most probable variables; those that are not `free` stay unchanged.

        Gauss-Newton steps with damping. Every run of the machine corrects the derivatives (Broyden). They are taken
        anew where the solution is far from their point, unless it may be found `roughly`.
        """
        if not free.any():
            return x
        here, damping, left = self.predicted(x), 0.0, MOST_SLOPES
        for _ in range(MOST_STEPS):
            rest, rows = self.residuals(here, used, factors), self.slopes(x, used, factors)[:, free]
            gradient, curvature = rows.T @ rest + x[free], rows.T @ rows + np.eye(rows.shape[1])
            step = np.linalg.solve(curvature + damping * np.diag(np.diag(curvature)), -gradient)
            step *= min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-300))
            cost = _cost(rest, x[free])
            promised = -float(gradient @ step) - 0.5 * float(step @ curvature @ step)
            if promised < max((LITTLE_ROUGHLY if roughly else LITTLE) * cost, LEAST_LITTLE):
                if roughly or left == 0 or (self._at is not None and np.abs(x - self._at).max() <= NEAR):
                    break
                self._take_slopes(x)
                left -= 1
                continue
            moved = x.copy()
            moved[free] += step
            there = self.predicted(moved)
            if _cost(self.residuals(there, used, factors), moved[free]) < cost:
                self._correct(x, moved, here, there)
                x, here, damping = moved, there, 0.25 * damping
            elif left and not self._is_at(x):
                self._take_slopes(x)
                left -= 1
            elif damping > 1e6:
                break
            else:
                damping = max(10.0 * damping, 0.1)
        return x

    def _take_slopes(self, x: Floats) -> None:
        """Take the derivatives of the predictions at `x`, shape (measurements, variables)."""
        both_sides, columns = self._step == LONG_STEP, []
        for move in self._step * np.eye(self.size):
            begin = x - move if both_sides else x
            columns.append((self.predicted(x + move) - self.predicted(begin)) / (self._step * (1.0 + both_sides)))
        self._at, self._slopes = x.copy(), np.nan_to_num(np.column_stack(columns))

    def begin_with(self, other: "Solver", ratio: Floats) -> None:
        """Take over the derivatives of another solver, whose variables are `ratio` times those of this one."""
        if other._slopes is not None and other._at is not None:
            self._at, self._slopes = other._at / ratio, other._slopes * ratio

    def _correct(self, x: Floats, moved: Floats, here: Floats, there: Floats) -> None:
        """Correct the derivatives by the change of the predictions in a step (Broyden, Math. Comp. 19 (1965) 577)."""
        assert self._slopes is not None
        step = moved - x
        missed = np.nan_to_num(there - here - self._slopes @ step)
        self._slopes = self._slopes + np.outer(missed, step) / float(step @ step)

    def _is_at(self, x: Floats) -> bool:
        return self._at is not None and np.array_equal(x, self._at)

    def slopes(self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> Floats:
        """Return derivatives of the residuals, shape (used, variables), from nearby predictions."""
        if self._slopes is None:
            self._take_slopes(x)
        assert self._slopes is not None
        predicted = self.predicted(x)
        push = TINY * np.maximum(np.abs(np.nan_to_num(predicted)), 1e-3)
        above, below = (self.residuals(predicted + each, used, factors) for each in (push, -push))
        return ((above - below) / (2.0 * push[used]))[:, None] * self._slopes[used]

    def covariance(self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> Floats:
        """Return the covariance of all variables around the most probable ones, shape (variables, variables)."""
        if not self._is_at(x):
            self._take_slopes(x)
        slopes = self.slopes(x, used, factors)
        return np.asarray(np.linalg.inv(slopes.T @ slopes + np.eye(self.size)), np.float64)

    def without(
        self,
        x: Floats,
        rows: NDArray[np.bool_],
        used: NDArray[np.bool_],
        factors: Mapping[str, float],
        free: NDArray[np.bool_],
    ) -> Floats:
        """Return the predictions of some `rows` by a fit to all other measurements; it starts from a fit `x` to all."""
        others = used & ~rows
        for _ in range(STEPS_WITHOUT):
            rest, slopes = self.residuals(self.predicted(x), others, factors), self.slopes(x, others, factors)[:, free]
            gradient, curvature = slopes.T @ rest + x[free], slopes.T @ slopes + np.eye(slopes.shape[1])
            x = x.copy()
            x[free] -= np.clip(np.linalg.solve(curvature, gradient), -LONGEST_STEP, LONGEST_STEP)
        return self.predicted(x)[rows]

    def without_outliers(self, x: Floats, used: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which measurements are near their predictions, by their errors or a larger scatter of residuals."""
        everything = self.residuals(self.predicted(x), np.ones(used.size, np.bool_), dict.fromkeys(self._of_kind, 1.0))
        kept = used.copy()
        for kind, chosen in self._of_kind.items():
            mine = np.flatnonzero(chosen & used)
            if kind == YES_OR_NO or mine.size < 8:
                continue
            scatter = max(1.4826 * float(np.median(np.abs(everything[mine]))), 1.0)
            worst = mine[np.argsort(-np.abs(everything[mine]))][: int(MOST_OUTLIERS * mine.size)]
            kept[worst[np.abs(everything[worst]) > OUTLIER * scatter]] = False
        return kept

    def enlarged(
        self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float], *, gauged: bool
    ) -> dict[str, float]:
        """Return factors on the errors that make the residuals of every kind consistent; never below 1.

        If `gauged` is False, kinds of single parts keep their errors, so that power values do not overrule them.
        """
        predicted, plain = self.predicted(x), dict.fromkeys(factors, 1.0)
        everything = self.residuals(predicted, np.ones(used.size, np.bool_), plain)
        taken = self._effective(x, used, factors)
        result = {}
        for kind, chosen in self._of_kind.items():
            mine = chosen & used
            freedom = mine.sum() - taken * mine.sum() / used.sum()
            enough = kind != YES_OR_NO and mine.sum() >= 4 and freedom >= 1.0 and (gauged or kind not in GAUGED)
            result[kind] = max(1.0, float(np.sqrt(np.square(everything[mine]).sum() / freedom))) if enough else 1.0
        return result

    def _effective(self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> float:
        """Return the effective number of variables that the measurements determine."""
        slopes = self.slopes(x, used, factors)
        information = slopes.T @ slopes
        return float(np.trace(np.linalg.solve(information + np.eye(self.size), information)))


def _cost(rest: Floats, x: Floats) -> float:
    return 0.5 * float(rest @ rest + x @ x)
