"""Heat, burn, and what both leave in the part; symbols, units and sources as in the package."""

import math

from grind_env.kernel import inlined, logistic
from grind_env.process.equations.cutting import SMALLEST_CUT


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


def thermal_bow(alpha_th: float, dTz: float, Lw: float, h: float) -> float:
    """Bow of a plate, mm, under a mean temperature difference dTz between its faces (length Lw, height h)."""
    return alpha_th * dTz * Lw * Lw / (8.0 * h)
