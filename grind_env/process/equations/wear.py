"""Wear of the wheel, and its effects on the part; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined, log

NEARLY_NOTHING = 1e-300
"""Keeps a quotient of two zeros a number."""
LEAST_DIAMETER = 20.0
"""mm; about the spindle's nose: a wheel this small has nothing left to lose (project decision). What it would lose
still counts as wear, in the size of the part and in money, so that nothing is gained by wearing a wheel away."""
REFERENCE_CHIP = 0.1
"""um; equivalent chip thickness at which entries state the G-ratio."""
THINNEST_CHIP = 0.001
"""um; of equal wear for all that is thinner."""


@inlined
def turning(Lw: float, vw: float) -> float:
    """Revolutions of the wheel while it passes over the part, times diameter in mm over wheel speed in m/s."""
    return 1000.0 * Lw / (math.pi * vw)


@inlined
def grain_sliding(length: float, vs: float, per_ds: float, turned: float) -> float:
    """Distance a grain slides on the work in one stroke, mm: revolutions in contact times contact length.

    Args:
        length: of the contact, mm.
        vs: wheel speed, m/s.
        per_ds: one over the wheel diameter, 1/mm.
        turned: of `turning`.
    """
    return turned * vs * per_ds * length


@inlined
def fracture(fg: float, per_fc: float, kf: float) -> float:
    """Factor of bond and grain fracture on the wear: about 1 up to the force per grain `fc`, then linear [C]."""
    z = fg * per_fc - 1.0
    return 1.0 + 0.5 * kf * (z + math.sqrt(z * z + 0.1))


@inlined
def log_chip_wear(heq: float, mG: float) -> float:
    """Logarithm of the wear over that at the reference chip thickness: a power law in the thickness, um [M; mG D]."""
    return mG * log(max(heq, THINNEST_CHIP) * (1.0 / REFERENCE_CHIP))


@inlined
def steady_wear(dV: float, breaking: float, chips: float, per_G: float, per_ds: float) -> float:
    """Radius that a wheel loses in a stroke by the G-ratio, mm [M].

    Args:
        dV: specific volume ground, mm3/mm.
        breaking: factor of fracture.
        chips: logarithm of that of the chip thickness.
        per_G: 1/G at the reference chip thickness without fracture.
        per_ds: one over the wheel diameter, 1/mm.
    """
    return dV * breaking * exp(chips) * per_G * per_ds * (1.0 / math.pi)


@inlined
def early_loss(Cd: float, Cref: float, wi: float) -> float:
    """Early radial wear of a dressed face, mm: the grains that the dress has loosened.

    In proportion to the severity of the dress, which the grain density `Cd` that it left remembers (`dressed_density`)
    [C]; `wi` of a medium one, measured as what wear over volume has at no volume, whatever is ground [D].
    """
    thinned = Cref / Cd
    return wi * (thinned * thinned) * (thinned * thinned)


@inlined
def early_wear(loss: float, V: float, dV: float, per_Vi: float) -> float:
    """Early radial wear in a stroke, mm; it decays with the volume ground.

    What is left is loss/(1 + V/Vi)^2, so that strokes of whatever depth lose the same in all. Measured is only what is
    lost in the end [D]; how it dies is calibrated [C].

    Args:
        loss: in all, mm.
        V: specific volume since the dress, mm3/mm.
        dV: of the stroke, mm3/mm.
        per_Vi: one over the volume in which three quarters of it are lost, mm/mm3.
    """
    before, more = 1.0 + V * per_Vi, dV * per_Vi
    after = before + more
    both = before * after
    return loss * more * (before + after) / (both * both)


@inlined
def g_ratio(dV: float, dw: float, ds: float) -> float:
    """G-ratio: work volume over wheel volume [M]; 0 where nothing is cut.

    Args:
        dV: specific volume ground, mm3/mm.
        dw: radius of the wheel that it cost, mm.
        ds: diameter of the wheel, mm.
    """
    return dV / max(math.pi * ds * dw, NEARLY_NOTHING)


@inlined
def wear_flat_growth(sliding: float, T: float, A: float, kA: float, per_Amax: float) -> float:
    """Attritious growth of the wear-flat area in one stroke; hotter is faster [W for the rate, C]."""
    heat = exp(min(max(0.002 * (T - 200.0), -1.0), 2.0))
    return kA * sliding * heat * (1.0 - A * per_Amax)


@inlined
def worn_flat_area(A: float, growth: float, renewal: float, Af: float, Amax: float) -> float:
    """Wear-flat area after a stroke: grown area less the share `renewal` of fresh grains (area Af).

    A stroke that would wear more than `Amax` flat leaves all of that flat: a whole stroke is one step of the growth.
    """
    return min(max(A + growth - (A - Af) * renewal, 0.0), Amax)


@inlined
def worn_diameter(ds: float, radial: float) -> float:
    """Wheel diameter after a loss of radius, mm; at least `LEAST_DIAMETER`."""
    return max(ds - 2.0 * radial, min(ds, LEAST_DIAMETER))
