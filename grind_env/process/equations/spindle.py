"""The spindle at its power limit; symbols, units and sources as in the package.

A spindle cannot exceed its power limit: the wheel slows until the power needed equals the limit. The power of chip
formation does not depend on the wheel speed, and all other power is proportional to the speed, so the speed has a
closed form. A wheel that slows to the share `rs` of its speed stalls. There the motor gives its largest torque, 1/rs
times the torque of the power limit at the set speed [C].
"""

from grind_env.kernel import inlined

LEAST_POWER = 1e-6  #: least power in a quotient, W, so that the quotient is a number


@inlined
def slowing(free: float, rubbing: float, rs: float) -> tuple[float, float]:
    """Return the share of its speed that the wheel keeps in a stroke, at least `rs`, and the inverse of this share.

    Args:
        free: power limit less the power of chip formation, W.
        rubbing: power of all but chip formation at the set speed, W.
        rs: share of the wheel speed at which the spindle stalls.
    """
    has, asks = max(free, LEAST_POWER), max(rubbing, LEAST_POWER)
    per = 1.0 / (has * asks)
    kept, over = has * has * per, asks * asks * per
    return min(max(kept, rs), 1.0), min(max(over, 1.0), 1.0 / rs)
