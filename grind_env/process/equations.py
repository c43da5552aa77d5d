"""The relations of the process model, one function each.

Scalar, in the symbols of the literature; units are mm, s, N, W, J and K rise, except wheel speed `vs` m/s,
equivalent chip thickness, waviness and roughness um, effusivity and heat flux SI. With these J/mm3 * mm2/s / (m/s)
is N/mm and W/mm / mm is W/mm2, so the force equations need no factors.

Sources: [M] Malkin, Grinding Technology; [R] Rowe, Principles of Modern Grinding Technology; [W] Wen, Tay & Nee
1992; [C] calibrated for this model so that magnitudes and trends come out right.
"""

import math

from grind_env.kernel import exp, inlined, log, logistic, power, softplus

SMALLEST_CUT = 1e-7
"""mm; ratios with the depth of cut in the denominator hold it above this (0.1 nm: nothing is cut there)."""

LEAST_DIAMETER = 20.0
"""mm; about the spindle's nose: a wheel this small has nothing left to lose (project decision). What it would lose
still counts as wear, in the size of the part and in money, so that nothing is gained by wearing a wheel away."""

INITIAL_ROUGHNESS = 1.6
"""um; Ra of the surface that a part brings to the machine."""


# --- kinematics and depth of cut -----------------------------------------------------------------------------


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
def undeformed_chip_thickness(ae: float, de: float, vw: float, vs: float, C: float, r: float) -> float:
    """Maximum undeformed chip thickness hm, um [M]."""
    return 1000.0 * math.sqrt(4.0 / (C * r) * vw / (1000.0 * vs) * math.sqrt(ae / de))


# --- forces, power, specific energy --------------------------------------------------------------------------


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


# --- wheel wear ----------------------------------------------------------------------------------------------


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
def corner_radius(worn_area: float) -> float:
    """Radius of a worn wheel corner, mm, from the worn corner area, mm2 [C]."""
    return math.sqrt(worn_area / 0.215)


@inlined
def corner_wear(dw: float, ke_c: float) -> float:
    """Corner area worn off, mm2, while the wheel face wears by dw mm [C]; `ke_c` is 0.05 to 0.2 mm."""
    return ke_c * dw


# --- roughness -----------------------------------------------------------------------------------------------


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


# --- heat ----------------------------------------------------------------------------------------------------


@inlined
def jaeger_factor(lc: float, vw: float, alpha: float) -> float:
    """Temperature factor C of the moving heat source; fit to the Jaeger solution [R], made continuous."""
    peclet = vw * lc / (4.0 * alpha)
    return min(max(0.302 * math.sqrt(2.0 * math.pi + peclet / 2.0), 0.76), 1.06)


@inlined
def work_partition(A: float, vs: float, kg: float, beta: float) -> float:
    """Share of the grain heat that enters the work (Hahn; Rowe) [R]; the grain contact radius grows with A."""
    r0 = 15e-6 + 25e-6 * min(max(A / 0.08, 0.0), 1.0)
    return 1.0 / (1.0 + 0.97 * kg / (beta * math.sqrt(r0 * vs)))


@inlined
def work_conductance(lc: float, vw: float, beta: float, Cf: float) -> float:
    """Heat conductance into the work, W/(m2 K) [R]."""
    return beta / Cf * math.sqrt(vw / max(lc, SMALLEST_CUT))


@inlined
def temperature(P_width: float, Q: float, lc: float, hw: float, Rws: float, lam: float, hf: float, Tb: float) -> float:
    """Surface temperature rise, K [R].

    Chips carry 6 J/mm3 but at most 0.45 of the heat. The fluid cools until the wet temperature nears `Tb`; beyond
    it the film boils off and a tenth of the convection is left, with a smooth step between.

    Args:
        P_width: power per width, W/mm.
        Q: specific removal rate, mm2/s.
        lc: contact length, mm.
        hw: conductance into the work, W/(m2 K).
        Rws: share of the grain heat that enters the work.
        lam: loading, which keeps fluid out of the contact.
        hf: convection coefficient of the fluid, W/(m2 K).
        Tb: temperature rise at which the film boils, K.
    """
    flux = 1e6 * P_width / max(lc, SMALLEST_CUT)
    chips = min(1e6 * 6.0 * Q / max(lc, SMALLEST_CUT), 0.45 * flux)
    hF = hf * (1.0 - 0.5 * lam)
    wet = (flux - chips) / (hw / Rws + hF)
    dry = (flux - chips) / (hw / Rws + 0.1 * hF)
    return wet + (dry - wet) * logistic((wet - Tb) / 8.0)


