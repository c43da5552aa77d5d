"""What a run warns of: programs that the control accepts, but that grind otherwise than they seem (PD-6)."""

import math

from grind_env.control import Control, Pick, Stroke
from grind_env.control.profile import ramp_time

TABLE_SPEEDS = (3000.0, 40_000.0)
"""mm/min; table speeds for which the process model holds (model.md, kinematics)."""

DEEPEST_CUT = 0.1
"""mm; deeper is creep feed, for which it does not hold (model.md, section 13)."""


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


def outside_model(feed: float, depth: float) -> str | None:
    """What to say about a cut beyond the limits of validity of the process model; None within them.

    Args:
        feed: E, mm/min.
        depth: real depth of cut, mm; 0 if the stroke does not cut.
    """
    low, high = TABLE_SPEEDS
    if depth > 0.0 and not low <= feed <= high:
        return f"a stroke cuts at E{feed:g} mm/min; the process model holds from {low:g} to {high:g} mm/min"
    if depth > DEEPEST_CUT:
        return f"a stroke cuts {depth:.2f} mm deep; the process model holds up to {DEEPEST_CUT:g} mm"
    return None


def short_stroke(coordinate: float, axis: str, low: float, high: float) -> str:
    """What to say about a reversal point over the part."""
    return (
        f"a stroke turns at {axis}{coordinate:g}, over the part, which lies from {axis}{low:g} to "
        f"{axis}{high:g}; set the reversal points beyond it"
    )
