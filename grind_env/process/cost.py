"""The cost of a cycle, in $: time, wheel, dresser, and the risk of scrap.

The standard form of labour + wheel + dresser + scrap (Malkin; Rowe; Wen, Tay & Nee 1992).
"""

import math
from typing import NamedTuple

from grind_env.kernel import inlined, logistic
from grind_env.process.equations import LEAST_DIAMETER, dressed_volume, restoration, sharpening_effort
from grind_env.process.stroke_and_dress import dressed_wheel
from grind_env.process.stroke_types import StrokeParameters, WheelState

NO_LIMIT = 0.0  #: roughness limit or tolerance that means no limit

STALL = 1.0  #: ratio of the torque to the stall torque at which the spindle stalls

SCRAP_BELOW = 0.5  #: a part that is good with less than this probability counts as scrap

MOST_HANDOVER_DRESSES = 4.0  #: highest price of a dull wheel at handover, in dress executions


class Rates(NamedTuple):
    """Prices."""

    hourly: float  #: machine and labour, $/h
    wheel: float  #: wheel, $/mm3
    dress: float  #: dresser, $ per execution


class Limits(NamedTuple):
    """Limits of a good part."""

    rise: float  #: highest temperature rise, K
    power: float  #: power limit of the spindle, W above idle; a spindle that needs more slows
    roughness: float  #: highest Ra, um; 0 for none
    size: float  #: tolerance on the size error, um; 0 for none


@inlined
def volume_left(diameter: float, width: float) -> float:
    """Return the wheel volume that is left at a diameter and width (mm), mm3."""
    ring = max(diameter * diameter - LEAST_DIAMETER * LEAST_DIAMETER, 0.0)
    return 0.25 * math.pi * ring * width


@inlined
def expenses(seconds: float, wheel_volume: float, dresses: float, rates: Rates) -> tuple[float, float, float]:
    """Return the costs of time, of wheel volume (worn and dressed off, mm3) and of dress executions, each in $."""
    return rates.hourly * seconds / 3600.0, rates.wheel * wheel_volume, rates.dress * dresses


@inlined
def running_cost(seconds: float, wheel_volume: float, dresses: float, rates: Rates) -> float:
    """Return the sum of the `expenses`, $."""
    time_cost, wheel_cost, dress_cost = expenses(seconds, wheel_volume, dresses, rates)
    return time_cost + wheel_cost + dress_cost


@inlined
def survival(rise: float, torque: float, roughness: float, size_error: float, limits: Limits) -> float:
    """Return the probability that a part with these values is good.

    Each limit is a logistic step: 12 K wide in temperature rise, 2 % in torque, 4 % in roughness and 0.8 um in size. A
    spindle that has stalled leaves no good part.

    Args:
        rise: highest temperature rise that counts, K.
        torque: ratio of the highest torque to the stall torque.
        roughness: Ra, um.
        size_error: stock left, um.
        limits: limits of a good part.
    """
    burn = logistic((rise - limits.rise) / 12.0)
    stall = logistic((torque - STALL) / 0.02) if torque < STALL else 1.0
    ra_limit = limits.roughness if limits.roughness > NO_LIMIT else 1.0
    rough = logistic((roughness / ra_limit - 1.0) / 0.04) if limits.roughness > NO_LIMIT else 0.0
    off_size = logistic((abs(size_error) - limits.size) / 0.8) if limits.size > NO_LIMIT else 0.0
    return (1.0 - burn) * (1.0 - stall) * (1.0 - rough) * (1.0 - off_size)


def passed_limits(rise: float, torque: float, roughness: float, size_error: float, limits: Limits) -> tuple[str, ...]:
    """Return the fields of `limits` that a part with these values exceeds; arguments as for `survival`.

    `power` stands for a spindle that has stalled.
    """
    beyond = {
        "rise": rise > limits.rise,
        "power": torque >= STALL,
        "roughness": NO_LIMIT < limits.roughness < roughness,
        "size": NO_LIMIT < limits.size < abs(size_error),
    }
    return tuple(name for name, is_beyond in beyond.items() if is_beyond)


@inlined
def dress_cost(passes: float, depth: float, seconds: float, ds: float, bs: float, rates: Rates) -> float:
    """Return the cost of one dress execution, $: time, wheel volume dressed off and dresser."""
    return running_cost(seconds, dressed_volume(passes, depth, ds, bs), 1.0, rates)


@inlined
def handover_cost(
    wheel: WheelState, passes: float, lead: float, depth: float, seconds: float, p: StrokeParameters, rates: Rates
) -> float:
    """Return the price of handing over a wheel that is duller than a dressed wheel, $.

    The price is that of the dress executions (a fraction; at most `MOST_HANDOVER_DRESSES`) that bring wear-flat area
    and loading back to within a tenth of a dressed wheel.
    """
    per_dress = restoration(passes, depth, wheel.lam, wheel.A, p.dd)
    effort = sharpening_effort(wheel.A, wheel.lam, dressed_wheel(wheel.ds, wheel.wd, lead, depth, p).A)
    dresses = min(effort / per_dress, MOST_HANDOVER_DRESSES)
    return dresses * dress_cost(passes, depth, seconds, wheel.ds, p.bs, rates)
