"""What a run warns of: programs that the control accepts, but that grind otherwise than they seem (PD-6)."""

import math

from grind_env.control import Control, Pick, Stroke
from grind_env.control.profile import ramp_time


def middle_time(stroke: Stroke, control: Control) -> float:
    """Time at which the table passes the middle of a stroke, s; its reversal dwell comes after the stroke."""
    return stroke.begin + 0.5 * (stroke.seconds - control.reversal_dwell)


def slow_pick(pick: Pick, stroke: Stroke, control: Control) -> str:
    """What to do about a pick that is still under way in the middle of the stroke after it.

    Args:
        pick: the pick.
        stroke: any full stroke of the same cycle.
        control: settings of the control.
    """
    dwell = control.reversal_dwell
    length = abs(stroke.end[stroke.axis] - stroke.start[stroke.axis])
    ramp = ramp_time(length, stroke.feed / 60.0, control.acceleration)
    window = ramp + dwell + 0.5 * (stroke.seconds - dwell)
    feed = feed_for(math.dist(pick.start, pick.end), window, control.acceleration)
    found = (
        f"its picks at F{pick.feed:g} mm/min take {pick.seconds:.2f} s and are not finished in the middle of "
        f"the next stroke, which is {window:.2f} s later, so that a part of each is ground one stroke later"
    )
    if feed is None:
        return f"{found}; no F would do, so give a lower E or a smaller pick"
    return f"{found}; F{math.ceil(feed):d} would do"


def feed_for(length: float, seconds: float, acceleration: float) -> float | None:
    """The least feed, mm/min, that covers `length` mm from rest to rest in that time; None if none does."""
    # length/v + v/acceleration = seconds, the inverse of rules.motion_time
    half = 0.5 * acceleration * seconds
    rest = half * half - acceleration * length
    return 60.0 * acceleration * length / (half + math.sqrt(rest)) if rest >= 0.0 else None


def short_stroke(coordinate: float, axis: str, low: float, high: float) -> str:
    """What to say about a reversal point over the part."""
    return (
        f"a stroke turns at {axis}{coordinate:g}, over the part, which lies from {axis}{low:g} to "
        f"{axis}{high:g}; set the reversal points beyond it"
    )
