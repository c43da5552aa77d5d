"""Effects of grit size and structure on a wheel; symbols, units and sources as in the package.

The functions are called once for a set-up. `z` is the fineness, 1 for a grit of 0.25 mm (mesh 60). `st` is the density
of the structure, 1 for a grain volume fraction of 0.52. The exponents are calibrated: the grains per area go as Vg/dg^2
(Malkin). So a finer grit has less force on one grain, about as dg^1.5, and flats that cover more of the face.
"""

import math

REFERENCE_GRIT = 0.25  #: grit size for which wheel entries are stated, mm (mesh 60)
#: force per grain that breaks grain or bond, N: alumina of grade J, and vitrified CBN, at the reference grit
REFERENCE_GRADE, REFERENCE_GRADE_CBN = 1.2, 4.0
RENEWAL_EXPONENT = 1.35  #: exponent of the renewal depth over the hardness [C]
REFERENCE_FRACTION = 0.52  #: grain volume fraction for which wheel entries are stated, about structure number 5


def fineness(dg: float) -> float:
    """Return the fineness of a grit of `dg` mm: reference grit size over grit size."""
    return REFERENCE_GRIT / dg


def density(Vg: float) -> float:
    """Return the grain volume fraction of a structure over the reference fraction."""
    return Vg / REFERENCE_FRACTION


def active_grains(dg: float, Vg: float) -> float:
    """Return the active grains per area after the reference dress, 1/mm2: 0.36 of all, Vg/dg^2 [M; 0.36 C]."""
    return 0.36 * Vg / (dg * dg)


def ploughing_share(z: float, st: float) -> float:
    """Return the factor on the ploughing pressure: more grains in contact plough more [C]."""
    return math.sqrt(z * st)


def bond_post_strength(fc: float, z: float) -> float:
    """Return the force per grain above which grain and bond fracture, N; smaller grits sit on smaller posts [C]."""
    return fc / (z * math.sqrt(z))


def hardness(fc: float, reference: float) -> float:
    """Return the hardness of a wheel over the reference grade of its abrasive: a ratio of breaking forces per grain."""
    return fc / reference


def graded_g_ratio(g: float, hard: float) -> float:
    """Return the G-ratio of a graded wheel: hard wheels hold grains longer [trend of Malkin & Cook 1971, mem; C]."""
    return g * math.sqrt(hard)


def graded_renewal(dr: float, hard: float) -> float:
    """Return the wear depth of a new face, mm: hard wheels hold, and dull, grains longer [as `graded_g_ratio`; C]."""
    return float(dr * hard**RENEWAL_EXPONENT)


def grit_roughness(Ra: float, z: float, st: float) -> float:
    """Return the roughness scale of the wheel, um: finer and denser is smoother [C]."""
    return float(Ra * z**-0.7 * st**-0.3)


def grain_contact_radius(z: float) -> float:
    """Return the contact radius of a sharp grain for heat conduction, m [R for its order; C]."""
    return 20e-6 / math.sqrt(z)


def dulling(ka: float, z: float, st: float) -> float:
    """Return the factor on the growth of the wear-flat area: many small tips blunt to more flat [C]."""
    return ka * z * st


def fresh_flats(Ad: float, z: float, st: float) -> float:
    """Return the wear-flat area after the reference dress [C]."""
    return Ad * math.sqrt(z * st)
