"""Inputs and results of a stroke, as named tuples of floats.

Named tuples, because numba passes them by value into the inlined stroke function and LLVM keeps their fields
in (vector) registers. The symbols are those of the literature; units are mm, s, N, W, J, K rise unless stated.
"""

from typing import NamedTuple


class WheelState(NamedTuple):
    """State of the wheel and of its dressing diamond. An agent sees `ds` only."""

    ds: float
    """Diameter, mm."""
    A: float
    """Wear-flat area, fraction of the wheel surface."""
    lam: float
    """Loading, 0 (clean) to 1, no unit."""
    V: float
    """Specific volume removed since the last dress, mm3/mm."""
    Rd: float
    """Roughness that the last dress left on the wheel, um."""
    Cd: float
    """Active grain density that the last dress left, 1/mm2."""
    W: float
    """Radial wear since the wheel face was last measured (touch-off, gauge or dress), mm."""
    wd: float
    """Width of the wear flat on the dressing diamond, mm."""


class StrokeParameters(NamedTuple):
    """Everything about material, wheel, fluid, dresser and machine that a stroke or a dress needs."""

    u_ch: float
    """Chip formation energy, J/mm3."""
    e_ch: float
    """Heat that leaves with the chips, J/mm3."""
    kp: float
    """Ploughing pressure of a wheel with reference grain density, N/mm2."""
    mu: float
    """Friction of the wear flats, a ratio of forces."""
    kc: float
    """Ratio of normal to tangential force of chip formation and ploughing."""
    pm: float
    """Factor of this material on the wear-flat pressure."""
    pa: float
    """Wear-flat pressure at zero curvature difference, N/mm2."""
    pb: float
    """Slope of the wear-flat pressure over the curvature difference, N/mm."""
    a0: float
    """Depth that the contact of wear flats keeps where nothing is cut, mm."""
    AL: float
    """Flat area that full loading adds, fraction of the wheel surface."""
    E_star: float
    """Contact modulus of wheel and work, N/mm2."""
    Rr: float
    """Roughness factor of the contact length."""
    beta: float
    """Thermal effusivity of the work, J/(m2 K s^0.5)."""
    alpha: float
    """Thermal diffusivity of the work, mm2/s."""
    krw: float
    """Heat that a sharp grain takes over that of the work, times the root of the wheel speed, (m/s)^0.5."""
    hf: float
    """Convection coefficient of the fluid at the reference wheel speed and contact length, W/(m2 K)."""
    Tb: float
    """Temperature rise at which the fluid film boils, K."""
    kfilm: float
    """Share of the convection that is left when the film has boiled off."""
    u0: float
    """Burn threshold at vanishing contact, J/mm3."""
    Bm: float
    """Slope of the burn threshold, J/(mm2 s^0.5)."""
    Gref: float
    """G-ratio at the reference chip thickness, without early wear and fracture."""
    mG: float
    """Exponent of the wear over equivalent chip thickness."""
    fc: float
    """Force per grain above which bond and grain fracture, N."""
    kf: float
    """Strength of the fracture wear, no unit."""
    wi: float
    """Radius that the wheel loses early after a medium dress, mm."""
    Vi: float
    """Volume over which the early wear decays, mm3/mm."""
    dr: float
    """Wear depth that renews the wheel surface, mm."""
    kA: float
    """Wear-flat growth, 1/mm of grain sliding."""
    kL: float
    """Loading rate, 1 per mm3/mm."""
    Af: float
    """Wear-flat area of a surface that has just fractured, fraction of the wheel surface."""
    Amax: float
    """Upper limit of the wear-flat area, fraction of the wheel surface."""
    Cref: float
    """Grain density after the reference dress, 1/mm2."""
    Vr: float
    """Volume over which the dressed topography relaxes, mm3/mm."""
    RaRef: float
    """Roughness scale of the wheel after the reference dress, um."""
    f0: float
    """Floor of the roughness, as a ratio to its scale."""
    f1: float
    """Term of the roughness at the reference removal rate, as a ratio to its scale."""
    ra_scale: float
    """Factor on the roughness for this individual wheel and part; 1 nominally."""
    gm: float
    """Factor of this material on the G-ratio, no unit; the roughness depends on the wheel wear over this factor."""
    nr: float
    """Exponent of the roughness over the wheel wear."""
    Ad: float
    """Wear-flat area after the reference dress, fraction of the wheel surface."""
    dd: float
    """Depth of the damaged layer that a dress has to remove, mm."""
    b0: float
    """Active width of the new dresser at the reference depth, mm."""
    nf: float
    """Exponent of the roughness that a dress leaves over its lead."""
    na: float
    """Exponent of the roughness that a dress leaves over its depth."""
    nw: float
    """Exponent of the roughness that a dress leaves over the blunting of the diamond, which smooths."""
    qr: float
    """Effect of a rotary dresser's speed ratio on the roughness that it leaves; 1 for a diamond that stands."""
    qs: float
    """Effect of a rotary dresser's speed ratio on the severity of a dress; 1 for a diamond that stands."""
    bs: float
    """Wheel width, mm."""
    ke: float
    """Stiffness of the loop of machine, wheel and work, N/mm."""
    power: float
    """Power limit of the spindle above idle, W."""
    rs: float
    """Share of the wheel speed to which overload slows the spindle before it stalls."""
    stall_time: float
    """Time lost when the spindle stalls, s."""
    n: float
    """Wheel speed at constant rpm, 1/s; 0 for constant surface speed."""
    vs_set: float
    """Wheel surface speed at constant surface speed, m/s; 0 for constant rpm."""
    per_capacity: float
    """One over the heat capacity of the part for each mm of its length, K mm/J."""
    w_1: float
    """Share of a stroke's heat in the first, slowest mode of the part's temperature, no unit."""
    w_2: float
    """Share of a stroke's heat in the second mode of the part's temperature, no unit."""
    w_3: float
    """Share of a stroke's heat in the third mode of the part's temperature, no unit."""
    w_4: float
    """Share of a stroke's heat in the fourth, fastest mode of the part's temperature, no unit."""
    r_1: float
    """Rate at which the first mode decays, 1/s."""
    r_2: float
    """Rate at which the second mode decays, 1/s."""
    r_3: float
    """Rate at which the third mode decays, 1/s."""
    r_4: float
    """Rate at which the fourth mode decays, 1/s."""
    swell: float
    """Growth in height of the part for each K, mm/K."""


