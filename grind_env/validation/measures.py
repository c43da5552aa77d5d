"""Measurements of checks: a quantity is computed in several set-ups and reduced to one number."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from grind_env.validation.rig import Grinder, Rig
from grind_env.validation.slopes import exponent

Quantity = Callable[[Grinder], float]
MakeWheel = Callable[..., Grinder]
SetUps = Sequence[Mapping[str, Any]]


def single(values: Sequence[float]) -> float:
    """Return the only value."""
    (value,) = values
    return value


def quotient(values: Sequence[float]) -> float:
    """Return the first of two values over the second."""
    first, second = values
    return first / second


@dataclass(frozen=True, slots=True)
class Measurement:
    """A number of the model: a quantity of the wheels of several set-ups, reduced to one number.

    `make` makes each wheel from the rig and the arguments of `SetUp`.
    """

    quantity: Quantity
    setups: SetUps
    reduce: Callable[[list[float]], float]
    make: MakeWheel = Rig.fresh

    def __call__(self, rig: Rig) -> float:
        """Take the number on a rig."""
        return self.reduce([self.quantity(self.make(rig, **setup)) for setup in self.setups])


def value(quantity: Quantity, make: MakeWheel = Rig.sharp, **setup: Any) -> Measurement:
    """Measure a quantity in one set-up."""
    return Measurement(quantity, (setup,), single, make)


def exponent_on(
    name: str, values: Sequence[float], quantity: Quantity, make: MakeWheel = Rig.fresh, **setup: Any
) -> Measurement:
    """Measure the exponent of a quantity on an argument of `SetUp`."""
    return Measurement(quantity, over(name, values, **setup), partial(exponent, values), make)


def over(name: str, values: Sequence[Any], **setup: Any) -> SetUps:
    """Return a set-up for each value of an argument of `SetUp`."""
    return [{**setup, name: each} for each in values]


def changed_over(kind: str, name: str, values: Sequence[float]) -> SetUps:
    """Return a set-up for each value of a field of an entry of the catalogue."""
    return [{"changes": {kind: {name: each}}} for each in values]


def stroke(name: str, number: int = 5) -> Quantity:
    """Return the quantity `name` of a stroke; at the fifth the depth of cut has come up to the downfeed."""
    return lambda grinder: float(getattr(grinder.grind(number), name))


def flats(grinder: Grinder) -> float:
    """Return the wear-flat area, share of the wheel's face."""
    return grinder.wheel.A


def flats_after(volume: float) -> Quantity:
    """Return the quantity wear-flat area, after `volume` mm3/mm more."""

    def later(grinder: Grinder) -> float:
        grinder.grind_volume(volume)
        return flats(grinder)

    return later


def g_over(volume: float) -> Quantity:
    """Return the quantity G-ratio over the next `volume` mm3/mm."""

    def g_ratio(grinder: Grinder) -> float:
        grinder.grind_volume(volume)
        return grinder.g_ratio()

    return g_ratio


def dull(share: float) -> MakeWheel:
    """Make sharp wheels whose wear-flat area is set to `share` of the face."""
    return lambda rig, **setup: rig.dulled(share, **setup)


def used(volume: float) -> MakeWheel:
    """Make wheels that have ground `volume` mm3/mm since the dress."""

    def make(rig: Rig, **setup: Any) -> Grinder:
        grinder = rig.fresh(**setup)
        grinder.grind_volume(volume)
        return grinder

    return make


def sharp_then(rig: Rig, **setup: Any) -> Grinder:
    """Make a wheel sharp in the usual set-up, then put it over a new part in another set-up."""
    return rig.set_up_anew(rig.sharp(), **setup)
