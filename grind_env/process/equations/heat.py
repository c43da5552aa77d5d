"""Heat, burn, and what both leave in the part; symbols, units and sources as in the package.

The temperature rise judges: beyond the limit of the material, and the allowance of the job, a part is scrap. The burn
ratio (Malkin) warns: it says how near the power is to that at which steels usually burn, and scraps nothing.

Conductances are over the contact length: h lc, W/(m2 K) times mm, so that 1e6 times a power per width in W/mm over one
of them is a temperature rise.
"""

import math

from grind_env.kernel import inlined

BOILING_SPAN = 20.0
"""K; from the first vapour to a film that has boiled off [C on the jump of Shen et al. 2008, 0.24 to 0.92]."""
MOST_TO_CHIPS = 0.45
"""Share of the power that chips carry off at most."""
NO_SINK = 1e-150
"""Keeps the quotient a number where there is neither heat nor contact; its square is one, too."""


@inlined
def sink_ratio(A: float, vs: float, krw: float) -> float:
    """Heat that the grains take over what the work takes of theirs, 1/Rws - 1 (Hahn; Rowe) [R].

    Args:
        A: wear-flat area; the contact of a grain grows with it.
        vs: wheel speed, m/s.
        krw: 0.97 kg/(beta sqrt(r0)), (m/s)^0.5.
    """
    return krw / math.sqrt((1.0 + 20.8 * A) * vs)


@inlined
def jaeger_factor(lc: float, peclet: float) -> float:
    """Square of the temperature factor of the moving heat source: a fit to the Jaeger solution [R], made continuous.

    `peclet` is the Peclet number over the contact length, vw/(4 alpha), 1/mm.
    """
    return min(max(0.0912 * (2.0 * math.pi + 0.5 * peclet * lc), 0.578), 1.124)


@inlined
def work_conductance(lc: float, vw: float, beta: float, jaeger: float) -> float:
    """Conductance into the work over the contact length, W/(m2 K) mm [R]; `jaeger` is the square of the factor."""
    return beta * math.sqrt(vw * lc / jaeger)


@inlined
def retained_heat(P_width: float, Q: float, e_ch: float) -> float:
    """Power per width that does not leave with the chips, W/mm; these carry `e_ch` J/mm3 [R]."""
    return P_width - min(e_ch * Q, MOST_TO_CHIPS * P_width)


@inlined
def temperature(heat: float, work: float, film: float, kfilm: float, Tb: float) -> float:
    """Surface temperature rise, K [R].

    The fluid cools until the wet temperature nears `Tb`; within 20 K there the film boils off.

    Args:
        heat: power per width that the chips leave, W/mm.
        work: conductance into work and grains, over the contact length.
        film: that into the fluid.
        kfilm: share of it that is left when the film has boiled off.
        Tb: temperature rise at which the film boils, K.
    """
    by_wet, by_dry = work + film + NO_SINK, work + kfilm * film + NO_SINK
    per = 1e6 * heat / (by_wet * by_dry)
    wet, dry = per * by_dry, per * by_wet
    y = min(max((wet - Tb) * (1.0 / BOILING_SPAN) + 0.5, 0.0), 1.0)
    return wet + (dry - wet) * (y * y * (3.0 - 2.0 * y))


@inlined
def energy_partition(T: float, work: float, P_width: float) -> float:
    """Share of the power that enters the work; `work` is the conductance into it over the contact length."""
    return T * work / (1e6 * P_width) if P_width > 0.0 else 0.0


@inlined
def burn_power(Q: float, length: float, vw: float, sink: float, u0: float, Bm: float) -> float:
    """Power per width at which the work burns, W/mm: Malkin's threshold u* Q' [M].

    u* = u0 + Bm de^(1/4) ae^(-3/4) vw^(-1/2) (Malkin 1978), with ae^(1/4) de^(1/4) as the root of the contact length.
    The factor 0.88 (1 + sink) carries the threshold of alumina wheels over to other grains [C].
    """
    return u0 * Q + 0.88 * Bm * (1.0 + sink) * math.sqrt(length * vw)


@inlined
def burn_ratio(P_width: float, threshold: float) -> float:
    """Power over the power at which the work burns; 0 of a wheel in the air."""
    return P_width / threshold if threshold > 0.0 else 0.0
