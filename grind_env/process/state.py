"""What a stroke reads and what it changes, as named tuples of floats.

Named tuples, because numba passes them by value into the inlined stroke function and LLVM keeps their fields
in (vector) registers. The symbols are those of the literature; units are mm, s, N, W, J, K rise unless stated.
"""

from typing import NamedTuple


class WheelState(NamedTuple):
    """The wheel, its diamond and what the grinding has done to both. All hidden from an agent but `ds`."""

    ds: float
    """Diameter, mm."""
    A: float
    """Wear-flat area, fraction of the wheel surface."""
    lam: float
    """Loading, 0 (clean) to 1."""
    V: float
    """Specific volume removed since the last dress, mm3/mm."""
    Rd: float
    """Roughness that the last dress left on the wheel, um."""
    Cd: float
    """Active grain density that the last dress left, 1/mm2."""
    alw: float
    """Waviness amplitude, um."""
    W: float
    """Radial wear since the wheel face was last measured (touch-off, gauge or dress), mm."""
    wd: float
    """Width of the wear flat on the dressing diamond, mm."""


class StrokeParameters(NamedTuple):
    """Everything about material, wheel, fluid and machine that a stroke or a dress needs."""

    u_ch: float
    """Chip formation energy, J/mm3."""
    Fpl0: float
    """Ploughing force of a wheel of reference grain density, N/mm."""
    kA: float
    """Wear-flat growth of this material, 1/mm of grain sliding."""
    kL: float
    """Loading rate, 1 per mm3/mm."""
    gm: float
    """Factor of this material on the G-ratio."""
    pm: float
    """Factor of this material on the wear-flat pressure."""
    u0: float
    """Burn threshold at vanishing contact, J/mm3."""
    Bm: float
    """Slope of the burn threshold."""
    beta: float
    """Thermal effusivity of the work, J/(m2 K s^0.5)."""
    alpha: float
    """Thermal diffusivity of the work, mm2/s."""
    Cref: float
    """Reference grain density, 1/mm2."""
    kg: float
    """Thermal conductivity of the grain, W/(m K)."""
    mu: float
    """Friction of the wear flats."""
    kc: float
    """Normal over tangential force of chip formation and ploughing."""
    pa: float
    """Wear-flat pressure at zero curvature difference, N/mm2."""
    pb: float
    """Slope of the wear-flat pressure over the curvature difference, N/mm."""
    Gref: float
    """G-ratio at the reference equivalent chip thickness."""
    mG: float
    """Exponent of the G-ratio."""
    href: float
    """Reference equivalent chip thickness, um."""
    fc: float
    """Force per grain above which bond and grain fracture, N."""
    kf: float
    """Strength of that fracture wear."""
    dr: float
    """Wear depth that renews the wheel surface, mm."""
    RaRef: float
    """Roughness scale of the wheel, um."""
    x: float
    """Exponent of roughness over equivalent chip thickness."""
    ra_scale: float
    """Factor of this very wheel on the roughness; 1 nominally."""
    Af: float
    """Wear-flat area of a surface that has just fractured."""
    ka: float
    """Factor of this grain on the wear-flat growth."""
    Amax: float
    """Upper limit of the wear-flat area."""
    AL: float
    """Flat area that full loading adds."""
    Ad0: float
    """Wear-flat area after an infinitely coarse dress."""
    kU: float
    """Wear-flat area added per unit of overlap ratio."""
    dd: float
    """Depth of the damaged layer that a dress has to remove, mm."""
    Rr: float
    """Roughness factor of the contact length."""
    Vr: float
    """Volume over which the dressed topography relaxes, mm3/mm."""
    Vt: float
    """Volume over which the initial wear dies away, mm3/mm."""
    kt: float
    """Strength of the initial wear."""
    Vchi: float
    """Volume over which waviness grows, mm3/mm."""
    ks: float
    """Stiffness ratio at which waviness begins to grow."""
    kr: float
    """Stiffness ratio of unit growth."""
    alw0: float
    """Waviness of a dressed wheel, um."""
    cw: float
    """Share of the waviness that passes the roughness cut-off."""
    E_star: float
    """Contact modulus of wheel and work, N/mm2."""
    hf: float
    """Convection coefficient of the fluid, W/(m2 K)."""
    Tb: float
    """Temperature rise at which the fluid film boils, K."""
    ke: float
    """Stiffness of the loop of machine, wheel and work, N/mm."""
    n: float
    """Wheel speed at constant rpm, 1/s; 0 for constant surface speed."""
    vs_set: float
    """Wheel surface speed at constant surface speed, m/s; 0 for constant rpm."""
    bs: float
    """Wheel width, mm."""
    rd: float
    """Tip radius of the diamond, mm."""
    kd: float
    """Diamond wear per wheel volume dressed off, mm/mm3."""


class StrokeResult(NamedTuple):
    """What happens in one stroke: the quantities a record shows."""

    ae: float
    """Real depth of cut, mm."""
    Q: float
    """Specific removal rate, mm2/s."""
    heq: float
    """Equivalent chip thickness, um."""
    Ft: float
    """Tangential force per width, N/mm."""
    Fn: float
    """Normal force per width, N/mm."""
    power: float
    """Grinding power above idle, W."""
    u_s: float
    """Specific energy, J/mm3; 0 where nothing is cut."""
    lc: float
    """Contact length, mm."""
    fg: float
    """Normal force per active grain, N."""
    T: float
    """Surface temperature rise, K."""
    eps: float
    """Energy partition to the work."""
    Br: float
    """Burn ratio: specific energy over burn threshold."""
    G: float
    """G-ratio."""
    dw: float
    """Radial wheel wear of the stroke, mm."""
    worn: float
    """Wheel volume worn in the stroke, mm3."""
    Rg: float
    """Roughness that the wheel generates, um."""
    Ra: float
    """Roughness of the surface after the stroke, um."""