@inlined
def burn_threshold(ae: float, de: float, vw: float, Rws: float, u0: float, Bm: float) -> float:
    """Specific energy at which the work burns, J/mm3 (Malkin 1978) [M].

    The factor 0.88/Rws carries the threshold of alumina wheels over to other grains [C].
    """
    root = math.sqrt(max(ae, SMALLEST_CUT))
    return u0 + Bm * (0.88 / Rws) * math.sqrt(math.sqrt(de)) / (root * math.sqrt(root) * math.sqrt(vw))


def residual_stress(T: float) -> float:
    """Residual stress indicator, MPa: -300 for a cool surface, tensile when overheated [C]."""
    return -300.0 + 1.5 * max(T - 300.0, 0.0)


def thermal_bow(alpha_th: float, dTz: float, Lw: float, h: float) -> float:
    """Bow of a plate, mm, under a mean temperature difference dTz between its faces (length Lw, height h)."""
    return alpha_th * dTz * Lw * Lw / (8.0 * h)


def traverse_taper(ae: float, Lw: float, width: float, G: float, ds: float, bs: float) -> float:
    """Taper that wheel wear leaves over one full traverse of a part of that width, mm."""
    return ae * Lw * width / (G * math.pi * ds * bs)


@inlined
def worn_diameter(ds: float, radial: float) -> float:
    """Wheel diameter after a loss of radius, mm; none gets below `LEAST_DIAMETER`."""
    return max(ds - 2.0 * radial, min(ds, LEAST_DIAMETER))


# --- dressing ------------------------------------------------------------------------------------------------


@inlined
def dress_width(ad: float, rd: float, wd: float) -> float:
    """Active width of a round diamond at dress depth `ad`, mm; tip radius `rd`, wear flat `wd`."""
    return 2.0 * math.sqrt(2.0 * rd * ad - ad * ad) + wd


@inlined
def overlap_ratio(bd: float, fd: float) -> float:
    """Overlap ratio Ud: active diamond width over dress lead; 1.5-3 rough, 4-8 finish, above 10 glazes."""
    return bd / fd


@inlined
def restoration(passes: float, ad: float, lam: float, A: float, dd: float) -> float:
    """Restoration exponent x of a dress: depth dressed off over the depth damaged, more on a dull wheel [C]."""
    return passes * ad / (dd * (1.0 + lam + A / 0.05))


@inlined
def restored_fraction(passes: float, ad: float, lam: float, A: float, dd: float) -> float:
    """Share of the damaged wheel surface that a dress of that many passes renews [C]."""
    return 1.0 - exp(-restoration(passes, ad, lam, A, dd))


@inlined
def dressed_volume(passes: float, ad: float, ds: float, bs: float) -> float:
    """Wheel volume that a dress takes off, mm3: over the whole wheel width bs."""
    return passes * ad * math.pi * ds * bs


@inlined
def dressed_flat_area(Ud: float, Ad0: float, kU: float) -> float:
    """Wear-flat area of a freshly dressed wheel: finer dressing leaves more [C]."""
    return Ad0 + kU * Ud


@inlined
def dressed_density(Ud: float, Cref: float) -> float:
    """Active grain density of a freshly dressed wheel, 1/mm2 [C]."""
    return Cref * power(Ud / 3.0, 0.35)


@inlined
def dressed_roughness(fd: float, ad: float, Ud: float, RaRef: float) -> float:
    """Roughness scale of a freshly dressed wheel, um [M]; net exponents 0.65 on lead, 0.175 on depth."""
    return RaRef * math.sqrt(fd / 0.1) * math.sqrt(math.sqrt(ad / 0.020)) * power(Ud / 3.0, -0.15)


@inlined
def sharpening_effort(A: float, lam: float, Ad: float) -> float:
    """Restoration exponent, summed over dresses, that brings a wheel back to within a tenth of its dressed state."""
    return max(max(log(max((A - Ad) / (0.1 * Ad), 1e-12)), log(max(lam / 0.05, 1e-12))), 0.0)
