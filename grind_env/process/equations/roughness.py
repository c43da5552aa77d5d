"""Roughness of wheel and part; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined

INITIAL_ROUGHNESS = 1.6
"""um; Ra of the surface that a part brings to the machine."""
SETTLED_ROUGHNESS = 0.9
"""Roughness scale of a wheel that has ground for a while, over that of the reference dress [C]."""
REFERENCE_SPEED, REFERENCE_RATE = 30.0, 3.0
"""m/s and mm2/s; of the terms below."""
NEARLY_NOTHING = 1e-300
"""Keeps a quotient of two zeros a number."""
PEAK_DEPTH = 0.5
"""um; what a pass of no depth takes off the peaks at most [C]."""
PLOUGHING_CHIP = 0.02
"""um; equivalent chip thickness below which grains plough: spark-out leaves what they left [C]."""
TEXTURE_SHARE = 2.0
"""Depth in units of Ra at which a pass replaces half of the texture before it [C]."""


@inlined
def wheel_roughness(Rd: float, fresh: float, RaRef: float) -> float:
    """Roughness scale of the wheel, um: relaxes from dressed to process-made (Verkerk) [C]; `fresh` as in `cutting`."""
    return SETTLED_ROUGHNESS * RaRef + (Rd - SETTLED_ROUGHNESS * RaRef) * fresh


@inlined
def roughening(breaking: float, chips: float, least: float, gm: float, nr: float) -> float:
    """Factor of wheel wear on the wheel's roughness: grains that break out roughen the face.

    The wear over that of the reference, to the power nr. Measured over the valve alloys: Ra goes with (wheel wear over
    volume ground)^.26 to .32 beside the removal rate [D]. Of fracture the power is its Pade approximant, which is
    within 1 % of it up to twice the wear and within 7 % up to four times.

    Args:
        breaking: factor of fracture on the wear.
        chips: logarithm of that of the chip thickness.
        least: the same at `PLOUGHING_CHIP`, below which the face is no smoother.
        gm: logarithm of the factor of the material on the G-ratio.
        nr: exponent of the abrasive.
    """
    x = 0.5 * (breaking - 1.0)
    return exp(nr * (max(chips, least) - gm)) * (1.0 + x + nr * x) / (1.0 + x - nr * x)


@inlined
def generated_roughness(
    Rt: float, Q: float, per_vs: float, lam: float, f0: float, f1: float, roughened: float, ra_scale: float
) -> float:
    """Roughness Ra that the wheel generates, um: a floor and a term with the root of the removal rate.

    The floor is what spark-out leaves: expected is spark-out over plunge .87 at the finest feeds, .4 at heavy ones [C];
    measured is an exponent of .29 on the removal rate in between [D]; exponent -1/2 on the wheel speed [M].

    Args:
        Rt: roughness scale of the wheel, um.
        Q: specific removal rate, mm2/s.
        per_vs: one over the wheel speed, s/m.
        lam: loading.
        f0: floor over the scale.
        f1: the term over the scale at the reference rate.
        roughened: factor of the wheel's wear.
        ra_scale: factor of this wheel and part.
    """
    rate = math.sqrt(Q * (1.0 / REFERENCE_RATE))
    return ra_scale * roughened * Rt * math.sqrt(REFERENCE_SPEED * per_vs) * (f0 + f1 * rate) * (1.0 + 0.6 * lam)


@inlined
def surface_roughness(Rs: float, Rg: float, ae: float, u: float) -> float:
    """Roughness after a pass, um: a pass replaces the texture as far as it reaches [C].

    It reaches through what it cuts and into the peaks below, but no deeper than it interferes: a mere touch leaves the
    face as it was, and passes without infeed end at what the wheel generates.

    Args:
        Rs: before it, um.
        Rg: that the wheel generates, um.
        ae: depth of cut, mm.
        u: interference, mm; negative where the wheel passes above the face.
    """
    reach = 1000.0 * ae + min(max(1000.0 * u, 0.0), PEAK_DEPTH)
    return Rs + (Rg - Rs) * (reach / (reach + TEXTURE_SHARE * Rs + NEARLY_NOTHING))
