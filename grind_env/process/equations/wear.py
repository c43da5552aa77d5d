"""Wear of the wheel, and its effects on the part; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined, log

NEARLY_NOTHING = 1e-300  #: small number in divisors, so that 0 over 0 gives a number
#: least wheel diameter, mm, about that of the spindle nose (project decision). Further wear still counts in the size of
#: the part and in money, so that nothing is gained by wearing a wheel away
LEAST_DIAMETER = 20.0
REFERENCE_CHIP = 0.1  #: equivalent chip thickness for which wheel entries state the G-ratio, um
THINNEST_CHIP = 0.001  #: equivalent chip thickness below which the wear is constant, um


@inlined
def turning(Lw: float, vw: float) -> float:
    """Return the revolutions of the wheel over the part, times wheel diameter (mm) over wheel speed (m/s)."""
    return 1000.0 * Lw / (math.pi * vw)


@inlined
def grain_sliding(length: float, vs: float, per_ds: float, turned: float) -> float:
    """Return the distance that a grain slides on the work in one stroke, mm: revolutions times contact length.

    Args:
        length: contact length, mm.
        vs: wheel speed, m/s.
        per_ds: one over the wheel diameter, 1/mm.
        turned: result of `turning`, mm/(m/s).
    """
    return turned * vs * per_ds * length


@inlined
def fracture(fg: float, per_fc: float, kf: float) -> float:
    """Return the factor of fracture on the wear: about 1 up to the force per grain `fc`, then linear [C]."""
    z = fg * per_fc - 1.0
    return 1.0 + 0.5 * kf * (z + math.sqrt(z * z + 0.1))


@inlined
def log_chip_wear(heq: float, mG: float) -> float:
    """Return the logarithm of the wear over the wear at the reference chip: a power law of `heq`, um [M; mG D]."""
    return mG * log(max(heq, THINNEST_CHIP) * (1.0 / REFERENCE_CHIP))


@inlined
def steady_wear(dV: float, breaking: float, chips: float, per_G: float, per_ds: float) -> float:
    """Return the radial wear of a stroke by the G-ratio, mm [M].

    Args:
        dV: specific volume ground, mm3/mm.
        breaking: factor of fracture on the wear.
        chips: logarithm of the factor of the chip thickness on the wear.
        per_G: 1/G at the reference chip thickness without fracture.
        per_ds: one over the wheel diameter, 1/mm.
    """
    return dV * breaking * exp(chips) * per_G * per_ds * (1.0 / math.pi)


@inlined
def early_loss(Cd: float, Cref: float, wi: float) -> float:
    """Return the early radial wear of a dressed face, mm: the loss of grains that the dress has loosened.

    The wear is proportional to the severity of the dress, which follows from its grain density `Cd` (`dressed_density`)
    [C]. `wi` is the wear after a medium dress: the measured intercept of wear over volume, for any work material [D].
    """
    thinned = Cref / Cd
    return wi * (thinned * thinned) * (thinned * thinned)


@inlined
def early_wear(loss: float, V: float, dV: float, per_Vi: float) -> float:
    """Return the early radial wear in a stroke, mm; it decays with the volume ground.

    The wear still to come is loss/(1 + V/Vi)^2, so that the total does not depend on the depth of strokes. Only the
    total was measured [D]; the decay is calibrated [C].

    Args:
        loss: total early wear, mm.
        V: specific volume since the dress, mm3/mm.
        dV: specific volume of the stroke, mm3/mm.
        per_Vi: one over the volume in which three quarters of the total are lost, mm/mm3.
    """
    before, more = 1.0 + V * per_Vi, dV * per_Vi
    after = before + more
    both = before * after
    return loss * more * (before + after) / (both * both)


@inlined
def g_ratio(dV: float, dw: float, ds: float) -> float:
    """Return the G-ratio: work volume over wheel volume [M]; 0 where nothing is cut.

    Args:
        dV: specific volume ground, mm3/mm.
        dw: radial wear of the wheel, mm.
        ds: diameter of the wheel, mm.
    """
    return dV / max(math.pi * ds * dw, NEARLY_NOTHING)


@inlined
def wear_flat_growth(sliding: float, T: float, A: float, kA: float, per_Amax: float) -> float:
    """Return the attritious growth of the wear-flat area in one stroke; heat speeds it up [W for the rate, C]."""
    heat = exp(min(max(0.002 * (T - 200.0), -1.0), 2.0))
    return kA * sliding * heat * (1.0 - A * per_Amax)


@inlined
def worn_flat_area(A: float, growth: float, renewal: float, Af: float, Amax: float) -> float:
    """Return the wear-flat area after a stroke: flats grow, and fresh grains (area Af) replace the share `renewal`.

    The area is limited to `Amax`, because a whole stroke is one step of the growth.
    """
    return min(max(A + growth - (A - Af) * renewal, 0.0), Amax)


@inlined
def worn_diameter(ds: float, radial: float) -> float:
    """Return the wheel diameter after a loss of radius, mm; at least `LEAST_DIAMETER`."""
    return max(ds - 2.0 * radial, min(ds, LEAST_DIAMETER))
