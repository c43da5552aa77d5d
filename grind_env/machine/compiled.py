"""What `grind` calls of the process model, compiled and cached on disk, so that a run starts at once."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.kernel import entry, inlined
from grind_env.machine import cycle
from grind_env.process import cost, stroke
from grind_env.process.cost import Limits, Rates
from grind_env.process.equations import surface_roughness
from grind_env.process.state import Stroke, StrokeParameters, WheelState

Strips = NDArray[np.float64]
"""One value per strip of the part."""


class Verdict(NamedTuple):
    """What a part has cost, in $, and how likely it is to be good."""

    survival: float
    """Probability that the part is good."""
    time_cost: float
    wheel_cost: float
    dress_cost: float
    scrap_cost: float
    """Expected cost of scrap."""
    total_cost: float


@inlined
def in_cut(u: float, deepest: float) -> bool:
    """Whether a strip with interference `u` takes part in a cut whose deepest interference is given."""
    return (u > 0.5 * deepest) | (deepest <= 0.0)


@entry
def grind_strips(
    wheel: WheelState,
    S: Strips,
    Rs: Strips,
    reached: Strips,
    first: int,
    last: int,
    Z: float,
    vw: float,
    width: float,
    Lw: float,
    p: StrokeParameters,
) -> tuple[WheelState, Stroke, float, bool]:
    """One stroke over the strips `first` to `last - 1` of a part, which the wheel covers.

    The strips with more than half of the deepest interference are cut; the others, ground at this depth
    before, only spark. The cut is that of the mean interference over the joint width, and takes the same
    depth off each.

    Args:
        wheel: state before the stroke.
        S: stock removed, mm; updated.
        Rs: roughness, um; updated.
        reached: deepest Z of a stroke so far, mm; updated.
        first: first strip under the wheel.
        last: the strip after the last one, greater than `first`.
        Z: downfeed position, mm.
        vw: table speed, mm/s.
        width: of the part, all strips together, mm.
        Lw: ground length, mm.
        p: parameters.

    Returns:
        The wheel after the stroke, the stroke, the engaged width in mm, and whether the wheel went deeper
        into a strip than before.
    """
    S_least, Rs_first = np.min(S[first:last]), Rs[first]
    deepest = Z - wheel.W - S_least
    # means as offsets from one strip: exact where all are equal, so that a plunge cut is that of one strip
    engaged, S_offset, Rs_offset = 0, 0.0, 0.0
    for i in range(first, last):
        if in_cut(Z - wheel.W - S[i], deepest):
            engaged += 1
            S_offset += S[i] - S_least
            Rs_offset += Rs[i] - Rs_first
    b = width * (engaged / S.size)
    S_mean, Rs_mean = S_least + S_offset / engaged, Rs_first + Rs_offset / engaged
    after, cut = stroke.grind_stroke(wheel, S_mean, Rs_mean, Z, vw, b, Lw, p)
    plunged = False
    for i in range(first, last):
        plunged = plunged or reached[i] < Z
        if in_cut(Z - wheel.W - S[i], deepest):
            S[i] += cut.ae
            Rs[i] = surface_roughness(Rs[i], cut.Rg, cut.ae)
        reached[i] = max(reached[i], Z)
    return after, cut, b, plunged


@entry
def dress_wheel(
    wheel: WheelState, passes: float, feed: float, depth: float, p: StrokeParameters
) -> tuple[WheelState, float]:
    """One dress execution with a traverse of `feed` mm/s: the wheel after it, and the volume removed, mm3."""
    return stroke.dress_wheel(wheel, passes, cycle.dress_lead(wheel, feed, p), depth, p)


@entry
def dressed_wheel(ds: float, wd: float, lead: float, depth: float, p: StrokeParameters) -> WheelState:
    """A fully dressed wheel; arguments as for `process.stroke.dressed_wheel`."""
    return stroke.dressed_wheel(ds, wd, lead, depth, p)


@entry
def dress_lead(wheel: WheelState, feed: float, p: StrokeParameters) -> float:
    """Dress lead, mm per revolution, of a traverse of `feed` mm/s."""
    return cycle.dress_lead(wheel, feed, p)


@entry
def judge(
    seconds: float,
    wheel_volume: float,
    dresses: float,
    rise: float,
    power: float,
    roughness: float,
    size_error: float,
    limits: Limits,
    rates: Rates,
    scrap_price: float,
) -> Verdict:
    """Cost and survival of a part; arguments as in `process.cost`, `scrap_price` in $."""
    survival = cost.survival(rise, power, roughness, size_error, limits)
    return Verdict(
        survival,
        cost.running_cost(seconds, 0.0, 0.0, rates),
        cost.running_cost(0.0, wheel_volume, 0.0, rates),
        cost.running_cost(0.0, 0.0, dresses, rates),
        scrap_price * (1.0 - survival),
        cost.running_cost(seconds, wheel_volume, dresses, rates) + scrap_price * (1.0 - survival),
    )


@entry
def expenses(seconds: float, wheel_volume: float, dresses: float, rates: Rates) -> tuple[float, float, float]:
    """Costs of time, of wheel volume (worn and dressed off, mm3) and of dress executions, each in $."""
    return (
        cost.running_cost(seconds, 0.0, 0.0, rates),
        cost.running_cost(0.0, wheel_volume, 0.0, rates),
        cost.running_cost(0.0, 0.0, dresses, rates),
    )


@entry
def handover_cost(
    wheel: WheelState, passes: float, feed: float, depth: float, seconds: float, p: StrokeParameters, rates: Rates
) -> float:
    """Price of handing over a wheel duller than a dressed one, $; arguments as for `process.cost.handover_cost`.

    The diamond traverses with `feed` mm/s.
    """
    return cost.handover_cost(wheel, passes, cycle.dress_lead(wheel, feed, p), depth, seconds, p, rates)
