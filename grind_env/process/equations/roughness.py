"""Roughness of wheel and part; symbols, units and sources as in the package."""

import math

from grind_env.kernel import inlined

INITIAL_ROUGHNESS = 1.6
"""um; Ra of the surface that a part brings to the machine."""
SETTLED_ROUGHNESS = 0.9
"""Roughness scale of a wheel that has ground for a while, over that of the reference dress [C]."""
REFERENCE_SPEED, REFERENCE_RATE = 30.0, 3.0
"""m/s and mm2/s; of the terms below."""
PEAK_DEPTH = 0.5
"""um; what a pass of no depth still takes off the peaks [C]."""
TEXTURE_SHARE = 2.0
"""Depth in units of Ra at which a pass replaces half of the texture before it [C]."""


@inlined
def wheel_roughness(Rd: float, fresh: float, RaRef: float) -> float:
    """Roughness scale of the wheel, um: relaxes from dressed to process-made (Verkerk) [C]; `fresh` as in `cutting`."""
    return SETTLED_ROUGHNESS * RaRef + (Rd - SETTLED_ROUGHNESS * RaRef) * fresh


@inlined
def generated_roughness(
    Rt: float, Q: float, per_vs: float, lam: float, alw: float, f0: float, f1: float, cw: float, ra_scale: float
) -> float:
    """Roughness Ra that the wheel generates, um: a floor and a term with the root of the removal rate.

    The floor is what spark-out leaves: expected is spark-out over plunge .87 at the finest feeds, .4 at heavy ones [C];
    measured is an exponent of .29 on the removal rate in between [D]; exponent -1/2 on the wheel speed [M]. Waviness is
    added in quadrature.

    Args:
        Rt: roughness scale of the wheel, um.
        Q: specific removal rate, mm2/s.
        per_vs: one over the wheel speed, s/m.
        lam: loading.
        alw: waviness, um.
        f0: floor over the scale.
        f1: the term over the scale at the reference rate.
        cw: share of the waviness that passes the cut-off.
        ra_scale: factor of this wheel and part.
    """
    rate = math.sqrt(Q * (1.0 / REFERENCE_RATE))
    Rg = ra_scale * Rt * math.sqrt(REFERENCE_SPEED * per_vs) * (f0 + f1 * rate) * (1.0 + 0.6 * lam)
    wave = cw * alw
    return math.sqrt(Rg * Rg + wave * wave)


@inlined
def surface_roughness(Rs: float, Rg: float, ae: float, touched: bool) -> float:
    """Roughness after a pass, um: a pass replaces the texture as far as it reaches [C]; ae in mm.

    Even one of no depth takes peaks off, so that passes without infeed end at what the wheel generates.
    """
    reach = 1000.0 * ae + PEAK_DEPTH
    share = reach / (reach + TEXTURE_SHARE * Rs)
    return Rs + (Rg - Rs) * (share if touched else 0.0)
