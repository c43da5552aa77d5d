"""The most probable constants given what was measured, and their intervals.

Maximum a posteriori by least squares: constants have log-normal priors from the catalogue, measurements normal errors,
and the posterior is taken to be normal around its maximum (Laplace). Where residuals are larger than the errors say,
the errors of that kind of measurement are too small and are enlarged until they agree (Birge, Phys. Rev. 40 (1932)
207).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from grind_env.errors import GrindError
from grind_env.extras import needing
from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.calibrate.parameters import Parameter
from grind_env.shop.calibrate.sheet import Floats

with needing("shop", "a calibration needs"):
    from scipy import optimize

NORMAL_90 = 1.6449
"""Standard deviations on either side in which a normal variable lies with 90 %."""
TOLD = 0.9
"""Posterior over prior spread from which on the measurements tell nothing of a constant."""
OUTLIER = 5.0
"""Errors from which on a measurement is left out."""
MOST_OUTLIERS = 0.1
"""Share of the measurements of a kind that may be left out."""
STEP, LONG_STEP = 0.03, 0.5
"""Of derivatives, in spreads of the prior; of a model with jumps, over which the long one takes the mean."""
ROUNDS = 2
"""Of enlarging errors."""
HOPELESS = 1e3
"""Residual of constants with which the process model has no numbers."""

Changes: TypeAlias = Mapping[str, Mapping[str, float]]
"""Values by kind of entry and field."""
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
        error: standard error, in the unit of the value if its kind has additive errors, else relative.
        kind: such as power or Ra.
        held_out: whether it is of the parts or settings that judge a fit to the others.
    """

    value: Floats
    error: Floats
    kind: NDArray[np.str_]
    held_out: NDArray[np.bool_]

    @property
    def kinds(self) -> tuple[str, ...]:
        """That there are, in their order."""
        return tuple(dict.fromkeys(self.kind.tolist()))


@dataclass(frozen=True, slots=True)
class Fit:
    """What was found.

    Attributes:
        parameters: that were fitted, those that the measurements do not tell among them.
        z: of each, in prior spreads from its prior; 0 if the measurements do not tell it.
        spread: posterior spread of each over that of the prior, the others being as uncertain as they are; with how far
            it has moved because those that are not told were put back to their priors.
        told: whether the measurements tell it.
        covariance: of `z` and `scales`.
        scales: logarithm of the factor of each meter whose scale is uncertain, by kind of measurement.
        scale_spreads: posterior spread of these.
        factors: by which the errors of each kind were enlarged.
        used: which measurements took part.
        predicted: of all measurements, with the scales.
        nominal: the same with the catalogue as it was, and the scales that fit it best.
    """

    parameters: tuple[Parameter, ...]
    z: Floats
    spread: Floats
    told: NDArray[np.bool_]
    covariance: Floats
    scales: Mapping[str, float]
    scale_spreads: Mapping[str, float]
    factors: Mapping[str, float]
    used: NDArray[np.bool_]
    predicted: Floats
    nominal: Floats


def changes_of(parameters: Sequence[Parameter], z: Floats) -> Changes:
    """The values of parameters by kind and key."""
    changes: dict[str, dict[str, float]] = {}
    for each, place in zip(parameters, z.tolist(), strict=True):
        changes.setdefault(each.kind, {})[each.key] = each.value(place)
    return changes


def fit(
    parameters: Sequence[Parameter],
    scales: Mapping[str, float],
    data: Data,
    predict: Predict,
    told: Callable[[str], None] = lambda stage: None,
    *,
    held_out: NDArray[np.bool_] | None = None,
    jumps: bool = False,
) -> Fit:
    """Fit constants to measurements.

    Args:
        parameters: that may move.
        scales: logarithmic spread of the factor of the meter of a kind of measurement, where it is uncertain.
        data: the measurements.
        predict: what would be measured with changed constants, shape as of `data.value`.
        told: is told what is being done.
        held_out: measurements that take no part; None for all to do so.
        jumps: whether what is predicted jumps where constants change, as under a wheel that crosses.

    Raises:
        CalibrationError: there are fewer measurements than two, or the catalogue itself predicts none.
    """
    solver = _Solver(tuple(parameters), dict(scales), data, predict, LONG_STEP if jumps else STEP)
    used = np.isfinite(data.value) & np.isfinite(data.error)
    if held_out is not None:
        used &= ~held_out
    if used.sum() < 2:
        raise CalibrationError("there are fewer than two measurements to fit; log more strokes or parts")
    x, free = np.zeros(solver.size), np.ones(solver.size, np.bool_)
    factors, count = dict.fromkeys(data.kinds, 1.0), len(parameters)
    if not np.isfinite(solver.predicted(x)[used]).all():
        raise CalibrationError("the process model has no numbers for this job as the catalogue has it; check the job")
    nominal = solver.predicted(solver.solve(x, used, factors, np.arange(solver.size) >= count))
    for number in range(ROUNDS):
        told(f"fitting, round {number + 1}")
        x = solver.solve(x, used, factors, free)
        used = solver.without_outliers(x, used, factors)
        factors = solver.enlarged(x, used, factors)
    x = solver.solve(x, used, factors, free)
    covariance = solver.covariance(x, used, factors)
    spread: Floats = np.asarray(np.sqrt(np.diag(covariance)), np.float64)
    known = spread[:count] < TOLD
    told("keeping what the measurements do not tell")
    free[:count] = known
    joint = x
    x = solver.solve(np.where(free, x, 0.0), used, factors, free)
    spread = np.where(free, np.hypot(spread, x - joint), spread)
    return Fit(
        parameters=tuple(parameters),
        z=x[:count],
        spread=spread[:count],
        told=known,
        covariance=covariance,
        scales={kind: float(x[count + k] * scales[kind]) for k, kind in enumerate(scales)},
        scale_spreads={kind: float(spread[count + k] * scales[kind]) for k, kind in enumerate(scales)},
        factors=factors,
        used=used,
        predicted=solver.predicted(x),
        nominal=nominal,
    )


