"""Each valve alloy left out and predicted from the other: by a constant, by a power law, by the model.

Nothing is fitted to the alloy that is left out. All three are fitted to the other one under the same wheel, in the mean
of the logarithms, so that their level is one and the same, and only how they run over rate and volume tells them apart.
A level of its own has the model that is told how fast the left-out alloy wears the wheel: Ra then follows from what Ra
has to do with wear.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import exp, log
from typing import NamedTuple

import numpy as np

from grind_env.arrays import Array
from grind_env.process.entries import Material, quantities
from grind_env.validation.rig import Rig
from grind_env.validation.valve_alloys import (
    ALLOYS,
    RESPONSES,
    WHEELS,
    AlloyRuns,
    AlloyWheel,
    fitted,
    measured,
    simulated,
)

CONSTANT, POWER_LAW, MODEL = "constant", "power law", "model"
WEAR_KNOWN, SHIPPED = "model, wear known", "inc751 as shipped"
PREDICTORS = (CONSTANT, POWER_LAW, MODEL, WEAR_KNOWN, SHIPPED)
"""What predicts.

The constant is the mean of the other alloy. The power law has a level and exponents on rate and volume, fitted to it.
The model has the G-ratio factor and exponent of a material, fitted to its wear, and a factor on its Ra; where the wear
is known, the two are fitted to that of the left-out alloy. The last is the entry of the catalogue, nothing fitted.
"""
FIT_STEPS = 20
"""Steps that bring the wear of the model to that of the runs, to 1e-4 where it can be had."""


class Error(NamedTuple):
    """How far a prediction is off, %; 100 is a factor of two, either way.

    Attributes:
        level: of the mean of the nine runs.
        course: of a run beside that mean, root mean square.
    """

    level: float
    course: float


@dataclass(frozen=True, slots=True)
class LeftOut:
    """How well the runs of a wheel in an alloy are predicted from those in the other.

    Attributes:
        wheel: as in the data, with its speed.
        response: wear or Ra.
        alloy: that is left out.
        errors: by name of `PREDICTORS`; wear is not predicted from wear that is known.
    """

    wheel: str
    response: str
    alloy: str
    errors: Mapping[str, Error]


def left_out(rig: Rig) -> list[LeftOut]:
    """Each alloy predicted from the other, for every wheel and response.

    Raises:
        CatalogueError: the catalogue has no INC751.
    """
    return [each for wheel, response in product(WHEELS, RESPONSES) for each in _of(rig, wheel, response)]


def mean_errors(each: Sequence[LeftOut]) -> dict[str, Error]:
    """The mean errors by predictor, of those that have one."""
    found = {name: [one.errors[name] for one in each if name in one.errors] for name in PREDICTORS}
    return {name: Error(*np.mean(errors, axis=0).tolist()) for name, errors in found.items() if errors}


def difference(each: Sequence[LeftOut], one: str, other: str) -> tuple[float, float]:
    """Course error of one predictor less that of another, %: mean, and its standard error."""
    less = [of.errors[one].course - of.errors[other].course for of in each]
    return float(np.mean(less)), float(np.std(less, ddof=1) / len(less) ** 0.5)


def _of(rig: Rig, wheel: AlloyWheel, response: str) -> list[LeftOut]:
    runs = {alloy: measured(wheel, alloy) for alloy in ALLOYS}
    model = {alloy: getattr(_fitted_model(rig, wheel, runs[alloy]), response) for alloy in ALLOYS}
    shipped = getattr(simulated(rig, wheel), response)
    found = []
    for alloy, other in zip(ALLOYS, ALLOYS[::-1], strict=True):
        truth, source = getattr(runs[alloy], response), getattr(runs[other], response)
        on_rate, on_volume = fitted(runs[other], response)
        scale = _mean(source) / _mean(model[other])
        predicted = {
            CONSTANT: np.full(len(truth), _mean(source)),
            POWER_LAW: _levelled(runs[other].rate ** on_rate * runs[other].volume ** on_volume, source),
            MODEL: scale * model[other],
            SHIPPED: shipped,
        }
        if RESPONSES[response] == "Ra":
            predicted[WEAR_KNOWN] = scale * model[alloy]
        errors = {name: error(values, truth) for name, values in predicted.items()}
        found.append(LeftOut(f"{wheel.measured} {wheel.speed:g} m/s", RESPONSES[response], alloy, errors))
    return found


def error(predicted: Array, truth: Array) -> Error:
    """How far predicted values, shape (runs,), are off the true ones."""
    off = np.log(predicted / truth)
    return Error(*(100.0 * np.expm1([abs(np.mean(off)), np.std(off)])).tolist())


def _mean(values: Array) -> float:
    return float(np.exp(np.mean(np.log(values))))


def _levelled(course: Array, source: Array) -> Array:
    return course * (_mean(source) / _mean(course))


def _fitted_model(rig: Rig, wheel: AlloyWheel, runs: AlloyRuns) -> AlloyRuns:
    """The model with the G-ratio factor and exponent of a material that wears the wheel as the runs did.

    The mean wear and its exponent on the rate are met, as far as the ranges of the two fields let them.
    """
    alumina = rig.catalogue.wheel(wheel.entry).abrasive == "alumina"
    fields = ("g_ratio_factor" if alumina else "g_ratio_factor_cbn", "g_ratio_exponent")
    factor, exponent = (getattr(rig.catalogue.material("inc751"), name) for name in fields)
    model = simulated(rig, wheel)
    for _ in range(FIT_STEPS):
        more = fitted(runs, "wheel_wear_um")[0] - fitted(model, "wheel_wear_um")[0]
        worn = log(_mean(runs.wheel_wear_um) / _mean(model.wheel_wear_um))
        if max(abs(more), abs(worn)) < 1e-4:
            break
        factor = _allowed(fields[0], factor * exp(-worn), factor)
        exponent = _allowed(fields[1], exponent + more, exponent)
        model = simulated(rig, wheel, {fields[0]: factor, fields[1]: exponent})
    return model


def _allowed(name: str, value: float, before: float) -> float:
    return value if quantities(Material)[name].allows(value) else before
