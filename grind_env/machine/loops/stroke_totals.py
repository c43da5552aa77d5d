"""Sums over a run of strokes and dresses: times, peaks, mean powers, burn and wear.

The compiled loops, the run of a program and the episodes of every environment count with these functions.
"""

from typing import NamedTuple

from grind_env.kernel import inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.process.cost import STALL
from grind_env.process.stroke_types import StrokeResult

FINISHING_DEPTH = 0.05  #: stock, mm; heat damage done with more than this left to grind is ground off again

RETRACTED = -1000.0  #: depth of a retracted wheel, which passes high above the part, mm

POWER_WINDOW = 6.0  #: number of full plunges over which power is averaged at the start and at the end of a cycle


class Tally(NamedTuple):
    """Sums of strokes and dresses, besides the states of wheel and part.

    Powers are the load of the spindle, W above idle. `strokes` and `dresses` are numbers of strokes and dresses.
    `power_2`, `power_3`, `power_4`, `power_5` and `power_6` are W.
    """

    seconds: float  #: time of strokes and dresses, s
    strokes: float
    dresses: float
    first_power: float  #: sum of the power of the first full plunges (up to six), W
    first_count: float  #: number of plunges in `first_power`
    #: power of the latest full plunge since the last dress, W; the next fields are of the five before; 0 if none
    power_1: float
    power_2: float
    power_3: float
    power_4: float
    power_5: float
    power_6: float
    last_count: float  #: number of full plunges in `power_1` to `power_6`
    deepened: float  #: total gain in depth by strokes since the last dress, mm
    peak_load: float  #: highest load of a stroke, W
    #: ratio of the highest torque of a stroke to the stall torque; from 1 on the spindle has stalled
    peak_torque: float
    plunge_rise: float  #: highest temperature rise of a plunge stroke, K
    finish_rise: float  #: highest temperature rise of a plunge stroke that leaves at most `FINISHING_DEPTH` to grind, K
    #: highest burn ratio of a plunge stroke; a spark-out cuts too little for the threshold to mean anything
    burn_ratio: float
    worn: float  #: wheel volume worn, mm3
    dressed_off: float  #: wheel volume dressed off, mm3


class Plunges(NamedTuple):
    """The latest full plunges alone, without the other sums; fields without a text are those of `Tally`."""

    power_1: float
    power_2: float
    power_3: float
    power_4: float
    power_5: float
    power_6: float
    last_count: float


NOTHING = Tally(*[0.0] * len(Tally._fields))  #: tally before the first stroke

with_dress = replacer(Tally, "seconds", "dresses", "dressed_off")
without_last = replacer(Tally, *Plunges._fields, "deepened")


@inlined
def has_stalled(tally: Tally) -> bool:
    """Return whether the spindle has stalled on this part."""
    return tally.peak_torque >= STALL


@inlined
def wheel_depth(Z: float, tally: Tally) -> float:
    """Return the depth at which a stroke programmed at `Z` passes, mm: a stall alarm retracts the wheel.

    The part is then scrap, and the rest of its program runs above it (project decision).
    """
    return RETRACTED if has_stalled(tally) else Z


@inlined
def last_power(tally: Tally | Plunges) -> float:
    """Return the sum of the power of the last full plunges (up to six) since the last dress, oldest first, W."""
    older = tally.power_6 + tally.power_5 + tally.power_4
    return older + tally.power_3 + tally.power_2 + tally.power_1


@inlined
def mean_last_power(tally: Tally | Plunges) -> float:
    """Return the mean power of the last full plunges since the last dress, W; 0 if there was none."""
    return last_power(tally) / tally.last_count if tally.last_count > 0.0 else 0.0


@inlined
def mean_first_power(tally: Tally) -> float:
    """Return the mean power of the first full plunges, W; 0 if there was none."""
    return tally.first_power / tally.first_count if tally.first_count > 0.0 else 0.0


@inlined
def count_plunge(tally: Tally | Plunges, power: float, full: bool) -> Plunges:
    """Return the latest full plunges after a stroke of this power, W, which counts if it is `full`."""
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
    """Return the tally with a stroke added.

    Args:
        tally: tally before the stroke.
        stroke: results of the stroke.
        seconds: time of the stroke, s.
        deeper: gain in depth over all strokes before, mm; 0 or less without a gain.
        plunge: whether the stroke is deeper than all strokes before at some place.
        full: whether the stroke is a full plunge.
        finishing: whether the stroke leaves at most `FINISHING_DEPTH` to grind.
        stall_time: time lost if the spindle stalls in the stroke, s.
    """
    # after a stall the retracted wheel passes above the part: its idle power is no power of a plunge
    grinds = tally.peak_torque < STALL
    full_plunge = full & grinds
    among_first = full_plunge & (tally.first_count < POWER_WINDOW)
    # numba cannot compile conditions among so many keywords
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
    """Return the tally with a dress of `seconds`, s, and `removed`, mm3, added and without the last plunges."""
    numbers = tally.seconds + seconds, tally.dresses + 1.0, tally.dressed_off + removed
    return without_last(with_dress(tally, numbers), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