class _Solver:
    """Residuals and their derivatives; variables are those of parameters, then of scales, in spreads of the prior."""

    def __init__(
        self, parameters: tuple[Parameter, ...], scales: dict[str, float], data: Data, predict: Predict, step: float
    ) -> None:
        self.parameters, self.scales, self.data, self._predict, self._step = parameters, scales, data, predict, step
        self.size = len(parameters) + len(scales)
        self._of_kind = {kind: data.kind == kind for kind in data.kinds}
        self._known: dict[bytes, Floats] = {}  # derivatives are asked for again where a fit has ended

    def predicted(self, x: Floats) -> Floats:
        z = x[: len(self.parameters)]
        key = z.tobytes()
        if key not in self._known:
            try:
                self._known[key] = np.array(self._predict(changes_of(self.parameters, z)), np.float64)
            except GrindError:
                self._known[key] = np.full(self.data.value.size, np.nan)
        return self._scaled(self._known[key], x)

    def _scaled(self, predicted: Floats, x: Floats) -> Floats:
        for k, (kind, spread) in enumerate(self.scales.items(), len(self.parameters)):
            if kind in self._of_kind:
                predicted = np.where(self._of_kind[kind], predicted * np.exp(spread * x[k]), predicted)
        return predicted

    def residuals(self, predicted: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> Floats:
        """Of the measurements used, in errors."""
        data, result = self.data, np.zeros(self.data.value.size)
        for kind, chosen in self._of_kind.items():
            value, error, guess = data.value[chosen], data.error[chosen] * factors[kind], predicted[chosen]
            if kind == YES_OR_NO:
                result[chosen] = np.sqrt(2.0 * np.logaddexp(0.0, np.where(value > 0.5, -guess, guess)))
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

        def slopes(part: Floats) -> Floats:
            return np.vstack([self._slopes(filled(part).copy(), used, factors, free), np.eye(part.size)])

        best = optimize.least_squares(
            residuals, x[free], jac=slopes, method="trf", xtol=1e-4, ftol=1e-6, gtol=1e-6, max_nfev=30
        )
        return filled(best.x).copy()

    def _slopes(
        self,
        x: Floats,
        used: NDArray[np.bool_],
        factors: Mapping[str, float],
        free: NDArray[np.bool_],
        *,
        central: bool = False,
    ) -> Floats:
        """Derivatives of the residuals, shape (used, free)."""
        count, raw = len(self.parameters), self.predicted(x)
        here, signs = self.residuals(raw, used, factors), (1.0, -1.0) if central or self._step == LONG_STEP else (1.0,)
        columns = []
        for k in np.flatnonzero(free).tolist():
            ends = []
            for sign in signs:
                moved = x.copy()
                moved[k] += sign * self._step
                predicted = self.predicted(moved) if k < count else self._rescaled(raw, k, sign * self._step)
                ends.append(self.residuals(predicted, used, factors))
            columns.append(
                (ends[0] - ends[-1]) / (2.0 * self._step) if len(ends) == 2 else (ends[0] - here) / self._step
            )
        return np.column_stack(columns)

    def _rescaled(self, predicted: Floats, k: int, step: float) -> Floats:
        kind, spread = list(self.scales.items())[k - len(self.parameters)]
        chosen = self._of_kind.get(kind, np.zeros(predicted.size, np.bool_))
        return np.where(chosen, predicted * np.exp(spread * step), predicted)

    def covariance(self, x: Floats, used: NDArray[np.bool_], factors: Mapping[str, float]) -> Floats:
        """Of all variables around the most probable ones."""
        free = np.ones(self.size, np.bool_)
        slopes = self._slopes(x, used, factors, free, central=True)
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
        slopes = self._slopes(x, used, factors, np.ones(self.size, np.bool_))
        information = slopes.T @ slopes
        return float(np.trace(np.linalg.solve(information + np.eye(self.size), information)))


def errors_of(fitted: Fit, data: Data, chosen: NDArray[np.bool_]) -> Mapping[str, tuple[int, float, float]]:
    """Of each kind among the chosen: how many, root mean square error of the catalogue and of the fit.

    Relative to the root mean square for power, of the logarithm for other scales; of size and diameter in their unit.
    """
    found = {}
    for kind in data.kinds:
        mine = chosen & (data.kind == kind)
        if kind == YES_OR_NO or not mine.any():
            continue
        before, after = (_error(kind, data.value[mine], each[mine]) for each in (fitted.nominal, fitted.predicted))
        found[kind] = (int(mine.sum()), before, after)
    return found


def _error(kind: str, value: Floats, predicted: Floats) -> float:
    if kind in LINEAR:
        return float(np.sqrt(np.mean(np.square(value - predicted)) / max(float(np.mean(np.square(value))), 1e-300)))
    if kind in ABSOLUTE:
        return float(np.sqrt(np.mean(np.square(value - predicted))))
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.sqrt(np.mean(np.square(np.log(value / predicted)))))
