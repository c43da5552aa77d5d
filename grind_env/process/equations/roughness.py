"""Roughness of wheel and part; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined

INITIAL_ROUGHNESS = 1.6  #: Ra of the surface of a part before it is ground, um
#: roughness scale of a wheel that has ground for a while, over the scale after the reference dress [C]
SETTLED_ROUGHNESS = 0.9
#: wheel speed, m/s, and removal rate, mm2/s, for which the roughness terms are stated
REFERENCE_SPEED, REFERENCE_RATE = 30.0, 3.0
NEARLY_NOTHING = 1e-300  #: small number in divisors, so that 0 over 0 gives a number
PEAK_DEPTH = 0.5  #: largest depth that a pass without depth of cut takes off the peaks, um [C]
#: equivalent chip thickness below which grains plough, um: spark-out leaves the roughness of this thickness [C]
PLOUGHING_CHIP = 0.02
TEXTURE_SHARE = 2.0  #: depth, in units of Ra, at which a pass replaces half of the earlier texture [C]


@inlined
def wheel_roughness(Rd: float, fresh: float, RaRef: float) -> float:
    """Return the roughness scale of the wheel, um: from dressed to settled (Verkerk) [C]; `fresh` is of `freshness`."""
    return SETTLED_ROUGHNESS * RaRef + (Rd - SETTLED_ROUGHNESS * RaRef) * fresh


@inlined
def roughening(breaking: float, chips: float, least: float, gm: float, nr: float) -> float:
    """Return the factor of wheel wear on the wheel's roughness: grains that break out roughen the face.

    The factor is the wear over the reference wear to the power nr. On valve alloys a dependence of Ra on (wheel wear
    over volume ground)^.26 to .32, beside the removal rate, was measured [D]. The power of the fracture factor is
    replaced by its Pade approximant: within 1 % up to twice the wear, and within 7 % up to four times.

    Args:
        breaking: factor of fracture on the wear.
        chips: logarithm of the factor of the chip thickness on the wear.
        least: `chips` at `PLOUGHING_CHIP`, below which the face is no smoother.
        gm: logarithm of the factor of the material on the G-ratio.
        nr: exponent of the abrasive.
    """
    x = 0.5 * (breaking - 1.0)
    return exp(nr * (max(chips, least) - gm)) * (1.0 + x + nr * x) / (1.0 + x - nr * x)


@inlined
def generated_roughness(
    Rt: float, Q: float, per_vs: float, lam: float, f0: float, f1: float, roughened: float, ra_scale: float
) -> float:
    """Return the roughness Ra that the wheel generates, um: a floor and a term with the root of the removal rate.

    Spark-out leaves the floor. The expected ratio of spark-out to plunge is .87 at the finest feeds and .4 at heavy
    ones [C]; an exponent of .29 on the removal rate in between is measured [D]. The wheel speed has exponent -1/2 [M].

    Args:
        Rt: roughness scale of the wheel, um.
        Q: specific removal rate, mm2/s.
        per_vs: one over the wheel speed, s/m.
        lam: loading, 0 to 1.
        f0: ratio of the floor to the scale.
        f1: ratio of the rate term at the reference rate to the scale.
        roughened: factor of the wheel's wear, as of `roughening`.
        ra_scale: factor of this wheel and part.
    """
    rate = math.sqrt(Q * (1.0 / REFERENCE_RATE))
    return ra_scale * roughened * Rt * math.sqrt(REFERENCE_SPEED * per_vs) * (f0 + f1 * rate) * (1.0 + 0.6 * lam)


@inlined
def surface_roughness(Rs: float, Rg: float, ae: float, u: float) -> float:
    """Return the roughness after a pass, um: a pass replaces the texture within its reach [C].

    The reach is the depth of cut and the peaks below, but not deeper than the interference. So a mere touch changes
    nothing, and passes without infeed approach the roughness that the wheel generates.

    Args:
        Rs: roughness before the pass, um.
        Rg: roughness that the wheel generates, um.
        ae: depth of cut, mm.
        u: interference, mm; negative where the wheel passes above the face.
    """
    reach = 1000.0 * ae + min(max(1000.0 * u, 0.0), PEAK_DEPTH)
    return Rs + (Rg - Rs) * (reach / (reach + TEXTURE_SHARE * Rs + NEARLY_NOTHING))
