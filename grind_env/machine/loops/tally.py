"""Sums over a run of strokes and dresses: times, peaks, mean powers, burn and wear.

The compiled loops, the run of a program and the episodes of every environment count with these functions.
"""

from typing import NamedTuple

from grind_env.kernel import inlined
from grind_env.kernel.columns import replacer
from grind_env.process.cost import STALL
from grind_env.process.state import StrokeResult

FINISHING_DEPTH = 0.05
"""mm; heat damage done with more than this left to grind is ground off again (scenarios, section 2)."""

RETRACTED = -1000.0
"""mm; depth of a wheel that passes high above the part."""

POWER_WINDOW = 6.0
"""Full plunges over which power is averaged at the start and at the end of a cycle."""


class Tally(NamedTuple):
    """Sums of strokes and dresses, besides the states of wheel and part.

    Powers are the load of the spindle, W above idle. `strokes` and `dresses` are numbers of them.
    `power_2`, `power_3`, `power_4`, `power_5` and `power_6` are W.
    """

    seconds: float
    """Time of strokes and dresses, s."""
    strokes: float
    dresses: float
    first_power: float
    """Sum of the power of the first full plunges (up to six), W."""
    first_count: float
    """How many plunges that sum holds."""
    power_1: float
    """Power of the latest full plunge since the last dress, W; 0 if there is none, like those of the five before it."""
    power_2: float
    power_3: float
    power_4: float
    power_5: float
    power_6: float
    last_count: float
    """How many of these six there are."""
    deepened: float
    """By how much strokes have gone deeper since the last dress, mm."""
    peak_load: float
    """Highest load of a stroke, W."""
    peak_torque: float
    """Ratio of the highest torque of a stroke to that at which the spindle stalls; from 1 on it has."""
    plunge_rise: float
    """Highest temperature rise of a plunge stroke, K."""
    finish_rise: float
    """Highest temperature rise of a plunge stroke that leaves at most `FINISHING_DEPTH` to grind, K."""
    burn_ratio: float
    """Highest burn ratio of a plunge stroke; a spark-out cuts too little for the threshold to mean anything."""
    worn: float
    """Wheel volume worn, mm3."""
    dressed_off: float
    """Wheel volume dressed off, mm3."""


class Plunges(NamedTuple):
    """The latest full plunges alone, for what counts nothing else; fields without a text are those of `Tally`."""

    power_1: float
    power_2: float
    power_3: float
    power_4: float
    power_5: float
    power_6: float
    last_count: float


NOTHING = Tally(*[0.0] * len(Tally._fields))
"""Before the first stroke."""

with_dress = replacer(Tally, "seconds", "dresses", "dressed_off")
without_last = replacer(Tally, *Plunges._fields, "deepened")


@inlined
def has_stalled(tally: Tally) -> bool:
    """Whether the spindle has stalled on this part."""
    return tally.peak_torque >= STALL


@inlined
def wheel_depth(Z: float, tally: Tally) -> float:
    """Depth at which a stroke programmed at `Z` passes, mm: the alarm of a stalled spindle retracts the wheel.

    The part is scrap, and what the program still has for it is made above it (project decision).
    """
    return RETRACTED if has_stalled(tally) else Z


@inlined
def last_power(tally: Tally | Plunges) -> float:
    """Sum of the power of the last full plunges (up to six) since the last dress, oldest first, W."""
    older = tally.power_6 + tally.power_5 + tally.power_4
    return older + tally.power_3 + tally.power_2 + tally.power_1


@inlined
def mean_last_power(tally: Tally | Plunges) -> float:
    """Mean power of the last full plunges since the last dress, W; 0 if there was none."""
    return last_power(tally) / tally.last_count if tally.last_count > 0.0 else 0.0


@inlined
def mean_first_power(tally: Tally) -> float:
    """Mean power of the first full plunges, W; 0 if there was none."""
    return tally.first_power / tally.first_count if tally.first_count > 0.0 else 0.0


@inlined
def count_plunge(tally: Tally | Plunges, power: float, full: bool) -> Plunges:
    """The latest full plunges after a stroke of some power, W, which may be one."""
    power_1 = power if full else tally.power_1
    power_2 = tally.power_1 if full else tally.power_2
    power_3 = tally.power_2 if full else tally.power_3
    power_4 = tally.power_3 if full else tally.power_4
    power_5 = tally.power_4 if full else tally.power_5
    power_6 = tally.power_5 if full else tally.power_6
    last_count = min(tally.last_count + (1.0 if full else 0.0), POWER_WINDOW)
    return Plunges(
        power_1=power_1,
        power_2=power_2,
        power_3=power_3,
        power_4=power_4,
        power_5=power_5,
        power_6=power_6,
        last_count=last_count,
    )


@inlined
def count_stroke(
    tally: Tally,
    stroke: StrokeResult,
    seconds: float,
    deeper: float,
    plunge: bool,
    full: bool,
    finishing: bool,
    stall_time: float,
) -> Tally:
    """Count a stroke.

    Args:
        tally: before it.
        stroke: what it has done.
        seconds: its time.
        deeper: by how much it has gone deeper than any before it, mm; not above 0 if it has not.
        plunge: whether it has gone deeper than any before it at some place of its own.
        full: whether by a full pick.
        finishing: whether it leaves at most `FINISHING_DEPTH` to grind.
        stall_time: time lost if the spindle stalls in it, s.
    """
    # a wheel that a stall has retracted passes above the part: its idling is no power of a plunge
    grinds = tally.peak_torque < STALL
    full_plunge = full & grinds
    among_first = full_plunge & (tally.first_count < POWER_WINDOW)
    # numba takes no condition among so many keywords
    last = count_plunge(tally, stroke.mean_load, full_plunge)
    first_power = tally.first_power + (stroke.mean_load if among_first else 0.0)
    first_count = tally.first_count + (1.0 if among_first else 0.0)
    plunge_rise = max(tally.plunge_rise, stroke.T if plunge else 0.0)
    finish_rise = max(tally.finish_rise, stroke.T if plunge & finishing else 0.0)
    burn_ratio = max(tally.burn_ratio, stroke.burn_ratio if plunge else 0.0)
    lost = stall_time if (stroke.torque >= STALL) & grinds else 0.0
    return Tally(
        seconds=tally.seconds + seconds + lost,
        strokes=tally.strokes + 1.0,
        dresses=tally.dresses,
        first_power=first_power,
        first_count=first_count,
        power_1=last.power_1,
        power_2=last.power_2,
        power_3=last.power_3,
        power_4=last.power_4,
        power_5=last.power_5,
        power_6=last.power_6,
        last_count=last.last_count,
        deepened=tally.deepened + max(deeper, 0.0),
        peak_load=max(tally.peak_load, stroke.load),
        peak_torque=max(tally.peak_torque, stroke.torque),
        plunge_rise=plunge_rise,
        finish_rise=finish_rise,
        burn_ratio=burn_ratio,
        worn=tally.worn + stroke.worn,
        dressed_off=tally.dressed_off,
    )


@inlined
def count_dress(tally: Tally, seconds: float, removed: float) -> Tally:
    """Count a dress execution of some s that took `removed` mm3 off the wheel; the last plunges are counted anew."""
    numbers = tally.seconds + seconds, tally.dresses + 1.0, tally.dressed_off + removed
    return without_last(with_dress(tally, numbers), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
