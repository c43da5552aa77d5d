"""Residuals of measurements, their derivatives, and the variables for which they are least."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from grind_env.errors import GrindError
from grind_env.extras import needing
from grind_env.shop.calibrate.parameters import Parameter
from grind_env.shop.calibrate.sheet import Floats

with needing("shop", "a calibration needs"):
    from scipy import optimize

OUTLIER = 5.0
"""Errors from which on a measurement is left out."""
MOST_OUTLIERS = 0.1
"""Share of the measurements of a kind that may be left out."""
STEP, LONG_STEP = 0.03, 0.5
"""Of derivatives, in spreads of the prior; of a model with jumps, over which the long one takes the mean."""
LOOSE = 0.01
"""Of the root mean square of the power of all strokes."""
HOPELESS = 1e3
"""Residual of constants with which the process model has no numbers."""

Changes: TypeAlias = Mapping[str, Mapping[str, float]]
"""Values by kind of entry and field."""
Changed: TypeAlias = tuple[tuple[str, float], ...]
"""Names and values of constants that are not as in the catalogue."""
Predict: TypeAlias = Callable[[Changes], Floats]
"""What would be measured with other constants."""

LINEAR = ("power",)
"""Kinds of measurement with additive errors, beside which those of the others are relative."""
ABSOLUTE = ("size", "diameter")
"""Those whose level the scale of no meter multiplies."""
YES_OR_NO = "burn"
"""A measurement of 1 or 0, whose prediction is the logit of its probability."""


@dataclass(frozen=True, slots=True)
class Data:
    """Measurements; arrays have a value for each.

    Attributes:
        value: measured.
        error: standard error, in the unit of the value if its kind has additive errors, else relative; of yes or no
            the share of yes that passes for no.
        kind: such as power or Ra.
        part: number of the part that it is of, from 1; the setting of a table.
        held_out: whether it is of the parts or settings that judge a fit to the others.
    """

    value: Floats
    error: Floats
    kind: NDArray[np.str_]
    part: NDArray[np.int64]
    held_out: NDArray[np.bool_]

    @property
    def kinds(self) -> tuple[str, ...]:
        """That there are, in their order."""
        return tuple(dict.fromkeys(self.kind.tolist()))

    @property
    def loose_error(self) -> Floats:
        """Standard errors as they are where the model does not follow: of weak strokes it then tells little."""
        power = self.kind == "power"
        usual = np.sqrt(np.mean(np.square(self.value[power]))) if power.any() else 0.0
        return np.where(power, np.hypot(self.error, LOOSE * usual), self.error)


@dataclass(frozen=True, slots=True)
class Nuisance:
    """What multiplies measurements besides the constants, and is in no catalogue.

    Attributes:
        spread: logarithmic standard deviation before measuring.
        effect: on each measurement, over its own logarithm.
    """

    spread: float
    effect: Floats


def changes_of(parameters: Sequence[Parameter], z: Floats) -> Changes:
    """The values of parameters by kind and key."""
    changes: dict[str, dict[str, float]] = {}
    for each, place in zip(parameters, z.tolist(), strict=True):
        changes.setdefault(each.kind, {})[each.key] = each.value(place)
    return changes


class Solver:
    """Residuals and their derivatives; variables are those of parameters, then nuisances, in spreads of the prior.

    Args:
        parameters: constants.
        nuisances: what else multiplies measurements.
        data: the measurements.
        predict: what would be measured with changed constants, shape as of `data.value`.
        jumps: whether that jumps where constants change, as under a wheel that crosses.
        like: another one with the same data, which has predicted some of it already.
    """

    def __init__(
        self,
        parameters: tuple[Parameter, ...],
        nuisances: Sequence[Nuisance],
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
        self._effects = np.array([each.spread * each.effect for each in nuisances]).reshape(
            len(nuisances), data.value.size
        )
        self._known: dict[Changed, Floats] = {} if like is None else like._known

    def predicted(self, x: Floats) -> Floats:
        """What would be measured, shape as of the values."""
        count = len(self.parameters)
        changes = changes_of(self.parameters, x[:count])
        key = tuple((each.name, changes[each.kind][each.key]) for each in self.parameters)
        key = tuple(pair for pair, each in zip(key, self.parameters, strict=True) if pair[1] != each.prior)
        if key not in self._known:
            try:
                self._known[key] = np.array(self._predict(changes), np.float64)
            except GrindError:
                self._known[key] = np.full(self.data.value.size, np.nan)
        found: Floats = self._known[key] * np.exp(x[count:] @ self._effects)
        return found

    def residuals(self, predicted: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> Floats:
        """Of the measurements used, in errors."""
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
        self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float], free: NDArray[np.bool_]
    ) -> Floats:
        """The most probable variables, those that are not free being as they are."""
        if not free.any():
            return x
        whole = x.copy()

        def filled(part: Floats) -> Floats:
            whole[free] = part
            return whole

        def residuals(part: Floats) -> Floats:
            return np.append(self.residuals(self.predicted(filled(part)), used, factors), part)

        def jacobian(part: Floats) -> Floats:
            return np.vstack([self.slopes(filled(part).copy(), used, factors, free), np.eye(part.size)])

        best = optimize.least_squares(
            residuals, x[free], jac=jacobian, method="trf", xtol=1e-4, ftol=1e-6, gtol=1e-6, max_nfev=30
        )
        return filled(best.x).copy()

    def slopes(
        self,
        x: Floats,
        used: NDArray[np.bool_],
        factors: Mapping[str, float],
        free: NDArray[np.bool_],
        *,
        central: bool = False,
    ) -> Floats:
        """Derivatives of the residuals, shape (used, free)."""
        here, signs = (
            self.residuals(self.predicted(x), used, factors),
            (1.0, -1.0) if central or self._step == LONG_STEP else (1.0,),
        )
        columns = []
        for k in np.flatnonzero(free).tolist():
            ends = []
            for sign in signs:
                moved = x.copy()
                moved[k] += sign * self._step
                ends.append(self.residuals(self.predicted(moved), used, factors))
            columns.append(
                (ends[0] - ends[-1]) / (2.0 * self._step) if len(ends) == 2 else (ends[0] - here) / self._step
            )
        return np.column_stack(columns)

    def covariance(self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> Floats:
        """Of all variables around the most probable ones."""
        free = np.ones(self.size, np.bool_)
        slopes = self.slopes(x, used, factors, free, central=True)
        return np.asarray(np.linalg.inv(slopes.T @ slopes + np.eye(self.size)), np.float64)

    def without_outliers(self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> NDArray[np.bool_]:
        """The measurements that are near what is predicted, as errors that may be too small say."""
        predicted = self.predicted(x)
        everything = self.residuals(predicted, np.ones(used.size, np.bool_), factors)
        kept = used.copy()
        for kind, chosen in self._of_kind.items():
            mine = np.flatnonzero(chosen & used)
            if kind == YES_OR_NO or mine.size < 8:
                continue
            scatter = max(1.4826 * float(np.median(np.abs(everything[mine]))), 1.0)
            worst = mine[np.argsort(-np.abs(everything[mine]))][: int(MOST_OUTLIERS * mine.size)]
            kept[worst[np.abs(everything[worst]) > OUTLIER * scatter]] = False
        return kept

    def enlarged(self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> dict[str, float]:
        """The factors on errors with which the residuals of every kind agree; never below 1."""
        predicted, plain = self.predicted(x), dict.fromkeys(factors, 1.0)
        everything = self.residuals(predicted, np.ones(used.size, np.bool_), plain)
        taken = self._effective(x, used, factors)
        result = {}
        for kind, chosen in self._of_kind.items():
            mine = chosen & used
            freedom = mine.sum() - taken * mine.sum() / used.sum()
            enough = kind != YES_OR_NO and mine.sum() >= 4 and freedom >= 1.0
            result[kind] = max(1.0, float(np.sqrt(np.square(everything[mine]).sum() / freedom))) if enough else 1.0
        return result

    def _effective(self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> float:
        """How many variables the measurements determine."""
        slopes = self.slopes(x, used, factors, np.ones(self.size, np.bool_))
        information = slopes.T @ slopes
        return float(np.trace(np.linalg.solve(information + np.eye(self.size), information)))
