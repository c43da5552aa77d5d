"""Roughness of wheel and part; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined, power

INITIAL_ROUGHNESS = 1.6
"""um; Ra of the surface that a part brings to the machine."""


@inlined
def wheel_roughness(Rd: float, V: float, RaRef: float, Vr: float) -> float:
    """Roughness scale of the wheel, um: relaxes from dressed to process-made [C]."""
    return 0.9 * RaRef + (Rd - 0.9 * RaRef) * exp(-V / Vr)


@inlined
def generated_roughness(Rt: float, heq: float, lam: float, alw: float, x: float, cw: float, ra_scale: float) -> float:
    """Roughness Ra that the wheel generates, um [M, C], waviness added in quadrature."""
    Rg = ra_scale * Rt * power(max(heq, 0.01) / 0.1, x) * (1.0 + 0.6 * lam)
    wave = cw * alw
    return math.sqrt(Rg * Rg + wave * wave)


@inlined
def surface_roughness(Rs: float, Rg: float, ae: float) -> float:
    """Roughness after a pass, um: a pass cannot erase a texture deeper than its own depth [C]; ae in mm."""
    return Rs + (Rg - Rs) * (1.0 - exp(-1000.0 * ae / (5.0 * Rs)))