FORCES = ("u_ch", "kp", "pa", "pb")
"""Parameters that scale all forces of a stroke if one factor multiplies them; power, heat and deflection follow."""


class StrokeConstants(NamedTuple):
    """Constants of the strokes of a cycle, from `StrokeParameters`, table speed and length.

    `per_X` is 1/X: a division takes as long as ten multiplications. Fields without a text are those of
    `StrokeParameters`.
    """

    n: float
    vs_set: float
    vw: float
    """Table speed, mm/s."""
    Lw: float
    """Ground length, mm."""
    pa: float
    """Wear-flat pressure on this material at zero curvature difference, N/mm2."""
    pb: float
    """Slope of the wear-flat pressure over 1/(de vs), N/mm2 times mm times m/s."""
    AL: float
    kp: float
    mu: float
    kc: float
    u_ch: float
    sa: float
    """Root of the threshold depth, mm^0.5."""
    per_ke: float
    Cref: float
    per_Cref: float
    per_Vr: float
    power: float
    rs: float
    stall: float
    """rs over the power limit, 1/W."""
    stall_time: float
    flattening: float
    """8 Rr^2/(pi E*), mm2/N."""
    krw: float
    beta: float
    peclet: float
    """Peclet number over the contact length, 1/mm."""
    e_ch: float
    hf: float
    """Convection times `heat.CARRYING`, W/(m2 K) (mm s/m)^0.5."""
    kfilm: float
    Tb: float
    u0: float
    Bm: float
    per_G: float
    """1/Gref, a ratio of volumes."""
    mG: float
    per_fc: float
    kf: float
    wi: float
    per_Vi: float
    per_dr: float
    turned: float
    """Revolutions of the wheel in a stroke, times diameter over wheel speed, mm/(m/s)."""
    kA: float
    kL: float
    Af: float
    Amax: float
    per_Amax: float
    RaRef: float
    f0: float
    f1: float
    log_gm: float
    """Logarithm of gm, no unit."""
    nr: float
    least_chips: float
    """Logarithm of the wear factor at the chip thickness below which grains only plough, no unit."""
    ra_scale: float
    per_vw: float
    """One over the table speed, s/mm."""
    per_capacity: float
    """One over the heat capacity of the part for each mm of its length, K mm/J."""
    w_1: float
    w_2: float
    w_3: float
    w_4: float
    r_1: float
    r_2: float
    r_3: float
    r_4: float
    swell: float


class StrokeResult(NamedTuple):
    """Results of one stroke: the quantities that a record shows.

    Where the table is slower than E over some of the part, `ae`, `dw`, `worn`, `Rg` and `Ra` are means over its length,
    `load`, `torque`, `T` and `burn_ratio` the highest values, and all others means over time.
    """

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
    """Grinding power above idle, W; at most the limit of the spindle."""
    u_s: float
    """Specific energy, J/mm3; 0 where nothing is cut."""
    lc: float
    """Contact length, mm."""
    fg: float
    """Normal force per active grain, N."""
    vs: float
    """Wheel speed, m/s: less than set where the spindle has reached its power limit."""
    load: float
    """Spindle load that the drive shows, W: torque times set speed; equal to the power unless the spindle slows."""
    mean_load: float
    """Mean of the spindle load over time, W."""
    torque: float
    """Ratio of the torque to the stall torque; from 1 on the spindle has stalled, and the other numbers are invalid."""
    T: float
    """Surface temperature rise, K."""
    heat: float
    """Power that enters the part, W."""
    eps: float
    """Energy partition: share of the power that enters the work."""
    burn_ratio: float
    """Burn ratio: power over the power at which the work burns (Malkin)."""
    G: float
    """G-ratio, with early wear; 0 where nothing is cut."""
    dw: float
    """Radial wheel wear of the stroke, mm."""
    worn: float
    """Wheel volume worn in the stroke, mm3."""
    Rg: float
    """Roughness that the wheel generates, um."""
    Ra: float
    """Roughness of the surface after the stroke, um."""
