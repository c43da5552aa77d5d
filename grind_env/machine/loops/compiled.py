"""Entry points to the process model for `machine.grind`: compiled and cached on disk."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.kernel import entry
from grind_env.kernel.columns import column_reader, column_writer
from grind_env.machine.loops import cycle, tally
from grind_env.machine.loops.tally import Tally
from grind_env.process import cost
from grind_env.process.cost import Limits, Rates
from grind_env.process.process import Process
from grind_env.process.state import StrokeParameters, StrokeResult, WheelState


class PartVerdict(NamedTuple):
    """What a part has cost, in $, and how likely it is to be good."""

    survival: float
    """Probability that the part is good."""
    time_cost: float
    wheel_cost: float
    dress_cost: float
    scrap_cost: float
    """Expected cost of scrap."""
    total_cost: float


@entry
def count_stroke(before: Tally, done: StrokeResult, seconds: float, plunge: bool, stall_time: float) -> Tally:
    """A tally with one more stroke; `plunge` says whether it has gone deeper than any before it."""
    return tally.count_stroke(before, done, seconds, 0.0, plunge, False, False, stall_time)


@functools.cache
def dress_of(process: Process) -> Callable[..., tuple[WheelState, float]]:
    """Compiled `dress(wheel, own, passes, feed, depth, p)`: one dress execution with a traverse of `feed` mm/s.

    It gives the wheel after it and the volume removed, mm3, and updates `own`, shape (1, fields of the process's).
    """
    dress_wheel, read_own, write_own = process.dress, column_reader(process.own), column_writer(process.own)

    @entry
    def dress(
        wheel: WheelState, own: Any, passes: float, feed: float, depth: float, p: StrokeParameters
    ) -> tuple[WheelState, float]:
        lead = cycle.dress_lead(wheel, feed, p)
        wheel, left, removed = dress_wheel(wheel, read_own(own, 0), passes, lead, depth, p)
        write_own(own, 0, left)
        return wheel, removed

    return dress


def judge(
    seconds: float,
    wheel_volume: float,
    dresses: float,
    rise: float,
    torque: float,
    roughness: float,
    size_error: float,
    limits: Limits,
    rates: Rates,
    scrap_price: float,
    earlier: float,
) -> PartVerdict:
    """Cost and survival of a part.

    Arguments as in `process.cost`; `scrap_price` in $, `earlier` the probability that it was good in its stages before.
    """
    survival = earlier * cost.survival(rise, torque, roughness, size_error, limits)
    time_cost, wheel_cost, dress_cost = cost.expenses(seconds, wheel_volume, dresses, rates)
    scrap_cost = scrap_price * (1.0 - survival)
    total_cost = time_cost + wheel_cost + dress_cost + scrap_cost
    return PartVerdict(survival, time_cost, wheel_cost, dress_cost, scrap_cost, total_cost)
