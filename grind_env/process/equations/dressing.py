"""Effects of a dress on the wheel; symbols, units and sources as in the package.

The severity of a dress decides the sharpness, after Malkin & Murray's 2 ad (fd/dg)^0.5: lead and depth both sharpen.
Roughness follows lead and depth of the tool; a rotary tool has other exponents (measured: Ra as Ud^-1.1 and qd^0.38).
"""

import math

from grind_env.kernel import exp, inlined, log, power

#: lead and depth of a medium dress, mm; wheel entries state flats and roughness after this dress
REFERENCE_LEAD, REFERENCE_DEPTH = 0.10, 0.020
#: ratios of dresser to wheel speed: reference, and least, for a dresser that runs against the wheel [C]
REFERENCE_SPEED_RATIO, LEAST_SPEED_RATIO = 0.6, 0.1
#: least severity over that of a medium dress: a dress that hardly touches the wheel leaves no larger flats [C]
LEAST_SEVERITY = 0.01


@inlined
def dress_width(ad: float, rd: float, wd: float) -> float:
    """Return the active width of a round diamond at dress depth `ad`, mm; tip radius `rd`, wear flat `wd`."""
    return 2.0 * math.sqrt(2.0 * rd * ad - ad * ad) + wd


@inlined
def overlap_ratio(bd: float, fd: float) -> float:
    """Return the overlap ratio Ud: active diamond width over dress lead; 1.5-3 rough, 4-8 finish, above 10 glazes."""
    return bd / fd


def speed_ratio_effect(qd: float, exponent: float) -> float:
    """Return the factor of a rotary dresser's speed ratio on the dressed wheel; 1 for a tool that stands [D, C]."""
    return (max(qd, LEAST_SPEED_RATIO) / REFERENCE_SPEED_RATIO) ** exponent if exponent else 1.0


@inlined
def blunting(wd: float, b0: float) -> float:
    """Return the active width of a worn diamond over the width `b0`, mm, of a new one, at the reference depth."""
    return 1.0 + wd / b0


@inlined
def severity(ad: float, fd: float, blunt: float, qs: float) -> float:
    """Return the severity of a dress over a medium one: Malkin & Murray's 2 ad (fd/dg)^0.5 [M; blunting and qs C].

    Args:
        ad: dress depth, mm.
        fd: dress lead, mm.
        blunt: blunting of the diamond, as of `blunting`.
        qs: effect of the speed ratio of a rotary dresser.
    """
    s = (ad / REFERENCE_DEPTH) * math.sqrt(fd / REFERENCE_LEAD) * qs / blunt
    return max(s, LEAST_SEVERITY)


@inlined
def restoration(passes: float, ad: float, lam: float, A: float, dd: float) -> float:
    """Return the restoration exponent x: dressed depth over damaged depth; a dull wheel is damaged deeper [C]."""
    return passes * ad / (dd * (1.0 + lam + A / 0.05))


@inlined
def restored_fraction(passes: float, ad: float, lam: float, A: float, dd: float) -> float:
    """Return the share of the damaged wheel surface that a dress renews [C]."""
    return 1.0 - exp(-restoration(passes, ad, lam, A, dd))


@inlined
def dressed_volume(passes: float, ad: float, ds: float, bs: float) -> float:
    """Return the wheel volume that a dress takes off over the whole wheel width bs, mm3."""
    return passes * ad * math.pi * ds * bs


@inlined
def dressed_flat_area(s: float, Ad: float, Amax: float) -> float:
    """Return the wear-flat area of a freshly dressed wheel: less after a severe dress (Chen & Rowe for the trend) [C].

    Args:
        s: severity of the dress.
        Ad: wear-flat area after a medium dress.
        Amax: limit of the wear-flat area.
    """
    return min(Ad * (0.25 + 0.75 / math.sqrt(s)), Amax)


@inlined
def dressed_density(s: float, Cref: float) -> float:
    """Return the active grain density of a freshly dressed wheel, 1/mm2: a severe dress breaks grains out [C]."""
    return Cref / math.sqrt(math.sqrt(s))


@inlined
def dressed_roughness(
    fd: float, ad: float, blunt: float, RaRef: float, nf: float, na: float, nw: float, qr: float
) -> float:
    """Return the roughness scale of a freshly dressed wheel, um: RaRef (fd/0.1)^nf (ad/0.02)^na.

    The exponents depend on the tool: 0.5 and 0.25 for a standing diamond [M], 1.1 on the lead for a rotary one [D].

    Args:
        fd: dress lead, mm.
        ad: dress depth, mm.
        blunt: blunting of the diamond, as of `blunting`.
        RaRef: roughness scale after a medium dress, um.
        nf: exponent of the lead.
        na: exponent of the depth.
        nw: exponent of the blunting, which smooths.
        qr: effect of the speed ratio of a rotary dresser.
    """
    lead, depth = log(fd / REFERENCE_LEAD), log(max(ad / REFERENCE_DEPTH, LEAST_SEVERITY))
    return RaRef * qr * exp(nf * lead + na * depth) * power(blunt, -nw)


@inlined
def sharpening_effort(A: float, lam: float, Ad: float) -> float:
    """Return the sum of restoration exponents that restores a wheel to within a tenth of its dressed state."""
    return max(max(log(max((A - Ad) / (0.1 * Ad), 1e-12)), log(max(lam / 0.05, 1e-12))), 0.0)
