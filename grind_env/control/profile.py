"""Motion from rest to rest with linear ramps (PD-21): its progress, and how long it slows down."""

import math


def travelled(elapsed: float, length: float, speed: float, acceleration: float) -> float:
    """Distance covered after `elapsed` s of a motion whose time is `rules.motion_time`.

    Args:
        elapsed: s since the start; before it 0 and after the end `length` is returned.
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
    """Time of the deceleration at the end of such a motion, s."""
    return min(speed, math.sqrt(length * acceleration)) / acceleration
