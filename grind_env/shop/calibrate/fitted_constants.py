"""Fittable constants of the catalogue, each with its prior spread."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from grind_env.machine.job import Job
from grind_env.machine.job.drawn_machines import USUAL_SPREADS
from grind_env.machine.job.job_entries import entries_of
from grind_env.message_text import did_you_mean, quoted
from grind_env.process.catalogue import KINDS
from grind_env.process.entries import Quantity, quantities
from grind_env.process.force_correction import EXPONENTS
from grind_env.shop.calibrate.exceptions import CalibrationError

#: constants that are fitted by default; their prior spreads are in `SPREADS`
USUAL = (
    "material.chip_energy",
    "material.ploughing_pressure",
    "material.pressure_factor",
    "material.wear_flat_growth",
    "material.tempering_rise",
    "wheel.dressed_wear_flat",
    "wheel.g_ratio",
    "wheel.roughness",
    "machine.stiffness",
)
#: fields of a material that follow deviations from the model, with their full standard deviation (logarithmic for the
#: factor): measured exponents of force on depth and speed are from .5 to .95 where the model has .6 to .8
FREE_TERM: Mapping[str, float] = {
    "power_factor": 0.25,
    "power_depth_exponent": 0.5,
    "power_speed_exponent": 0.5,
    "power_volume_exponent": 0.25,
}
HEAT = ("material.heat_factor",)  #: further constants that sizes and burn determine, but power does not
#: logarithmic standard deviations of the priors; the share of heat that enters the work is known to a factor 2
SPREADS: Mapping[str, float] = {**USUAL_SPREADS, "material.heat_factor": math.log(2.0)}
OTHER_SPREAD = 0.3  #: logarithmic standard deviation of any other constant, which is fitted only if it is named
#: least and greatest value of a fitted constant, over its value in the catalogue
USUAL_FLOOR, USUAL_CEILING = 0.02, 50.0


@dataclass(frozen=True, slots=True)
class Parameter:
    """Constant to fit."""

    kind: str  #: kind of its entry, such as material
    entry: str  #: name of the entry
    key: str  #: field of the entry
    prior: float  #: value in the catalogue
    spread: float  #: prior standard deviation, of the logarithm or of an exponent itself
    unit: str  #: unit of the value
    low: float  #: least legal value
    high: float  #: greatest legal value

    @property
    def name(self) -> str:
        return f"{self.kind}.{self.key}"

    def value(self, z: float) -> float:
        """Return the value at `z` spreads from the prior."""
        value = self.prior + self.spread * z if self.key in EXPONENTS else self.prior * math.exp(self.spread * z)
        return min(max(value, self.low), self.high)


def chosen_parameters(job: Job, names: Collection[str] | None, beside: Sequence[str] = ()) -> tuple[Parameter, ...]:
    """Return the constants that may be fitted."""
    if names is not None:
        return tuple(_named(job, name) for name in dict.fromkeys(names))
    usual = [name.split(".") for name in (*USUAL, *beside)]
    return tuple(_parameter(job, kind, key) for kind, key in usual if getattr(entries_of(job)[kind], key) > 0.0)


def free_parameters(job: Job) -> tuple[Parameter, ...]:
    """Return the free term as parameters, at its full width."""
    return tuple(_parameter(job, "material", key) for key in FREE_TERM)


def _named(job: Job, name: str) -> Parameter:
    fields = ((kind, *item) for kind in KINDS for item in quantities(KINDS[kind]).items())
    legal = {f"{kind}.{key}": (kind, key) for kind, key, quantity in fields if isinstance(quantity, Quantity)}
    found = [pair for full, pair in legal.items() if name in (full, pair[1])]
    if len(found) > 1:
        preferred = [(kind, key) for kind, key in found if f"{kind}.{key}" in USUAL]
        found = preferred if len(preferred) == 1 else found
    if not found:
        hint = did_you_mean(name, [*legal, *(key for _, key in legal.values())])
        raise CalibrationError(
            f"there is no constant {quoted(name)} to fit{hint}; name fields of the catalogue, such as chip_energy, "
            "wheel.roughness, or auto"
        )
    if len(found) > 1:
        raise CalibrationError(
            f"{name} is a field of {' and '.join(kind for kind, _ in found)}; write {found[0][0]}.{name}"
        )
    (kind, key) = found[0]
    if not getattr(entries_of(job)[kind], key) > 0.0:
        raise CalibrationError(
            f"{kind}.{key} is 0 and cannot be scaled; give it a value above 0 in the catalogue first"
        )
    return _parameter(job, kind, key)


def _parameter(job: Job, kind: str, key: str) -> Parameter:
    spread = FREE_TERM[key] if key in FREE_TERM else SPREADS.get(f"{kind}.{key}", OTHER_SPREAD)
    entry = entries_of(job)[kind]
    quantity, value = quantities(type(entry))[key], getattr(entry, key)
    assert isinstance(quantity, Quantity)
    if key in FREE_TERM:
        return Parameter(kind, entry.name, key, value, spread, quantity.unit, quantity.low, quantity.high)
    least, greatest = entry.ends(key)
    low, high = max(least, USUAL_FLOOR * value), min(greatest, USUAL_CEILING * value)
    return Parameter(kind, entry.name, key, value, spread, quantity.unit, low, high)
