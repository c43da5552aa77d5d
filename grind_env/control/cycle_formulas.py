"""The cycle rules of the control as scalar functions.

Each rule exists only here. The interpreter and the rules of `cycles` call them as plain Python, one stroke at a time;
`machine.loops.compiled_motion` holds them compiled for the batched kernel.
Lengths are mm, speeds mm/s, accelerations mm/s^2, times s. Depths count from the start of the plunge, positive
towards the part. Sources are pages of manual 8520-GUM; PD-n is a decision of this project.
"""

import math

import numpy as np

#: mm; depths are sums of decimal picks, so that equality needs a tolerance far below the control's 0.1 um
DEPTH_TOLERANCE = 1e-9

PICK_TOLERANCE = 1e-6  #: share of a pick by which a depth may exceed a whole number of picks, because of rounding

INSTANT = 1e-9  #: s; sums of times that differ by less are the same moment


def motion_time(length: float, speed: float, acceleration: float) -> float:
    """Return the time of a motion from rest to rest, s: trapezoidal, or triangular below `speed` (PD-21)."""
    return (
        length / speed + speed / acceleration
        if length >= speed * speed / acceleration
        else 2.0 * math.sqrt(length / acceleration)
    )


def pick_begin(stroke: float, travel: float, ramp: float, picked: float) -> float:
    """Return when the pick at the end of a stroke begins, s: as the table decelerates (PD-22), after the last pick.

    Args:
        stroke: begin of the stroke, s.
        travel: duration of the stroke, s.
        ramp: duration of the deceleration at its end, s.
        picked: end of the last pick before, s; -inf if there is none.
    """
    return max(stroke + travel - ramp, picked)


def pick_window(ramp: float, dwell: float, travel: float) -> float:
    """Return the time from the begin of a pick to the middle of the next stroke, s; the pick must end within it.

    Args:
        ramp: duration of the deceleration at the end of the stroke before, s.
        dwell: dwell at the reversal, s.
        travel: duration of the stroke after the pick, s.
    """
    return ramp + dwell + 0.5 * travel


def picks_to(depth: float, pick: float) -> int:
    """Return the number of picks to a depth, the last one perhaps shorter; both mm."""
    return math.ceil(depth / pick - PICK_TOLERANCE)


def least_picks(depth: float, primary_pick: float, secondary_pick: float) -> int:
    """Return the least number of alternating picks to a depth, all mm: as if each were the larger one."""
    return picks_to(depth, max(primary_pick, secondary_pick)) if depth > 0.0 else 0


def depth_after_pick(reversal: float, depth: float, total: float, primary_pick: float, secondary_pick: float) -> float:
    """Return the depth after the plunge pick at a reversal, mm: J at the primary, Q at the secondary point (16-16).

    The first reversal of a cycle is at the primary point (16-16). The last pick is shortened so that it lands
    exactly on `total` (PD-12). A pick of 0 is legal at the secondary point and leaves the depth as it is.

    Args:
        reversal: number of the reversal point since the cycle began, 1 being the first arrival at the primary.
        depth: depth before the pick, mm.
        total: depth of the cycle, mm.
        primary_pick: J, mm.
        secondary_pick: Q, mm.
    """
    at_primary = reversal - 2.0 * np.floor(0.5 * reversal) == 1.0
    pick = primary_pick if at_primary else secondary_pick
    return total if (pick > 0.0) & (total - depth <= pick + DEPTH_TOLERANCE) else depth + pick


def dresses_due(depth: float, total: float, executions: float) -> float:
    """Return the number of auto-dresses that must have run once `depth` of `total` is reached (16-13, PD-10).

    They are spread evenly over the depth: exactly `executions` at full depth, none if the cycle has no depth.
    """
    share = depth * (executions + 1.0) / (total if total > 0.0 else 1.0)
    return min(executions, float(np.floor(share + 1e-9))) if total > 0.0 else 0.0
