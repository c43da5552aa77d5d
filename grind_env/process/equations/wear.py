"""What grinding does to the wheel, and what that leaves on the part; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined, power, softplus

LEAST_DIAMETER = 20.0
"""mm; about the spindle's nose: a wheel this small has nothing left to lose (project decision). What it would lose
still counts as wear, in the size of the part and in money, so that nothing is gained by wearing a wheel away."""


@inlined
def grain_sliding(ae: float, de: float, vs: float, vw: float, Lw: float, ds: float) -> float:
    """Distance a grain slides on the work in one stroke, mm: revolutions in contact times contact length."""
    return 1000.0 * vs * Lw / (vw * math.pi * ds) * math.sqrt(ae * de)


@inlined
def g_ratio(
    heq: float,
    fg: float,
    V: float,
    Gref: float,
    gm: float,
    mG: float,
    href: float,
    fc: float,
    kf: float,
    kt: float,
    Vt: float,
) -> float:
    """G-ratio: falls with chip thickness, with force per grain above `fc`, and just after a dress [C]."""
    fracture = 1.0 + kf * softplus(4.0 * (fg - fc) / fc) / 4.0
    settling = 1.0 + kt * exp(-V / Vt)
    return Gref * gm * power(href / max(heq, 1e-4), mG) / (fracture * settling)


@inlined
def wear_flat_growth(sliding: float, T: float, A: float, kA: float, ka: float, Amax: float) -> float:
    """Attritious growth of the wear-flat area in one stroke; hotter is faster [W for the rate, C]."""
    heat = exp(min(max((T - 200.0) / 500.0, -1.0), 2.0))
    return kA * ka * sliding * heat * (1.0 - A / Amax)


@inlined
def worn_flat_area(A: float, growth: float, renewal: float, Af: float, Amax: float) -> float:
    """Wear-flat area after a stroke: what has grown, less what a share `renewal` of fresh grains (area Af) takes away.

    A stroke that would wear more than `Amax` flat leaves all of that flat: a whole stroke is one step of the growth.
    """
    return min(max(A + growth - (A - Af) * renewal, 0.0), Amax)


@inlined
def waviness(alw: float, dV: float, Kn: float, ke: float, Vchi: float, ks: float, kr: float, alw0: float) -> float:
    """Waviness amplitude after removing dV more, um: regenerative growth above the stiffness ratio ks [C]."""
    rate = min(max((Kn / ke - ks) / (kr - ks), -0.2), 3.0)
    return min(max(alw * exp(dV / Vchi * rate), alw0), 3.0)


@inlined
def worn_diameter(ds: float, radial: float) -> float:
    """Wheel diameter after a loss of radius, mm; none gets below `LEAST_DIAMETER`."""
    return max(ds - 2.0 * radial, min(ds, LEAST_DIAMETER))
