"""The spindle at its power limit; symbols, units and sources as in the package.

At its power limit a spindle has that power and no more: the wheel slows until what is asked is what there is. The power
of chip formation does not depend on the wheel speed, all other power is proportional to it, so the speed has a closed
form. A wheel slowed to a share `rs` of its speed stalls: there the torque is the largest that the motor has, 1/rs times
the torque of its power limit at the set speed [C].
"""

from grind_env.kernel import inlined

LEAST_POWER = 1e-6
"""W; keeps the quotients of powers numbers."""


@inlined
def slowing(free: float, rubbing: float, rs: float) -> tuple[float, float]:
    """Share of its speed that the wheel keeps in a stroke, at least `rs`, and its inverse.

    Args:
        free: what chip formation leaves of the power limit, W.
        rubbing: power of all but chip formation at the set speed, W.
        rs: share at which it stalls.
    """
    has, asks = max(free, LEAST_POWER), max(rubbing, LEAST_POWER)
    per = 1.0 / (has * asks)
    kept, over = has * has * per, asks * asks * per
    return min(max(kept, rs), 1.0), min(max(over, 1.0), 1.0 / rs)
