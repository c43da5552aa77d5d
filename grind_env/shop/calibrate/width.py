"""How much of the free term is used: as much as predicts parts better that are held out in turn."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grind_env.shop.calibrate.solver import Data
from grind_env.shop.measurements.sheet import Floats

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
    """A fit as far as it is linear around its place."""

    x: Floats  # variables there, in spreads of the prior
    rest: Floats  # residuals there of the measurements used, in the errors of the fit
    slopes: Floats  # of these, shape (used, variables)
    used: NDArray[np.bool_]  # which measurements
    enlarged: Floats  # errors of the fit over `Data.loose_error`, in which fits are compared
    # of each variable, whether its prior stays as it is where the width of the free term changes
    fixed: NDArray[np.bool_]

    def covariance(self, width: float) -> Floats:
        """Of the variables, with so much of the free term; in spreads of the prior at its full width."""
        prior = np.where(self.fixed, 1.0, width**-2.0)
        return np.asarray(np.linalg.inv(self.slopes.T @ self.slopes + np.diag(prior)), np.float64)

    def without(self, rows: NDArray[np.bool_], width: float) -> Floats:
        """Residuals of measurements of the power, in loose errors, that a fit to all other rows predicts."""
        step = self.at(width, rows) - self.x
        found: Floats = self.enlarged[rows] * (self.rest[rows] + self.slopes[rows] @ step)
        return found

    def at(self, width: float, without: NDArray[np.bool_] | bool = False) -> Floats:
        """Return the variables with so much of the free term, in spreads of the prior at its full width."""
        prior, chosen = np.where(self.fixed, 1.0, width**-2.0), np.broadcast_to(~np.asarray(without), self.rest.shape)
        others, rest = self.slopes[chosen], self.rest[chosen]
        step = np.linalg.solve(others.T @ others + np.diag(prior), -others.T @ rest - prior * self.x)
        return np.asarray(self.x + step)


def best_width(plain: Linear, wide: Linear, data: Data) -> tuple[float, float]:
    """Return the width that predicts best, a share of the full one.

    With the mean square of what it misses on parts that are left out in turn, over that without a free term.
    """
    if np.unique(data.part[plain.used & (data.kind == "power")]).size < ENOUGH_PARTS:
        return 0.0, 1.0
    errors = {0.0: _in_turn(plain, 1.0, data)} | {width: _in_turn(wide, width, data) for width in WIDTHS}
    least = min(errors.values())
    width = next(each for each, error in errors.items() if error <= ALIKE * least)
    if errors[0.0] < FOLLOWED or errors[width] > CLEARLY * errors[0.0]:
        width = 0.0
    return width, errors[width] / errors[0.0]


def _in_turn(fit: Linear, width: float, data: Data) -> float:
    """Return the mean square error of the power of parts that are left out in turn, in loose errors."""
    part, power = data.part[fit.used], (data.kind == "power")[fit.used]
    missed = [fit.without(part == number, width)[power[part == number]] for number in np.unique(part[power])]
    return float(np.mean(np.square(np.concatenate(missed))))
