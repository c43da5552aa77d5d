"""What may be fitted: constants of the catalogue, each with the spread that it has before anything was measured."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from grind_env.errors import did_you_mean, quoted
from grind_env.machine.job import Job
from grind_env.process.catalogue import KINDS
from grind_env.process.entries import Entry, Quantity, quantities
from grind_env.shop.calibrate.errors import CalibrationError

SPREADS: Mapping[str, Mapping[str, float]] = {
    "material": {
        "chip_energy": 0.15,
        "ploughing_pressure": math.log(1.5),
        "pressure_factor": 0.2,
        "wear_flat_growth": math.log(2.0),
        "tempering_rise": 0.18,
    },
    "wheel": {"dressed_wear_flat": 0.3, "g_ratio": math.log(2.0), "roughness": 0.25},
    "machine": {"stiffness": 0.4},
}
"""Logarithmic standard deviations before measuring, by kind and field: what the sources of the catalogue are uncertain
by
(`catalogue_data/*.toml`), and how machines and wheels of one name differ."""
FREE_TERM: Mapping[str, float] = {
    "power_factor": 0.25,
    "power_depth_exponent": 0.5,
    "power_speed_exponent": 0.5,
    "power_volume_exponent": 0.25,
}
"""Fields of a material that follow what the model does not, with their full standard deviation, of the factor
logarithmic: measured exponents of force on depth and speed are from .5 to .95 where the model has .6 to .8."""
OTHER_SPREAD = 0.3
"""Of a field that is fitted only because it is named."""
USUAL_FLOOR, USUAL_CEILING = 0.02, 50.0
"""Over the value of the catalogue: no constant is fitted beyond."""

CLOSEST = 0.99
"""Share of a field that another one, which must be less, may come to."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A constant that is fitted.

    Attributes:
        kind: of its entry, such as material.
        entry: name of that.
        key: field of it.
        prior: value in the catalogue.
        spread: standard deviation around it before measuring, logarithmic, or of an exponent itself.
        unit: of the value.
        low: least legal value.
        high: greatest one.
    """

    kind: str
    entry: str
    key: str
    prior: float
    spread: float
    unit: str
    low: float
    high: float

    @property
    def name(self) -> str:
        """`wheel.roughness`."""
        return f"{self.kind}.{self.key}"

    def value(self, z: float) -> float:
        """Value at so many spreads from the prior."""
        value = self.prior + self.spread * z if self.is_exponent else self.prior * math.exp(self.spread * z)
        return min(max(value, self.low), self.high)

    @property
    def is_exponent(self) -> bool:
        """Whether it is one of the free term, which may be 0 or less."""
        return self.key.endswith("_exponent") and self.key in FREE_TERM


def entries_of(job: Job) -> Mapping[str, Entry]:
    """The entries of the catalogue that a job works with, by kind."""
    setup = job.setup
    return {
        "material": job.part.material,
        "wheel": setup.wheel,
        "dresser": setup.dresser,
        "fluid": setup.fluid,
        "machine": setup.machine,
    }


def with_entries(job: Job, changes: Mapping[str, Mapping[str, float]]) -> Job:
    """A job with fields of its entries changed, by kind; the wheel stays as large as the job has it.

    At stations with another material than that of the first one this stays as it is.
    """
    changed = {kind: _changed(entry, changes.get(kind, {})) for kind, entry in entries_of(job).items()}
    return replace(
        job,
        part=replace(job.part, material=changed["material"]),
        stations=tuple(
            replace(each, part=replace(each.part, material=changed["material"]))
            if each.part.material == job.part.material
            else each
            for each in job.stations
        ),
        setup=replace(job.setup, **{kind: entry for kind, entry in changed.items() if kind != "material"}),
    )


def _changed(entry: Any, values: Mapping[str, float]) -> Any:
    return replace(entry, **values)


def chosen_parameters(
    job: Job, names: Collection[str] | None, beside: Sequence[tuple[str, str]] = ()
) -> tuple[Parameter, ...]:
    """The constants that may be fitted.

    Args:
        job: whose entries.
        names: of constants, such as `chip_energy` and `wheel.roughness`; None for the usual ones.
        beside: kinds and keys that are usual, too.

    Raises:
        CalibrationError: no entry has such a field, several have it, or it is 0 and cannot be scaled.
    """
    if names is not None:
        return tuple(_named(job, name) for name in dict.fromkeys(names))
    usual = [(kind, key) for kind, spreads in SPREADS.items() for key in spreads]
    return tuple(
        _parameter(job, kind, key) for kind, key in (*usual, *beside) if getattr(entries_of(job)[kind], key) > 0.0
    )


def free_parameters(job: Job, *, exponents: bool = True) -> tuple[Parameter, ...]:
    """The free term as parameters, at its full width; without `exponents` only its factor."""
    keys = [key for key in FREE_TERM if exponents or not key.endswith("_exponent")]
    return tuple(_parameter(job, "material", key) for key in keys)


def _named(job: Job, name: str) -> Parameter:
    legal = {f"{kind}.{key}": (kind, key) for kind in KINDS for key in _fields(kind)}
    found = [pair for full, pair in legal.items() if name in (full, pair[1])]
    if len(found) > 1:
        preferred = [(kind, key) for kind, key in found if key in SPREADS.get(kind, {})]
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


def _fields(kind: str) -> list[str]:
    return [key for key, quantity in quantities(KINDS[kind]).items() if isinstance(quantity, Quantity)]


def _parameter(job: Job, kind: str, key: str) -> Parameter:
    """A field of an entry of a job as a parameter."""
    spread = {**SPREADS, "material": {**SPREADS["material"], **FREE_TERM}}.get(kind, {}).get(key, OTHER_SPREAD)
    entry = entries_of(job)[kind]
    quantity, value = quantities(type(entry))[key], getattr(entry, key)
    assert isinstance(quantity, Quantity)
    if key in FREE_TERM:
        return Parameter(kind, entry.name, key, value, spread, quantity.unit, quantity.low, quantity.high)
    low, high = max(quantity.low, USUAL_FLOOR * value), min(quantity.high, USUAL_CEILING * value)
    for lesser, greater in type(entry).ASCENDING:
        low = max(low, getattr(entry, lesser) / CLOSEST) if key == greater else low
        high = min(high, getattr(entry, greater) * CLOSEST) if key == lesser else high
    return Parameter(kind, entry.name, key, value, spread, quantity.unit, low, high)
