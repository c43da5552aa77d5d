"""Heat, burn, and their effects on the part; symbols, units and sources as in the package.

The temperature rise decides on scrap: its limit is that of the material plus the allowance of the job. The burn ratio
(Malkin) only warns: it compares the power with the power at which steels usually burn.

Conductances are h lc in W/(m2 K) mm: rise in K = 1e6 (W/mm) / conductance.
"""

import math

from grind_env.kernel import exp, inlined

#: span from the first vapour to a film that has boiled off, K [C on the jump of Shen et al. 2008, 0.24 to 0.92]
BOILING_SPAN = 20.0
CARRYING_SPEED = 30.0  #: wheel speed for which fluid entries state their convection, m/s
CARRYING_LENGTH = 2.4  #: contact length for which fluid entries state their convection, mm
CARRYING = math.sqrt(CARRYING_LENGTH / CARRYING_SPEED)  #: root of `CARRYING_LENGTH` over `CARRYING_SPEED`, (mm s/m)^0.5
MOST_TO_CHIPS = 0.45  #: highest share of the power that chips carry off
#: small conductance in divisors, so that a stroke without heat and contact gives a number; its square is above 0
NO_SINK = 1e-150


@inlined
def jaeger_factor(lc: float, peclet: float) -> float:
    """Return the squared temperature factor of the moving heat source at the Peclet number L.

    The factor falls on slow tables like that of the peak temperature under Jaeger's moving band of heat, which has
    (4/pi)/(1 + 0.29 L^(-3/4)) within 2 % from L = 0.1 to 31. The level here is lower: 1.06^2 [R] within 1 % at L = 14,
    a usual table. The reason: heat that falls off along the contact warms less than an even band.

    Args:
        lc: contact length, mm.
        peclet: the Peclet number over the contact length, vw/(4 alpha), 1/mm.
    """
    L = peclet * lc
    return 1.16 / (1.0 + 0.29 / (math.sqrt(L * math.sqrt(L)) + 1e-12))


@inlined
def conductances(
    lc: float, vw: float, beta: float, jaeger: float, A: float, vs: float, krw: float
) -> tuple[float, float]:
    """Return the conductance into the work, W/(m2 K) mm [R], and the ratio grains to work, 1/Rws - 1 (Hahn; Rowe) [R].

    Args:
        lc: contact length, mm.
        vw: table speed, mm/s.
        beta: effusivity of the work, J/(m2 K s^0.5).
        jaeger: square of the temperature factor.
        A: wear-flat area; the contact of a grain grows with it.
        vs: wheel speed, m/s.
        krw: 0.97 kg/(beta sqrt(r0)), (m/s)^0.5.
    """
    grains = (1.0 + 20.8 * A) * vs
    per = 1.0 / (jaeger * grains)
    return beta * math.sqrt(vw * lc * grains * per), krw * math.sqrt(jaeger * per)


@inlined
def film_conductance(lc: float, vs: float, lam: float, hf: float) -> float:
    """Return the conductance into the fluid, W/(m2 K) mm: the wheel carries fluid through the contact.

    A fluid of effusivity beta_f that moves with the wheel has h = 1.13 beta_f sqrt(vs/lc) (fluid wheel) [R, from
    memory; the dependence on speed and arc: doi 10.1177/0954405413476392]. A loaded wheel carries less [C].

    Args:
        lc: contact length, mm.
        vs: wheel speed, m/s.
        lam: loading.
        hf: convection at `CARRYING_SPEED` over `CARRYING_LENGTH`, W/(m2 K), times `CARRYING`.
    """
    return hf * math.sqrt(vs * lc) * (1.0 - 0.5 * lam)


@inlined
def retained_heat(P_width: float, Q: float, e_ch: float) -> float:
    """Return the power per width without the heat of the chips (`e_ch` J/mm3), W/mm [R]."""
    return P_width - min(e_ch * Q, MOST_TO_CHIPS * P_width)


@inlined
def temperature(heat: float, work: float, film: float, kfilm: float, Tb: float) -> float:
    """Return the surface temperature rise, K [R].

    The fluid cools until the wet temperature nears `Tb`; the film boils off within 20 K around `Tb`.

    Args:
        heat: power per width without the heat of the chips, W/mm.
        work: conductance into work and grains, W/(m2 K) mm.
        film: conductance into the fluid, W/(m2 K) mm.
        kfilm: share of `film` that is left when the film has boiled off.
        Tb: temperature rise at which the film boils, K.
    """
    by_wet, by_dry = work + film + NO_SINK, work + kfilm * film + NO_SINK
    per = 1e6 * heat / (by_wet * by_dry)
    wet, dry = per * by_dry, per * by_wet
    y = min(max((wet - Tb) * (1.0 / BOILING_SPAN) + 0.5, 0.0), 1.0)
    return wet + (dry - wet) * (y * y * (3.0 - 2.0 * y))


@inlined
def heat_flow(T: float, work: float) -> float:
    """Return the power per width that enters the work, W/mm; `work` is the conductance into the work, W/(m2 K) mm."""
    return 1e-6 * T * work


@inlined
def energy_partition(flow: float, P_width: float) -> float:
    """Return the share of the power that enters the work."""
    return flow / P_width if P_width > 0.0 else 0.0


@inlined
def burn_power(Q: float, length: float, vw: float, sink: float, u0: float, Bm: float) -> float:
    """Return the power per width at which the work burns, W/mm: Malkin's threshold u* Q' [M].

    u* = u0 + Bm de^(1/4) ae^(-3/4) vw^(-1/2) (Malkin 1978), with ae^(1/4) de^(1/4) as the root of the contact length.
    The factor 0.88 (1 + sink) carries the threshold of alumina wheels over to other grains [C].
    """
    return u0 * Q + 0.88 * Bm * (1.0 + sink) * math.sqrt(length * vw)


@inlined
def burn_ratio(P_width: float, threshold: float) -> float:
    """Return the power over the power at which the work burns; 0 for a wheel in the air."""
    return P_width / threshold if threshold > 0.0 else 0.0


@inlined
def part_heating(heat: float, per_vw: float, per_capacity: float) -> float:
    """Return the mean temperature rise of the part in a stroke, K: heat input over heat capacity.

    Args:
        heat: power that enters the work while the wheel passes over it, W.
        per_vw: one over the table speed, s/mm.
        per_capacity: one over the heat capacity of the part for each mm of its length, K mm/J.
    """
    return heat * per_vw * per_capacity


@inlined
def cooled(dT: float, seconds: float, per_tau: float) -> float:
    """Return what a time leaves of the rise `dT` of a mode, K; `per_tau` is the decay rate of the mode, 1/s."""
    return dT * exp(-seconds * per_tau)


@inlined
def part_growth(dT: float, swell: float) -> float:
    """Return the thermal growth of a part with a mean rise of `dT` K, mm; `swell` is alpha H, mm/K."""
    return swell * dT
