"""One G82 cycle, stroke by stroke: the rules of the control and the process model joined.

`advance` runs one stroke and the reversal that ends it, `dress` one dress execution. The scalar loop of `batch.py`
and the block kernel of `lanes.py` are made of these two; `run.py` applies the same rules and the same physics to one
event of the interpreter at a time.
"""

import math
from typing import NamedTuple

import numpy as np

from grind_env.control.cycles.plunge import PlungeCycle, PlungeProgress
from grind_env.control.rules import DEPTH_TOLERANCE, PICK_TOLERANCE
from grind_env.kernel import inlined
from grind_env.machine.rules import after_reversal, begin_plunge, plunge_finished
from grind_env.process.equations import wheel_speed
from grind_env.process.state import Stroke, StrokeParameters, WheelState
from grind_env.process.stroke import dress_wheel, grind_stroke

FINISHING_DEPTH = 0.05
"""mm; heat damage done with more than this left to grind is ground off again (scenarios, section 2)."""

POWER_WINDOW = 6.0
"""Full plunges over which power is averaged at the start and at the end of a cycle."""


class Cycle(NamedTuple):
    """A G82 cycle block as the kernel sees it. Depths are mm from the touched-off surface, into the part."""

    speed: float
    """Table speed E/60, mm/s."""
    first_seconds: float
    """Time of the first stroke, from the start point to the primary point, s."""
    stroke_seconds: float
    """Time of every other stroke, s."""
    start: float
    """Depth at which the wheel stands when the cycle begins, mm."""
    target: float
    """Depth Y, mm."""
    primary_pick: float
    """J, mm."""
    secondary_pick: float
    """Q, mm."""
    sparkout: float
    """L, strokes."""
    coverage: float
    """1 if a coverage stroke precedes the spark-out strokes (PD-13), else 0."""
    executions: float
    """D."""
    pre_dress: float
    """1 for G82.1, else 0."""
    width: float
    """Engaged width b, mm."""
    length: float
    """Ground length Lw, mm."""
    dress_passes: float
    """Diamond passes of one execution."""
    dress_feed: float
    """Traverse feed of the diamond, mm/s."""
    dress_depth: float
    """Depth of each pass, mm."""
    dress_seconds: float
    """Time of one execution with set-up, approach and retrace, s."""


class PartState(NamedTuple):
    """The surface under the wheel."""

    Z: float
    """Depth at which the wheel made its last stroke, mm."""
    S: float
    """Stock removed, mm."""
    Rs: float
    """Roughness Ra, um."""


class Ahead(NamedTuple):
    """What is known of the rest of a cycle."""

    full_plunges: float
    """Full plunges still to come."""


class CycleResult(NamedTuple):
    """What a cycle leaves behind, besides the states of wheel and part."""

    seconds: float
    """Time of strokes and dresses, s."""
    strokes: float
    dresses: float
    first_power: float
    """Sum of the power of the first full plunges (up to six), W."""
    first_count: float
    """How many plunges that sum holds."""
    last_power: float
    """Sum of the power of the last full plunges (up to six) since the last dress, W."""
    last_count: float
    """How many plunges that sum holds."""
    peak_power: float
    """Highest power of a stroke, W above idle."""
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


@inlined
def plunge_of(cycle: Cycle) -> PlungeCycle:
    """The cycle as the rules of the control have it."""
    return PlungeCycle(
        depth=cycle.target - cycle.start,
        primary_pick=cycle.primary_pick,
        secondary_pick=cycle.secondary_pick,
        at_depth=cycle.coverage + cycle.sparkout,
        executions=cycle.executions,
        pre_dress=cycle.pre_dress,
    )


@inlined
def begin(cycle: Cycle, part: PartState) -> tuple[PlungeProgress, Ahead, CycleResult]:
    """State of control and result at the start of a cycle."""
    full = max(np.floor((cycle.target - part.Z) / full_pick(cycle) + PICK_TOLERANCE), 0.0)
    result = CycleResult(
        seconds=0.0,
        strokes=0.0,
        dresses=0.0,
        first_power=0.0,
        first_count=0.0,
        last_power=0.0,
        last_count=0.0,
        peak_power=0.0,
        plunge_rise=0.0,
        finish_rise=0.0,
        burn_ratio=0.0,
        worn=0.0,
        dressed_off=0.0,
    )
    return begin_plunge(plunge_of(cycle)), Ahead(full_plunges=full), result


