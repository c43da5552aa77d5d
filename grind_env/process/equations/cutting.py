"""Kinematics, depth of cut, forces, power and specific energy; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined

SMALLEST_CUT = 1e-7
"""mm; ratios with the depth of cut in the denominator hold it above this (0.1 nm: nothing is cut there)."""


@inlined
def wheel_speed(ds: float, n: float, vs_set: float) -> float:
    """Surface speed of the wheel, m/s: pi ds n at constant rpm (n in 1/s), else the speed that is held."""
    return vs_set if vs_set > 0.0 else math.pi * ds * n / 1000.0


@inlined
def curvature_difference(vw: float, vs: float, de: float) -> float:
    """Curvature difference of grain path and wheel, 1/mm [M]; equivalent diameter `de` mm, `vw` mm/s."""
    return 4.0 * vw / (de * vs * 1000.0)


@inlined
def wear_flat_pressure(delta: float, pm: float, pa: float, pb: float) -> float:
    """Mean pressure under the wear flats, N/mm2: linear in the curvature difference (Kannappan & Malkin 1972)."""
    return pm * (pa + pb * delta)


@inlined
def flat_area(A: float, lam: float, AL: float) -> float:
    """Rubbing area fraction: wear flats plus the loaded part of the surface [C]."""
    return A + AL * lam


@inlined
def grain_density(Cd: float, V: float, Cref: float, Vr: float) -> float:
    """Active grain density, 1/mm2: relaxes from the dressed value to 1.1 times the reference [C]."""
    return 1.1 * Cref + (Cd - 1.1 * Cref) * exp(-V / Vr)


@inlined
def ploughing_force(C: float, lam: float, Fpl0: float, Cref: float) -> float:
    """Tangential ploughing force per width, N/mm [M, W]; more grains and loading plough more [C]."""
    return Fpl0 * math.sqrt(C / Cref) * (1.0 + 0.5 * lam)


@inlined
def depth_of_cut(
    u: float,
    b: float,
    p: float,
    Ae: float,
    Fpl: float,
    de: float,
    vw: float,
    vs: float,
    u_ch: float,
    kc: float,
    ke: float,
) -> float:
    """Real depth of cut ae, mm, from the interference u, mm.

    The balance u - ae = b Fn'/ke of the elastic loop is a quadratic in sqrt(ae), because the normal force is
    affine in ae plus a sliding term with sqrt(ae). Below the interference that ploughing alone takes up, the
    wheel only rubs and ae is 0.
    """
    uE = max(u - b * kc * Fpl / ke, 0.0)
    g1 = 1.0 + b * kc * u_ch * (vw / vs) / ke
    g2 = b * p * Ae * math.sqrt(de) / ke
    # the root (-g2 + sqrt(g2^2 + 4 g1 uE)) / (2 g1), in the form without cancellation
    s = 2.0 * uE / (g2 + math.sqrt(g2 * g2 + 4.0 * g1 * uE) + 1e-300)
    return s * s


@inlined
def contact_length(ae: float, de: float, Fn: float, Rr: float, E_star: float) -> float:
    """Contact length with elastic flattening, mm (Rowe & Qi) [R]; used for heat and force per grain only."""
    return math.sqrt(ae * de + 8.0 * Rr * Rr * Fn * de / (math.pi * E_star))


@inlined
def chip_force(ae: float, vw: float, vs: float, u_ch: float) -> float:
    """Tangential force of chip formation per width, N/mm [M]."""
    return u_ch * ae * vw / vs


@inlined
def sliding_force(ae: float, de: float, p: float, Ae: float) -> float:
    """Normal force on the wear flats per width, N/mm [M]: over the geometric contact length sqrt(ae de)."""
    return p * Ae * math.sqrt(ae * de)


@inlined
def normal_force(Ft_c: float, Fpl: float, Fn_sl: float, u: float, b: float, kc: float, ke: float) -> float:
    """Normal force per width, N/mm: of the cut, or of the elastic loop where the wheel only rubs."""
    cutting = kc * (Ft_c + Fpl) + Fn_sl
    rubbing = ke * max(u, 0.0) / b
    return min(cutting, rubbing) if Ft_c <= 0.0 else cutting


@inlined
def tangential_force(Ft_c: float, Fpl: float, Fn_sl: float, Fn: float, mu: float, kc: float) -> float:
    """Tangential force per width, N/mm: chip + ploughing + sliding [M]; a rubbing wheel keeps Ft' = Fn'/kc."""
    return Ft_c + min(Fpl, Fn / kc) + mu * Fn_sl


@inlined
def specific_energy(Ft: float, vs: float, Q: float) -> float:
    """Specific energy P'/Q', J/mm3; 0 where nothing is cut."""
    return Ft * vs / Q if Q > 0.0 else 0.0


@inlined
def force_per_grain(Fn: float, C: float, lc: float) -> float:
    """Normal force per active grain, N."""
    return Fn / (C * max(lc, SMALLEST_CUT))


@inlined
def grinding_stiffness(
    ae: float, de: float, b: float, p: float, Ae: float, vw: float, vs: float, u_ch: float, kc: float
) -> float:
    """Tangent stiffness of the cut, dFn/dae, N/mm."""
    return b * (kc * u_ch * vw / vs + 0.5 * p * Ae * math.sqrt(de / max(ae, SMALLEST_CUT)))
