"""Kinematics, depth of cut, forces, power and specific energy; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined

NEARLY_NOTHING = 1e-300  #: small number in divisors, so that 0 over 0 gives a number
SHORTEST_CONTACT = 1e-7  #: least contact length in a divisor, mm: a wheel in the air has none
#: active grains of a wheel that has ground for a while, over active grains after the reference dress [C]
SETTLED_DENSITY = 1.1


@inlined
def wheel_speed(ds: float, n: float, vs_set: float) -> float:
    """Return the surface speed of the wheel, m/s: pi ds n at constant rpm (n in 1/s), else `vs_set`."""
    return vs_set if vs_set > 0.0 else 0.001 * math.pi * n * ds


@inlined
def curvature_difference(vw: float) -> float:
    """Return the curvature difference of grain path and wheel, 1/mm [M], times de (mm) and vs (m/s); `vw` in mm/s."""
    return 0.004 * vw


@inlined
def wear_flat_pressure(per_speed: float, pa: float, pb: float) -> float:
    """Return the mean pressure under wear flats, N/mm2: linear in curvature difference (Kannappan & Malkin 1972).

    Args:
        per_speed: 1/(de vs).
        pa: pressure at no curvature difference.
        pb: slope of the pressure over `per_speed`.
    """
    return pa + pb * per_speed


@inlined
def flat_area(A: float, lam: float, AL: float) -> float:
    """Return the rubbing area fraction: wear flats plus the loaded part of the surface [C]."""
    return A + AL * lam


@inlined
def freshness(V: float, per_Vr: float) -> float:
    """Return the share, 1 to 0, of the dressed topography that is left after `V` mm3/mm (Verkerk) [C]."""
    return exp(-V * per_Vr)


@inlined
def grain_density(Cd: float, fresh: float, Cref: float) -> float:
    """Return the active grains, 1/mm2: from `Cd` after the last dress the number relaxes to a settled one [C]."""
    settled = SETTLED_DENSITY * Cref
    return settled + (Cd - settled) * fresh


@inlined
def ploughing_pressure(C: float, lam: float, kp: float, per_Cref: float) -> float:
    """Return the tangential ploughing force per area of contact, N/mm2; more grains and loading plough more [M, C]."""
    return kp * math.sqrt(C * per_Cref) * (1.0 + 0.5 * lam)


@inlined
def threshold_force(Kn: float, sd: float, sa: float) -> float:
    """Return the normal force per width below which nothing is cut, N/mm: that of the contact at depth 0 [C].

    Args:
        Kn: normal force per area of rubbing and ploughing contact, N/mm2.
        sd: root of the equivalent diameter, mm^0.5.
        sa: root of the threshold depth, mm^0.5.
    """
    return Kn * sd * sa


@inlined
def pressed_share(u: float, give: float, F0: float) -> float:
    """Return the share of the threshold force that acts: 1 where the wheel cuts, less where it only rubs.

    Args:
        u: interference, mm.
        give: deflection of the elastic loop per force on a width, b/ke, mm2/N.
        F0: threshold force, N/mm.
    """
    return min(max(u / max(give * F0, NEARLY_NOTHING), 0.0), 1.0)


@inlined
def cut_root(u: float, give: float, F0: float, Kn: float, sd: float, sa: float, chip: float, kc: float) -> float:
    """Return the root x of the depth of cut beyond the threshold, mm^0.5: ae = x (x + 2 sa).

    The balance u - ae = b Fn'/ke of the elastic loop is a quadratic in x, because the normal force is affine in ae plus
    a term over the contact length sqrt(de (ae + a0)) = sd (x + sa). Below the interference that the threshold force
    takes up, the wheel only rubs, and x is 0.

    Args:
        u: interference, mm.
        give: deflection of the elastic loop per force on a width, mm2/N.
        F0: threshold force, N/mm.
        Kn: normal force per area of rubbing and ploughing contact, N/mm2.
        sd: root of the equivalent diameter, mm^0.5.
        sa: root of the threshold depth, mm^0.5.
        chip: tangential force of chip formation per width and depth, N/mm2.
        kc: ratio of normal to tangential force of a chip.
    """
    beyond = max(u - give * F0, 0.0)
    g1 = 1.0 + give * kc * chip
    half = give * Kn * sd + 2.0 * g1 * sa
    # the root (-half + sqrt(half^2 + 4 g1 beyond)) / (2 g1), in the form without cancellation
    return 2.0 * beyond / (half + math.sqrt(half * half + 4.0 * g1 * beyond) + NEARLY_NOTHING)


@inlined
def depth_of_cut(x: float, sa: float) -> float:
    """Return the real depth of cut ae, mm, from the root of `cut_root`."""
    return x * (x + 2.0 * sa)


@inlined
def rubbing_length(x: float, share: float, sd: float, sa: float) -> float:
    """Return the contact length of flats and ploughing grains, mm: sqrt(de (ae + a0)), less in mere rubbing [M, C]."""
    return sd * (x + share * sa)


@inlined
def chip_force(Q: float, per_vs: float, u_ch: float) -> float:
    """Return the tangential force of chip formation per width, N/mm [M]."""
    return u_ch * Q * per_vs


@inlined
def contact_length(ae: float, sd: float, Fn: float, flattening: float) -> float:
    """Return the contact length with elastic flattening, mm (Rowe & Qi) [R]; used for heat and force per grain only.

    Args:
        ae: depth of cut, mm.
        sd: root of the equivalent diameter, mm^0.5.
        Fn: normal force per width, N/mm.
        flattening: 8 Rr^2/(pi E*), mm2/N.
    """
    return sd * math.sqrt(ae + flattening * Fn)


@inlined
def specific_energy(P_width: float, Q: float) -> float:
    """Return the specific energy P'/Q', J/mm3; 0 where nothing is cut."""
    return P_width / Q if Q > 0.0 else 0.0


@inlined
def force_per_grain(Fn: float, C: float, lc: float) -> float:
    """Return the normal force per active grain, N; `C` in 1/mm2."""
    return Fn / (C * max(lc, SHORTEST_CONTACT))
