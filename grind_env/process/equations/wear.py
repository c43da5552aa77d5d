"""What grinding does to the wheel, and what that leaves on the part; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined, power

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
def settling(V: float, kt: float, per_Vt: float) -> float:
    """Factor of initial wear after a dress, which dies with the root of the volume [C on wear ~ V^0.6 of CBN, D]."""
    return 1.0 + kt / math.sqrt(1.0 + V * per_Vt)


@inlined
def wear_per_volume(heq: float, breaking: float, initial: float, per_G: float, mG: float) -> float:
    """1/G: wheel volume worn per volume ground; a power law in the equivalent chip thickness [M; mG D].

    Args:
        heq: equivalent chip thickness, um.
        breaking: factor of fracture.
        initial: factor of initial wear.
        per_G: of a settled wheel at the reference chip thickness, without fracture.
        mG: exponent.
    """
    return per_G * breaking * initial * power(max(heq, THINNEST_CHIP) * (1.0 / REFERENCE_CHIP), mG)


@inlined
def wear_flat_growth(sliding: float, T: float, A: float, kA: float, per_Amax: float) -> float:
    """Attritious growth of the wear-flat area in one stroke; hotter is faster [W for the rate, C]."""
    heat = exp(min(max(0.002 * (T - 200.0), -1.0), 2.0))
    return kA * sliding * heat * (1.0 - A * per_Amax)


@inlined
def worn_flat_area(A: float, growth: float, renewal: float, Af: float, Amax: float) -> float:
    """Wear-flat area after a stroke: what has grown, less what a share `renewal` of fresh grains (area Af) takes away.

    A stroke that would wear more than `Amax` flat leaves all of that flat: a whole stroke is one step of the growth.
    """
    return min(max(A + growth - (A - Af) * renewal, 0.0), Amax)


@inlined
def waviness(alw: float, grown: float, stiffness: float, ks: float, per_span: float, alw0: float) -> float:
    """Waviness amplitude after a stroke, um: regenerative growth above the stiffness ratio ks [C].

    Args:
        alw: before it.
        grown: volume removed in it over that in which waviness grows e-fold.
        stiffness: of the cut over that of the machine.
        ks: ratio of stiffnesses at which growth begins.
        per_span: 1/(kr - ks), with the ratio kr of unit growth.
        alw0: of a dressed wheel.
    """
    rate = min(max((stiffness - ks) * per_span, -0.2), 3.0)
    return min(max(alw * exp(grown * rate), alw0), 3.0)


@inlined
def worn_diameter(ds: float, radial: float) -> float:
    """Wheel diameter after a loss of radius, mm; none gets below `LEAST_DIAMETER`."""
    return max(ds - 2.0 * radial, min(ds, LEAST_DIAMETER))
