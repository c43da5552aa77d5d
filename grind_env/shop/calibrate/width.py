"""How much of the free term is used: as much as predicts parts better that are held out in turn."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grind_env.shop.calibrate.sheet import Floats
from grind_env.shop.calibrate.solver import Data

WIDTHS = (0.25, 0.5, 1.0)
"""Shares of its full width that are tried."""
CLEARLY = 0.8
"""Of the mean square error on parts held out without it, below which the free term is worth it."""
FOLLOWED = 1.0
"""Mean square error on them, in loose errors, up to which the model needs no free term."""
ALIKE = 1.05
"""Of the least mean square error: the smallest width with no more is taken."""
ENOUGH_PARTS = 2


@dataclass(frozen=True, slots=True)
class Linear:
    """A fit as far as it is linear around its place.

    Attributes:
        x: variables there, in spreads of the prior.
        rest: residuals there of the measurements used, in the errors of the fit.
        slopes: of these, shape (used, variables).
        used: which measurements.
        enlarged: errors of the fit over `Data.loose_error`, in which fits are compared.
        fixed: of each variable, whether its prior stays as it is where the width of the free term changes.
    """

    x: Floats
    rest: Floats
    slopes: Floats
    used: NDArray[np.bool_]
    enlarged: Floats
    fixed: NDArray[np.bool_]

    def covariance(self, width: float) -> Floats:
        """Of the variables, with so much of the free term; in spreads of the prior at its full width."""
        prior = np.where(self.fixed, 1.0, width**-2.0)
        return np.asarray(np.linalg.inv(self.slopes.T @ self.slopes + np.diag(prior)), np.float64)

    def without(self, rows: NDArray[np.bool_], width: float) -> Floats:
        """Residuals of measurements of the power, in loose errors, that a fit to all other rows predicts."""
        prior = np.where(self.fixed, 1.0, width**-2.0)
        others, rest = self.slopes[~rows], self.rest[~rows]
        step = np.linalg.solve(others.T @ others + np.diag(prior), -others.T @ rest - prior * self.x)
        found: Floats = self.enlarged[rows] * (self.rest[rows] + self.slopes[rows] @ step)
        return found


@dataclass(frozen=True, slots=True)
class InTurn:
    """The power of each part as a fit to all others predicts it.

    Attributes:
        rest: residual of each measurement, in loose errors; NaN where it took no part.
        gain: mean square of these over that without a free term.
    """

    rest: Floats
    gain: float


def best_width(plain: Linear, wide: Linear, data: Data) -> tuple[float, InTurn | None]:
    """The width that predicts best, a share of the full one, and what it predicts.

    Args:
        plain: a fit without the free term.
        wide: one with all of it.
        data: the measurements.
    """
    if np.unique(data.part[plain.used & (data.kind == "power")]).size < ENOUGH_PARTS:
        return 0.0, None
    found = {0.0: _in_turn(plain, 1.0, data)} | {width: _in_turn(wide, width, data) for width in WIDTHS}
    errors = {width: float(np.nanmean(np.square(each))) for width, each in found.items()}
    least = min(errors.values())
    width = next(each for each, error in errors.items() if error <= ALIKE * least)
    if errors[0.0] < FOLLOWED or errors[width] > CLEARLY * errors[0.0]:
        width = 0.0
    return width, InTurn(found[width], errors[width] / errors[0.0])


def _in_turn(fit: Linear, width: float, data: Data) -> Floats:
    rest = np.full(data.value.size, np.nan)
    part, power = data.part[fit.used], (data.kind == "power")[fit.used]
    for number in np.unique(part[power]).tolist():
        rows = part == number
        of_power = np.flatnonzero(fit.used)[rows & power]
        rest[of_power] = fit.without(rows, width)[power[rows]]
    return rest
