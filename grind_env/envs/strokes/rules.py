"""The rules of a part that is ground stroke by stroke: how deep each stroke is, and how the program keeps pace.

G81 keeps the table going; while a stroke decelerates, a `G01 Y.. E..` makes the pick and changes the table speed, which
holds from the next stroke on (PD-8). Dwells in between, in whole ms, let the program keep pace with the table. A dress
is the operator's request during that block; the table waits at its reversal point until the dwell is over (22-11).

Plain Python, for the program text; `step` has the same functions compiled. Lengths are mm, times s.
"""

import math
from typing import NamedTuple

from grind_env.control.profile import ramp_time
from grind_env.control.rules import motion_time, picks_to
from grind_env.envs.tasks import PICK_FEED


class TableRun(NamedTuple):
    """How the table goes."""

    length: float
    """Distance between the reversal points, mm."""
    acceleration: float
    """Of all axes, mm/s2."""
    dwell: float
    """At a reversal point, s."""


class Pace(NamedTuple):
    """Where program and table are while a stroke is in progress."""

    clock: float
    """Time of the control since the table set out from rest, s; the program has come so far."""
    began: float
    """Time at which that stroke began, s."""
    speed: float
    """Its E, mm/min."""


class Turn(NamedTuple):
    """What the program does from one stroke to the next."""

    dwell: float
    """Before the pick, s."""
    request: float
    """Dwell in which the operator asks for a dress, s; 0 without one."""
    wait: float
    """Time for which the table waits for the program before the dress, s."""
    pace: Pace
    """In the next stroke."""


def strokes_of(stock: float, pick: float, sparkout: float) -> float:
    """Strokes of a part: its picks, the last one shortened, one at full depth and the spark-out."""
    return picks_to(stock, pick) + 1.0 + sparkout


def depth_of(stroke: float, stock: float, pick: float) -> float:
    """Depth of a stroke of a part, from 0, mm; on the resolution of the control."""
    return math.floor(1000.0 * min((stroke + 1.0) * pick, stock) + 0.5) / 1000.0


def pick_before(stroke: float, stock: float, pick: float) -> float:
    """Depth by which a stroke goes deeper than the one before it, mm; the first one as if from 0."""
    return depth_of(stroke, stock, pick) - (depth_of(stroke - 1.0, stock, pick) if stroke > 0.0 else 0.0)


def stroke_time(table: TableRun, speed: float) -> float:
    """Time of a stroke with its reversal dwell at E `speed` (mm/min), s."""
    return motion_time(table.length, speed / 60.0, table.acceleration) + table.dwell


def setting_out(speed: float) -> Pace:
    """The pace in the first stroke of a part, at E `speed` (mm/min)."""
    return Pace(clock=0.0, began=0.0, speed=speed)


def next_turn(table: TableRun, pace: Pace, pick: float, speed: float, dress: bool) -> Turn:
    """Go down by `pick` for the next stroke at E `speed` (mm/min), after a dress or not."""
    braking = ramp_time(table.length, pace.speed / 60.0, table.acceleration)
    decelerates = pace.began + motion_time(table.length, pace.speed / 60.0, table.acceleration) - braking
    dwell = math.floor(1000.0 * (decelerates - pace.clock)) / 1000.0
    infeed = motion_time(pick, PICK_FEED / 60.0, table.acceleration) if pick > 0.0 else 0.0
    clock = pace.clock + dwell + infeed
    arrives = pace.began + stroke_time(table, pace.speed)
    request = (math.floor(1000.0 * (arrives - clock)) + 2) / 1000.0 if dress else 0.0
    wait = clock + request - arrives if dress else 0.0
    # after a dress the table sets out from rest
    clock = 0.0 if dress else clock
    began = 0.0 if dress else arrives
    return Turn(dwell=dwell, request=request, wait=wait, pace=Pace(clock=clock, began=began, speed=speed))


def last_dwell(table: TableRun, pace: Pace) -> float:
    """Dwell up to the middle of the stroke in progress, after which G80 lets it come to its end, s."""
    middle = pace.began + 0.5 * motion_time(table.length, pace.speed / 60.0, table.acceleration)
    return math.floor(1000.0 * (middle - pace.clock)) / 1000.0
