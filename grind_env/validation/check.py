"""A check: one number of the process model, its band, the source of the band, and its result."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from grind_env.errors import GrindError
from grind_env.evidence import Basis, Evidence
from grind_env.validation.rig import Rig, Violation

#: subjects of the checks, by number of the group. Groups 1 to 9 are trends that the model has to show
GROUPS = {
    1: "Dress depth and lead",
    2: "Rotary dressers",
    3: "Grit size, structure and grade",
    4: "Fluid",
    5: "Spark-out and threshold force",
    6: "Roughness",
    7: "Wear and G-ratio",
    8: "Heat, boiling and the heat of the part",
    9: "Spindle",
    10: "Measured, published and remembered numbers",
}


Measure = Callable[[Rig], float]
TREND = Basis(Evidence.OWN, "expected trend")  #: basis of a band that is the judgement of this project alone


@dataclass(frozen=True, slots=True)
class Band:
    """Range of right values, from `low` to `high`, both included, in the unit of the check."""

    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Return whether a value lies in the band; False for NaN."""
        return self.low <= value <= self.high

    def __str__(self) -> str:
        """Return the band: `0.4 to 0.7`, or one-sided `at most 0.15`."""
        if math.isinf(self.low):
            return f"at most {self.high:g}"
        if math.isinf(self.high):
            return f"at least {self.low:g}"
        return f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"


def band_of(text: str) -> Band:
    """Return the band of a text such as `str` of a band."""
    low, _, high = text.partition(" to ")
    if text.startswith("at "):
        end = float(text.split()[-1])
        return Band(end, math.inf) if text.startswith("at least") else Band(-math.inf, end)
    return Band(float(low), float(high or low))


@dataclass(frozen=True, slots=True)
class Check:
    """Check of the model."""

    name: str  #: unique name, used by known failures
    group: int  #: a key of `GROUPS`
    what: str  #: name of the number in reports
    at: str  #: conditions of the number
    band: Band  #: range of right values
    measure: Measure  #: function that computes the number; raises a `GrindError` if the catalogue lacks an entry
    unit: str = ""  #: unit of the number; "" without one
    reference: float | None = None  #: measured, published or remembered number, in `unit`, if it is one number
    basis: Basis = TREND  #: source of the reference or of the band


@dataclass(frozen=True, slots=True)
class Row:
    """A check with its number."""

    check: Check  #: the check
    value: float  #: number of the model, in the unit of the check; NaN for none
    missing: str = ""  #: reason for a missing number
    outside: tuple[Violation, ...] = ()  #: conditions beyond the limits of the catalogue

    @property
    def passed(self) -> bool:
        """Return whether the number lies within the band."""
        return self.check.band.holds(self.value)


def row_of(check: Check, rig: Rig) -> Row:
    """Return a check with the number of the model."""
    own = replace(rig, outside={})
    value, missing = math.nan, ""
    try:
        value = float(check.measure(own))
    except (GrindError, ArithmeticError) as error:
        missing = str(error)
    return Row(check, value, missing, tuple(own.outside.values()))
