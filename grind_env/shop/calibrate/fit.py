"""The most probable constants given the measurements, with intervals.

Maximum a posteriori by least squares: constants have log-normal priors from the catalogue, measurements normal errors,
and the posterior is taken to be normal around its maximum (Laplace). Where residuals are larger than the errors say,
the errors of that kind of measurement are too small and are enlarged until they agree (Birge, Phys. Rev. 40 (1932)
207). A free term follows deviations from the model, as far as it improves predictions of parts that are held out.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats, Numbers
from grind_env.machine.job import Job
from grind_env.machine.job.drawn_machines import USUAL_DRIFT, usual_uncertainty
from grind_env.message_text import listed
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.fitted_constants import Parameter
from grind_env.shop.calibrate.least_squares import Data, Predict, Solver, bounded
from grind_env.shop.calibrate.verdict import CONSTANTS_OF, FitJudgement, judge
from grind_env.toml import toml_value

NORMAL_90 = 1.6449  #: half width of the 90 % interval of a normal variable, in standard deviations
#: ratio of posterior to prior spread above which a constant is undetermined, unless it moved by more than a spread
UNDETERMINED = 0.9
#: factor on the prior spread of a constant in a fit with a free term: the shares of chips and rubbing in the power are
#: then open, too, because other laws have no such shares
WIDENED_PRIORS = {"material.chip_energy": 6.0}
FOLDS = 8  #: greatest number of groups of parts or settings that are held out in turn
ROUNDS = 2  #: rounds of enlarging errors
#: logarithmic standard deviation of the drift of the power level over a log, at the full width of the free term. The
#: result is the level in the middle of the log: an apparent drift may be a wheel that dulls in another way
DRIFT = 0.05
WIDTHS = (0.25, 0.5, 1.0)  #: widths of the free term that are tried, as shares of its full width
#: ratio of mean square errors on held-out parts, with over without the free term, below which the term is used
FREE_TERM_GAIN = 0.8
#: mean square error on held-out parts, in loose errors, up to which the model needs no free term
MOST_PLAIN_ERROR = 1.0
LEAST_ERROR_FACTOR = 1.05  #: factor on the least mean square error; the smallest width with no greater error is taken
ENOUGH_PARTS = 2
WANDERING_PARTS = 4  #: number of parts above which a drift of the power level from part to part can be estimated
MANY_PARTS = 20  #: number of parts from which on the estimated drift may exceed the usual one
SINGULAR = 1e-6  #: share by which correlations are reduced, so that they may be rounded


class Linear(NamedTuple):
    """Linearised fit around a point."""

    x: Floats  #: variables at the point, in prior spreads
    rest: Floats  #: residuals of the used measurements at the point, in errors of the fit
    slopes: Floats  #: derivatives of the residuals, shape (used, variables)
    used: NDArray[np.bool_]  #: which measurements are used
    enlarged: Floats  #: errors of the fit over `Data.loose_error`, the unit in which fits are compared
    # whether the prior of each variable does not change with the width of the free term
    fixed: NDArray[np.bool_]

    def covariance(self, width: float) -> Floats:
        """Return the covariance of the variables at a width of the free term, in prior spreads at its full width."""
        prior = np.where(self.fixed, 1.0, width**-2.0)
        return np.asarray(np.linalg.inv(self.slopes.T @ self.slopes + np.diag(prior)), np.float64)

    def without(self, rows: NDArray[np.bool_], width: float) -> Floats:
        """Return the residuals of some measurements, in loose errors, from a fit to all others."""
        step = self.at(width, rows) - self.x
        return np.asarray(self.enlarged[rows] * (self.rest[rows] + self.slopes[rows] @ step))

    def at(self, width: float, without: NDArray[np.bool_] | bool = False) -> Floats:
        """Return the variables at a width of the free term, in prior spreads at its full width."""
        prior, chosen = np.where(self.fixed, 1.0, width**-2.0), np.broadcast_to(~np.asarray(without), self.rest.shape)
        others, rest = self.slopes[chosen], self.rest[chosen]
        step = np.linalg.solve(others.T @ others + np.diag(prior), -others.T @ rest - prior * self.x)
        return np.asarray(self.x + step)


def best_width(plain: Linear, wide: Linear, data: Data) -> float:
    """Return the width that best predicts parts held out in turn, as a share of the full width; 0 for no free term."""
    if np.unique(data.part[plain.used & (data.kind == "power")]).size < ENOUGH_PARTS:
        return 0.0
    errors = {0.0: _in_turn(plain, 1.0, data)} | {width: _in_turn(wide, width, data) for width in WIDTHS}
    least = min(errors.values())
    width = next(each for each, error in errors.items() if error <= LEAST_ERROR_FACTOR * least)
    return 0.0 if errors[0.0] < MOST_PLAIN_ERROR or errors[width] > FREE_TERM_GAIN * errors[0.0] else width


def _in_turn(fit: Linear, width: float, data: Data) -> float:
    """Return the mean square error of the power of parts that are held out in turn, in loose errors."""
    part, power = data.part[fit.used], (data.kind == "power")[fit.used]
    missed = [fit.without(part == number, width)[power[part == number]] for number in np.unique(part[power])]
    return float(np.mean(np.square(np.concatenate(missed))))


class RemainingUncertainty(NamedTuple):
    """Uncertainty left by a fit: of constants and of the free term, even if unused.

    A model that agrees with a log may still be wrong at other speeds and depths.
    """

    parameters: tuple[Parameter, ...]  #: constants and fields of the free term
    spread: Floats  #: posterior over prior spread of each
    covariance: Floats  #: their covariance, in prior spreads


@dataclass(frozen=True, slots=True)
class Fit:
    """Result of a fit."""

    parameters: tuple[Parameter, ...]  #: fitted constants, including undetermined ones
    # distance of each constant from its prior, in prior spreads; 0 if undetermined. The nuisances follow: scales, then
    # the drift if a free term was used
    x: Floats
    # posterior over prior spread of each constant, the others being uncertain, too; with the shift that comes from
    # resetting undetermined constants to their priors
    spread: Floats
    determined: NDArray[np.bool_]  #: whether the measurements determine each constant
    width: float  #: width of the free term that was used, as a share of its full width
    # logarithm of the factor of each meter whose scale is uncertain, by kind of measurement
    scales: Mapping[str, float]
    scale_spreads: Mapping[str, float]  #: posterior standard deviation of `scales`
    factors: Mapping[str, float]  #: factors by which the errors of each kind were enlarged
    used: NDArray[np.bool_]  #: which measurements were used
    predicted: Floats  #: predictions of all measurements, with the scales
    nominal: Floats  #: predictions with the unchanged catalogue, and the scales that fit it best
    held_out: Floats  #: prediction of each by a fit to the other parts or settings; NaN if there are no others
    remaining: RemainingUncertainty

    @property
    def z(self) -> Floats:
        return self.x[: len(self.parameters)]


class _Place(NamedTuple):
    """Current point of a solver."""

    solver: Solver
    x: Floats
    used: NDArray[np.bool_]
    factors: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class FitProblem:
    """Data and parameters of a fit."""

    parameters: tuple[Parameter, ...]  #: constants that may change
    # logarithmic standard deviation of a meter's factor, by kind of measurement; only for uncertain meters
    scales: Mapping[str, float]
    data: Data  #: measurements
    predict: Predict  #: prediction of the measurements with changed constants, shape of `data.value`
    report_stage: Callable[[str], None]  #: called with the name of each stage
    free: tuple[Parameter, ...] = ()  #: the free term at its full width; empty for none
    jumps: bool = False  #: whether predictions jump where constants change, as for a wheel that crosses
    left_out: tuple[str, ...] = ()  #: kinds of measurement that are not used

    @property
    def outside_free_term(self) -> NDArray[np.bool_]:
        """Return which variables do not belong to the free term, if there is one."""
        return np.repeat([True, False, True, False], [len(self.parameters), len(self.free), len(self.scales), 1])

    def solver(self, width: float, like: Solver | None = None, opened: Mapping[str, float] = WIDENED_PRIORS) -> Solver:
        """Return the solver at a width of the free term; above 0, the priors of `opened` constants are wider."""
        data, parameters = self.data, self.parameters
        nuisances = [spread * (data.kind == kind) for kind, spread in self.scales.items()]
        if width:
            data = replace(data, error=data.loose_error)
            parameters = (
                *(replace(each, spread=opened.get(each.name, 1.0) * each.spread) for each in parameters),
                *(replace(each, spread=width * each.spread) for each in self.free),
            )
            first, last = int(data.part.min()), int(data.part.max())
            middle = 0.5 * (first + last)
            nuisances.append(width * DRIFT * ((data.kind == "power") * (data.part - middle) / max(last - first, 1)))
        return Solver(parameters, nuisances, data, self.predict, jumps=self.jumps, like=like)


def fit_and_judge(problem: FitProblem) -> tuple[Fit, FitJudgement]:
    """Fit constants and judge the fit; constants of measurements that are then predicted worse keep catalogue values.

    Errors as in `fit`.
    """
    found = fit(problem)
    judged = judge(problem.data, found.used, found.nominal, found.predicted, found.held_out)
    own = {name for kind in judged.worse for name in CONSTANTS_OF.get(kind, ())}
    left = tuple(each for each in problem.parameters if each.name not in own)
    if len(left) == len(problem.parameters) or not left:
        return found, judged
    problem.report_stage(f"fitting without {listed(judged.worse)}")
    other = fit(replace(problem, parameters=left, left_out=judged.worse))
    chosen = other.used | np.isin(problem.data.kind, judged.worse)
    again = judge(problem.data, chosen, other.nominal, other.predicted, other.held_out)
    return (found, judged) if again.worse else (other, replace(again, kept=judged.worse))


def fit(problem: FitProblem) -> Fit:
    """Fit constants to measurements."""
    data, count = problem.data, len(problem.parameters)
    used = np.isfinite(data.value) & np.isfinite(data.error) & ~np.isin(data.kind, problem.left_out)
    if used.sum() < 2:
        raise CalibrationError("there are fewer than two measurements to fit; log more strokes or parts")
    plain = problem.solver(0.0)
    x, unit = np.zeros(plain.size), dict.fromkeys(data.kinds, 1.0)
    if not np.isfinite(plain.predicted(x)[used]).all():
        raise CalibrationError("the process model has no numbers for this job as the catalogue has it; check the job")
    at_first = plain.enlarged(x, used, unit, gauged=False)
    nominal = plain.predicted(plain.solve(x, used, at_first, np.arange(plain.size) >= count))
    place, width, wider = _settled(problem, plain, x, used), 0.0, None
    if problem.free:
        problem.report_stage("holding parts out in turn")
        at_most = problem.solver(1.0, plain)
        wide = _settled(problem, at_most, np.zeros(at_most.size), used)
        linear = _linear(problem, wide, problem.outside_free_term)
        width = best_width(_linear(problem, place), linear, data)
        if width == 1.0:
            place = wide
        elif width:
            ratio, at_most = np.where(problem.outside_free_term, 1.0, width), problem.solver(width, plain)
            at_most.begin_with(wide.solver, ratio)
            place = _settled(problem, at_most, linear.at(width) / ratio, wide.used, wide)
        else:
            narrow = problem.solver(1.0, plain, {})
            x = np.zeros(narrow.size)  # with a free term that has no effect
            x[problem.outside_free_term] = place.x
            there = _Place(narrow, x, place.used, wide.factors)
            wider = narrow.parameters, _linear(problem, there, problem.outside_free_term).covariance(WIDTHS[0])
    return _finished(problem, width, place, nominal, wider)


def _settled(
    problem: FitProblem, solver: Solver, x: Floats, used: NDArray[np.bool_], like: _Place | None = None
) -> _Place:
    """Return the most probable variables, with errors as large as residuals say and without outliers.

    The search starts at `x`. With the errors of a similar point `like`, one round is enough.
    """
    # the first errors match the catalogue's residuals, so that the power does not overrule gauges while it is far off
    every, free, rounds = used, np.ones(solver.size, np.bool_), range(ROUNDS if like is None else 1)
    unit = dict.fromkeys(solver.data.kinds, 1.0)
    factors = solver.enlarged(x, used, unit, gauged=False) if like is None else like.factors
    for number in rounds:
        problem.report_stage(f"fitting, round {number + 1}")
        x = solver.solve(x, used, factors, free, roughly=True)
        used = solver.without_outliers(x, every)
        factors = solver.enlarged(x, used, factors, gauged=number == rounds[-1])
    return _Place(solver, solver.solve(x, used, factors, free), used, factors)


def _linear(problem: FitProblem, place: _Place, of_prior: NDArray[np.bool_] | None = None) -> Linear:
    """Return a fit linearised around its point; `of_prior` becomes `Linear.fixed`, all True if None."""
    solver, x, used, factors = place.solver, place.x, place.used, place.factors
    every = np.ones(solver.size, np.bool_)
    enlarged = np.array([factors[kind] for kind in solver.data.kind.tolist()]) * solver.data.error
    loose = problem.data.loose_error
    return Linear(
        x=x,
        rest=solver.residuals(solver.predicted(x), used, factors),
        slopes=solver.slopes(x, used, factors),
        used=used,
        enlarged=np.divide(enlarged, loose, out=np.ones(loose.size), where=loose > 0.0)[used],
        fixed=every if of_prior is None else of_prior,
    )


def _finished(
    problem: FitProblem,
    width: float,
    place: _Place,
    nominal: Floats,
    wider: tuple[tuple[Parameter, ...], Floats] | None,
) -> Fit:
    """Return the result, with constants that the measurements do not determine reset to the catalogue.

    `wider` are constants and covariance with a free term, if none was used.
    """
    data, solver, used, factors, joint = problem.data, place.solver, place.used, place.factors, place.x
    count, scales = len(solver.parameters), problem.scales
    covariance = solver.covariance(joint, used, factors)
    spread: Floats = np.asarray(np.sqrt(np.diag(covariance)), np.float64)
    known, free = (spread < UNDETERMINED)[:count] | (np.abs(joint[:count]) > 1.0), np.ones(solver.size, np.bool_)
    problem.report_stage("keeping what the measurements do not tell")
    free[:count] = known
    x = solver.solve(np.where(free, joint, 0.0), used, factors, free)
    spread = np.where(free, np.hypot(spread, x - joint), spread)
    problem.report_stage("leaving parts out")
    parts = np.unique(data.part[used])
    held_out = np.full(data.value.size, np.nan)
    for fold in range(min(parts.size, FOLDS) if parts.size > 1 else 0):
        rows = np.isin(data.part, parts[fold::FOLDS])
        held_out[rows] = solver.without(x, rows, used, factors, free)
    parameters, open_ = (solver.parameters, covariance) if wider is None else wider
    open_ = open_[: len(parameters), : len(parameters)]
    spreads = np.sqrt(np.diag(open_))
    spreads[:count] = np.maximum(spreads[:count], spread[:count])
    return Fit(
        remaining=RemainingUncertainty(parameters, spreads, open_),
        parameters=solver.parameters,
        x=x,
        spread=spread[:count],
        determined=known,
        width=width,
        scales={kind: float(bounded(x)[count + k] * scales[kind]) for k, kind in enumerate(scales)},
        scale_spreads={kind: float(spread[count + k] * scales[kind]) for k, kind in enumerate(scales)},
        factors=factors,
        used=used,
        predicted=solver.predicted(x),
        nominal=nominal,
        held_out=held_out,
    )


def residual_and_drift(fitted: Fit, data: Data, block: Numbers) -> tuple[float, float]:
    """Return logarithmic standard deviations: of the power of blocks around the model, and of a step of the level.

    If there are several parts, each part is predicted from all others. Steps are from part to part.
    """
    predicted = np.where(np.isfinite(fitted.held_out), fitted.held_out, fitted.predicted)
    rest = np.where(fitted.used, data.value - predicted, np.nan)
    seen = np.isfinite(rest) & (block > 0)
    of_block = _levels(rest[seen], data.value[seen], data.error[seen], block[seen])
    of_part = _levels(rest[seen], data.value[seen], data.error[seen], data.part[seen])
    drift = 0.0
    if of_part.size > WANDERING_PARTS:
        once, twice = (float(np.mean(np.square(of_part[k:] - of_part[:-k]))) for k in (1, 2))
        drift = float(np.sqrt(max(twice - once, 0.0)))
    if of_part.size < MANY_PARTS:  # errors of a model on a few parts may look like a drift, which adds up over a lot
        drift = min(drift, USUAL_DRIFT)
    return float(np.sqrt(np.mean(np.square(of_block)))), drift


def _levels(rest: Floats, value: Floats, error: Floats, group: Numbers) -> Floats:
    """Return the relative error of the power of each group, its members weighted by their accuracy."""
    _, number = np.unique(group, return_inverse=True)
    weight = value / np.square(error)
    return np.asarray(np.bincount(number, weight * rest) / np.bincount(number, weight * value))


def uncertainty_lines(job: Job, fitted: Fit, source: str, residual: float, drift: float) -> list[str]:
    """Return the table [uncertainty] as lines of TOML; what was not fitted keeps the uncertainty of the catalogue."""
    remaining, usual = fitted.remaining, usual_uncertainty(job)
    names = [each.name for each in remaining.parameters]
    others = {name: each for name, each in zip(usual.names, usual.spread, strict=True) if name not in names}
    count, spread = len(names), remaining.spread * np.array([each.spread for each in remaining.parameters])
    scale = np.sqrt(np.diag(remaining.covariance))
    correlation = np.eye(count + len(others))
    correlation[:count, :count] = (1.0 - SINGULAR) * remaining.covariance / np.outer(scale, scale)
    np.fill_diagonal(correlation, 1.0)
    rows = ",\n".join("  [" + ", ".join(f"{each:.8g}" for each in row) + "]" for row in correlation.round(8).tolist())
    return [
        "# Standard deviations of logarithms (of exponents: of themselves) after the fit, and their correlation; wider",
        "# than the intervals above, because the exponents of depth, speed and volume are uncertain here, too;",
        "# residual: of the power of a block about the model; drift: of the step of the power level from part to part.",
        "[uncertainty]",
        f"source = {source}",
        f"names = {toml_value([*names, *others])}",
        f"spread = [{', '.join(f'{each:.4g}' for each in (*spread.tolist(), *others.values()))}]",
        f"correlation = [\n{rows},\n]",
        f"residual = {residual:.4g}",
        f"drift = {drift:.4g}",
    ]
