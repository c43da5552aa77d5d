"""Effects of grit size and structure on a wheel; symbols, units and sources as in the package.

Computed once for a set-up. `z` is the fineness, 1 for a grit of 0.25 mm (mesh 60); `st` the density of the structure, 1
for a grain volume fraction of 0.52. The exponents are calibrated: the count per area goes as Vg/dg^2 (Malkin), so a
finer grit has less force on one grain, about as dg^1.5, and flats that cover more of the face.
"""

import math

REFERENCE_GRIT = 0.25
"""mm; mesh 60, where the entries of wheels state what depends on the grit."""
REFERENCE_GRADE, REFERENCE_GRADE_CBN = 1.2, 4.0
"""N; force per grain that breaks grain or bond, of alumina of grade J and of vitrified CBN, at the reference grit."""
RENEWAL_EXPONENT = 1.35
"""Renewal exponent of the wear that renews the face over the hardness [C]."""
REFERENCE_FRACTION = 0.52
"""Grain volume fraction at which they do, about structure number 5."""


def fineness(dg: float) -> float:
    """Fineness of a grit of `dg` mm over that of the reference."""
    return REFERENCE_GRIT / dg


def density(Vg: float) -> float:
    """Grain volume fraction of a structure over that of the reference."""
    return Vg / REFERENCE_FRACTION


def active_grains(dg: float, Vg: float) -> float:
    """Active grains per area after the reference dress, 1/mm2: of the count, 0.36 Vg/dg^2 [M; 0.36 C]."""
    return 0.36 * Vg / (dg * dg)


def ploughing_share(z: float, st: float) -> float:
    """Factor on the ploughing pressure: more grains in contact plough more [C]."""
    return math.sqrt(z * st)


def bond_post_strength(fc: float, z: float) -> float:
    """Force per grain above which grain and bond fracture, N; smaller grits sit on smaller posts [C]."""
    return fc / (z * math.sqrt(z))


def hardness(fc: float, reference: float) -> float:
    """How much harder than the reference grade of its abrasive a wheel is, by the force per grain that breaks it."""
    return fc / reference


def graded_g_ratio(g: float, hard: float) -> float:
    """G-ratio of a wheel of that grade: a harder one holds its grains longer [trend of Malkin & Cook 1971, mem; C]."""
    return g * math.sqrt(hard)


def graded_renewal(dr: float, hard: float) -> float:
    """Wear depth that renews the face, mm: a harder wheel holds, and dulls, its grains longer [as above; C]."""
    return float(dr * hard**RENEWAL_EXPONENT)


def grit_roughness(Ra: float, z: float, st: float) -> float:
    """Roughness scale of the wheel, um: finer and denser is smoother [C]."""
    return float(Ra * z**-0.7 * st**-0.3)


def grain_contact_radius(z: float) -> float:
    """Radius of the contact of a sharp grain that conducts heat, m [R for its order; C]."""
    return 20e-6 / math.sqrt(z)


def dulling(ka: float, z: float, st: float) -> float:
    """Factor on the growth of the wear-flat area: many small tips blunt to more flat [C]."""
    return ka * z * st


def fresh_flats(Ad: float, z: float, st: float) -> float:
    """Wear-flat area after the reference dress [C]."""
    return Ad * math.sqrt(z * st)
