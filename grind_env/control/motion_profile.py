"""Motion from rest to rest with linear ramps (PD-21): its progress and its deceleration time."""

import math


def travelled(elapsed: float, length: float, speed: float, acceleration: float) -> float:
    """Return the distance covered after `elapsed` s of a motion that takes `rules.motion_time`, mm.

    Args:
        elapsed: s since the start; the result is 0 before the start and `length` after the end.
        length: mm.
        speed: mm/s, reached only if `length` allows.
        acceleration: mm/s^2.
    """
    peak = min(speed, math.sqrt(length * acceleration))
    if elapsed <= 0.0 or peak == 0.0:
        return 0.0 if elapsed <= 0.0 else length
    ramp = peak / acceleration
    total = length / peak + ramp
    if elapsed >= total:
        return length
    if elapsed < ramp:
        return 0.5 * acceleration * elapsed**2
    if elapsed > total - ramp:
        return length - 0.5 * acceleration * (total - elapsed) ** 2
    return peak * (elapsed - 0.5 * ramp)


def ramp_time(length: float, speed: float, acceleration: float) -> float:
    """Return the time of the deceleration at the end of a motion from rest to rest, s."""
    return min(speed, math.sqrt(length * acceleration)) / acceleration
