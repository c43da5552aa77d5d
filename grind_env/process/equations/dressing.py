"""What a dress does to the wheel; symbols, units and sources as in the package."""

import math

from grind_env.kernel import exp, inlined, log, power


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
