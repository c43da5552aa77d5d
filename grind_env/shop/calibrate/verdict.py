"""The verdict on a fitted model for terminal, report, JSON and exit status: usable or not, and for what.

A kind of measurement is judged by parts or settings that are held out in turn: the fit to the others must predict them
no worse than the catalogue does.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats
from grind_env.message_text import listed
from grind_env.optional_libraries import needing
from grind_env.shop.calibrate.least_squares import ABSOLUTE, LINEAR, YES_OR_NO, Data

with needing("shop", "a calibration needs"):
    from scipy import special

WORSE = 1.1  #: ratio of the fit's error to the catalogue's error above which the fit is worse
#: probability that the fit is worse, by the scatter between parts (Student); its quantile for errors of measuring
SURE, NORMAL = 0.9, 1.2816
#: logarithm of the likelihood ratio of the burn data, catalogue over fit, above which the fit is worse: 20 times
CONTRADICTED = 3.0
#: least increase of the error by a worse fit, um and mm; `SLIGHTLY_OTHERS` for other kinds. Where the catalogue is
#: right to .1 % a fit is off by .3 %
SLIGHTLY: Mapping[str, float] = {"size": 0.2, "diameter": 0.002}
SLIGHTLY_OTHERS = 0.005
#: uses of a model, each with the kinds of measurement of which one must exist
PURPOSES: Mapping[str, Collection[str]] = {
    "E and dressing": ("power", "Ft", "Fn"),
    "size": ("size",),
    "roughness": ("Ra",),
    "burn": (YES_OR_NO,),
    "wheel wear": ("diameter", "wear", "G"),
}
#: constants that keep the catalogue's values if the fit predicts a kind of measurement worse, by kind
CONSTANTS_OF: Mapping[str, Collection[str]] = {
    "size": ("material.heat_factor",),
    "Ra": ("wheel.roughness", "wheel.roughness_rate"),
    YES_OR_NO: ("material.tempering_rise",),
    **dict.fromkeys(PURPOSES["wheel wear"], ("wheel.g_ratio", "material.g_ratio_exponent", "wheel.initial_wear")),
}

#: by kind of measurement: number of measurements, root mean square error of the catalogue and of the fit
Errors: TypeAlias = Mapping[str, tuple[int, float, float]]


@dataclass(frozen=True, slots=True)
class FitJudgement:
    """Prediction errors of a fit and of the catalogue, by kind of measurement."""

    errors: Errors  #: errors of all used measurements
    held_out: Errors | None  #: errors of parts or settings predicted by a fit to the others; None for a single one
    worse: tuple[str, ...]  #: kinds predicted significantly worse than by the catalogue
    kept: tuple[str, ...] = ()  #: kinds that keep the catalogue's constants

    def verdict(self, *, tells_nothing: bool) -> "FitVerdict":
        """Return whether the model may be used, and for what; `tells_nothing` if the fit determined no constant."""
        if self.worse:
            return FitVerdict("bad", f"Do not use the fit: the catalogue predicts {listed(self.worse)} better.")
        if tells_nothing:
            return FitVerdict("bad", "Do not use the fit: the measurements determine no constant.")
        seen = {purpose: {*kinds} & {*self.errors} for purpose, kinds in PURPOSES.items()}
        uses = tuple(purpose for purpose, kinds in seen.items() if kinds - {*self.kept})
        unseen = [purpose for purpose, kinds in seen.items() if not kinds]
        more = [f"not for {listed(unseen)} (not measured)"] if unseen else []
        more += [f"for {kind} the constants of the catalogue stay, which predict it better" for kind in self.kept]
        care = "" if self.held_out else " with care, because no data were left for a test,"
        headline = "; ".join([f"Use the fit{care} for {listed(uses)}", *more]) + "."
        return FitVerdict("good" if self.held_out else "poor", headline, uses)


@dataclass(frozen=True, slots=True)
class FitVerdict:
    """Verdict on the use of a model."""

    # good, poor for a model without held-out data, or bad for one that must not be used
    level: Literal["good", "poor", "bad"]
    headline: str  #: the verdict as a sentence
    uses: tuple[str, ...] = ()  #: permitted uses


def judge(data: Data, chosen: NDArray[np.bool_], nominal: Floats, predicted: Floats, held_out: Floats) -> FitJudgement:
    """Judge a fit by the chosen measurements."""
    errors, without, worse = dict[str, tuple[int, float, float]](), dict[str, tuple[int, float, float]](), []
    for kind in data.kinds:
        mine = chosen & (data.kind == kind) & np.isfinite(data.value)
        if not mine.any():
            continue
        is_held_out = bool(np.isfinite(held_out[mine]).all())
        before, after, test = (_misses(data, mine, each) for each in (nominal, predicted, held_out))
        # if all burn errors are above 0, nobody has looked for burn
        for found, misses in ((errors, after), (without, test if is_held_out else None)):
            if misses is not None and (kind != YES_OR_NO or not data.error[mine].all()):
                found[kind] = int(mine.sum()), _usual(before), _usual(misses)
        if _is_worse(kind, data, mine, before, test if is_held_out else after):
            worse.append(kind)
    return FitJudgement(errors, without or None, tuple(worse))


def _is_worse(kind: str, data: Data, mine: NDArray[np.bool_], before: Floats, after: Floats) -> bool:
    """Return whether a fit's errors are significantly larger than the catalogue's."""
    if kind == YES_OR_NO:
        unlikely = -np.log(np.maximum(1.0 - np.abs([after, before]), 1e-12)).sum(axis=1)
        return bool(unlikely[0] - unlikely[1] > CONTRADICTED)
    _, part = np.unique(data.part[mine], return_inverse=True)
    more = np.bincount(part, np.square(after) - np.square(before)) / np.bincount(part)
    scatter = (
        float(more.std(ddof=1)) / np.sqrt(more.size) * special.stdtrit(more.size - 1, SURE) if more.size > 1 else 0.0
    )
    # a measuring error moves the difference of two squares by twice the difference of the prediction errors
    error = data.error[mine] / (_usual(data.value[mine]) if kind in LINEAR else 1.0)
    noise = NORMAL * float(np.sqrt(np.mean(np.square(2.0 * error * (after - before))) / part.size))
    fit, catalogue = _usual(after), _usual(before)
    clearly = fit > max(WORSE * catalogue, catalogue + SLIGHTLY.get(kind, SLIGHTLY_OTHERS))
    return clearly and float(more.mean()) > max(scatter, noise)


def _misses(data: Data, mine: NDArray[np.bool_], predicted: Floats) -> Floats:
    """Return the prediction errors of one kind: relative, logarithmic, or in the unit of an `ABSOLUTE` kind."""
    kind, value, guess = str(data.kind[mine][0]), data.value[mine], predicted[mine]
    if kind == YES_OR_NO:
        return np.asarray(value - (1.0 - data.error[mine]) / (1.0 + np.exp(-np.clip(guess, -50.0, 50.0))))
    if kind in LINEAR or kind in ABSOLUTE:
        return np.asarray((value - guess) / (_usual(value) if kind in LINEAR else 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(value / guess))


def _usual(value: Floats) -> float:
    return max(float(np.sqrt(np.mean(np.square(value)))), 1e-150)