@inlined
def full_pick(cycle: Cycle) -> float:
    """The plunge that counts as a full one when power is averaged, mm."""
    return max(cycle.primary_pick, cycle.secondary_pick)


@inlined
def finished(cycle: Cycle, progress: PlungeProgress) -> bool:
    """Whether the cycle has made its last stroke."""
    return plunge_finished(plunge_of(cycle), progress)


@inlined
def advance(
    cycle: Cycle,
    progress: PlungeProgress,
    ahead: Ahead,
    wheel: WheelState,
    part: PartState,
    result: CycleResult,
    p: StrokeParameters,
) -> tuple[PlungeProgress, Ahead, WheelState, PartState, CycleResult, Stroke]:
    """One stroke, and the pick and the dresses that fall due at the reversal which ends it."""
    Z = cycle.start + progress.depth
    wheel, stroke = grind_stroke(wheel, part.S, part.Rs, Z, cycle.speed, cycle.width, cycle.length, p)

    plunge = Z > part.Z
    full = full_pick(cycle) - DEPTH_TOLERANCE <= Z - part.Z
    among_first = full & (result.first_count < POWER_WINDOW)
    among_last = full & (ahead.full_plunges <= POWER_WINDOW)
    finishing = plunge & (cycle.target - Z <= FINISHING_DEPTH + DEPTH_TOLERANCE)
    result = CycleResult(
        seconds=result.seconds + (cycle.stroke_seconds if progress.reversal > 0.0 else cycle.first_seconds),
        strokes=result.strokes + 1.0,
        dresses=result.dresses,
        first_power=result.first_power + (stroke.power if among_first else 0.0),
        first_count=result.first_count + (1.0 if among_first else 0.0),
        last_power=result.last_power + (stroke.power if among_last else 0.0),
        last_count=result.last_count + (1.0 if among_last else 0.0),
        peak_power=max(result.peak_power, stroke.power),
        plunge_rise=max(result.plunge_rise, stroke.T if plunge else 0.0),
        finish_rise=max(result.finish_rise, stroke.T if finishing else 0.0),
        burn_ratio=max(result.burn_ratio, stroke.Br if plunge else 0.0),
        worn=result.worn + stroke.worn,
        dressed_off=result.dressed_off,
    )
    progress = after_reversal(plunge_of(cycle), progress)
    ahead = Ahead(full_plunges=ahead.full_plunges - (1.0 if full else 0.0))
    return progress, ahead, wheel, PartState(Z=Z, S=part.S + stroke.ae, Rs=stroke.Ra), result, stroke


@inlined
def dress_lead(wheel: WheelState, feed: float, p: StrokeParameters) -> float:
    """Dress lead, mm per wheel revolution, of a diamond that traverses with `feed` mm/s."""
    return feed * math.pi * wheel.ds / (1000.0 * wheel_speed(wheel.ds, p.n, p.vs_set))


@inlined
def dress(cycle: Cycle, wheel: WheelState, result: CycleResult, p: StrokeParameters) -> tuple[WheelState, CycleResult]:
    """One dress execution within a cycle; the sums for the mean power of the last plunges start again from 0."""
    lead = dress_lead(wheel, cycle.dress_feed, p)
    wheel, removed = dress_wheel(wheel, cycle.dress_passes, lead, cycle.dress_depth, p)
    result = CycleResult(
        seconds=result.seconds + cycle.dress_seconds,
        strokes=result.strokes,
        dresses=result.dresses + 1.0,
        first_power=result.first_power,
        first_count=result.first_count,
        last_power=0.0,
        last_count=0.0,
        peak_power=result.peak_power,
        plunge_rise=result.plunge_rise,
        finish_rise=result.finish_rise,
        burn_ratio=result.burn_ratio,
        worn=result.worn,
        dressed_off=result.dressed_off + removed,
    )
    return wheel, result
