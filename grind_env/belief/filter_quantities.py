"""Hidden quantities of wheel and lot, and how the filter in `wheel_belief.py` reads and estimates them."""

import math
from typing import Any, NamedTuple

from grind_env.kernel import exp, inlined
from grind_env.kernel.row_accessors import column_reader, column_writer

CUT = 1.8  #: standard deviations at which log-normal factors are cut, so that every wheel keeps the limits at some E

#: the factors of a block, each on the stroke parameter of the same name
FACTORS = ("kA", "pm", "hf", "fc", "Gref", "ra_scale")


class Hidden(NamedTuple):
    """Hidden factors of an ensemble member, as standard normal numbers; the scales are a `Hidden` too.

    All fields are numbers with no unit.
    """

    wheel_growth: float
    fracture_force: float
    g_ratio: float
    convection: float
    coolant_ageing: float
    lot_growth: float
    lot_pressure: float


class Signals(NamedTuple):
    """Readings of the filter, in physical units.

    `mean_power`, `first_power` and `peak_power` are W, `diameter` is mm;
    `new_lot` is 1 if the coming part begins a lot.
    """

    mean_power: Any
    first_power: Any
    peak_power: Any
    speed: Any  #: E of the last block, mm/min
    executions: Any  #: D of the last block
    pre_dress: Any  #: 1 if the last block began with a dress
    diameter: Any
    new_lot: Any


class Judged(NamedTuple):
    """Flags and limits by which the filter judges a block."""

    ends_part: float  #: 1 if the block finishes a part
    counts_all: float  #: 1 if heat counts over all plunges
    rise: float  #: limit of the temperature rise, K
    power: float  #: limit of the power, W


class Belief(NamedTuple):
    """Belief of the present wheel and the lot of the coming block, shape (N,) each; spreads are standard deviations."""

    wear_flat: Any  #: mean of the wear-flat area A
    wear_flat_spread: Any
    growth: Any  #: mean log of the dulling rate of lot and wheel
    growth_spread: Any
    pressure: Any  #: mean log of the factor on the wear-flat pressure
    pressure_spread: Any
    burnt: Any  #: probability that the last block burnt the part


#: index of the hidden number of the mounted wheel; each new wheel draws this number
WHEEL = Hidden._fields.index("wheel_growth")
#: index of the first hidden number of the lot; all numbers from this index on belong to the lot
LOT = Hidden._fields.index("lot_growth")

read_signals, read_hidden, write_belief = column_reader(Signals), column_reader(Hidden), column_writer(Belief)
read_judged = column_reader(Judged)


@inlined
def cut(z: float) -> float:
    """Return a standard normal number cut at `CUT`, as episodes draw it."""
    return min(max(z, -CUT), CUT)


@inlined
def log_growth(z: Hidden, sigmas: Hidden) -> float:
    """Return the log of the factor on wear-flat growth."""
    return sigmas.wheel_growth * cut(z.wheel_growth) + sigmas.lot_growth * cut(z.lot_growth)


@inlined
def log_pressure(z: Hidden, sigmas: Hidden) -> float:
    """Return the log of the factor on the wear-flat pressure."""
    return sigmas.lot_pressure * cut(z.lot_pressure)


@inlined
def log_convection(z: Hidden, sigmas: Hidden, ageing: float, parts: float) -> float:
    """Return the log of the factor on the convection; the ageing rate spreads as a uniform draw around `ageing`."""
    rate = ageing * (1.0 + sigmas.coolant_ageing * cut(z.coolant_ageing) / math.sqrt(3.0))
    return sigmas.convection * cut(z.convection) - rate * parts


@inlined
def factors(z: Hidden, sigmas: Hidden, ageing: float, parts: float) -> tuple[float, float, float, float, float, float]:
    """Return the factors of a member in the order of `FACTORS`; that of the roughness is 1: power does not show it."""
    return (
        exp(log_growth(z, sigmas)),
        exp(log_pressure(z, sigmas)),
        exp(log_convection(z, sigmas, ageing, parts)),
        exp(sigmas.fracture_force * cut(z.fracture_force)),
        exp(sigmas.g_ratio * cut(z.g_ratio)),
        1.0,
    )
