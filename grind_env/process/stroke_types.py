"""Inputs and results of a stroke, as named tuples of floats.

Named tuples, because numba passes them by value into the inlined stroke function and LLVM keeps their fields
in (vector) registers. The symbols are those of the literature; units are mm, s, N, W, J, K rise unless stated.
"""

from typing import NamedTuple


class WheelState(NamedTuple):
    """State of the wheel and of its dressing diamond. An agent sees `ds` only."""

    ds: float  #: diameter, mm
    A: float  #: wear-flat area, fraction of the wheel surface
    lam: float  #: loading, 0 (clean) to 1, no unit
    V: float  #: specific volume removed since the last dress, mm3/mm
    Rd: float  #: roughness that the last dress left on the wheel, um
    Cd: float  #: active grain density that the last dress left, 1/mm2
    W: float  #: radial wear since the wheel face was last measured (touch-off, gauge or dress), mm
    wd: float  #: width of the wear flat on the dressing diamond, mm


class StrokeParameters(NamedTuple):
    """Everything about material, wheel, fluid, dresser and machine that a stroke or a dress needs."""

    u_ch: float  #: chip formation energy, J/mm3
    e_ch: float  #: heat that leaves with the chips, J/mm3
    kp: float  #: ploughing pressure of a wheel with reference grain density, N/mm2
    mu: float  #: friction of the wear flats, a ratio of forces
    kc: float  #: ratio of normal to tangential force of chip formation and ploughing
    pm: float  #: factor of this material on the wear-flat pressure
    pa: float  #: wear-flat pressure at zero curvature difference, N/mm2
    pb: float  #: slope of the wear-flat pressure over the curvature difference, N/mm
    a0: float  #: depth that the contact of wear flats keeps where nothing is cut, mm
    AL: float  #: flat area that full loading adds, fraction of the wheel surface
    E_star: float  #: contact modulus of wheel and work, N/mm2
    Rr: float  #: roughness factor of the contact length
    beta: float  #: thermal effusivity of the work, J/(m2 K s^0.5)
    alpha: float  #: thermal diffusivity of the work, mm2/s
    krw: float  #: heat that a sharp grain takes over that of the work, times the root of the wheel speed, (m/s)^0.5
    hf: float  #: convection coefficient of the fluid at the reference wheel speed and contact length, W/(m2 K)
    Tb: float  #: temperature rise at which the fluid film boils, K
    kfilm: float  #: share of the convection that is left when the film has boiled off
    u0: float  #: burn threshold at vanishing contact, J/mm3
    Bm: float  #: slope of the burn threshold, J/(mm2 s^0.5)
    Gref: float  #: G-ratio at the reference chip thickness, without early wear and fracture
    mG: float  #: exponent of the wear over equivalent chip thickness
    fc: float  #: force per grain above which bond and grain fracture, N
    kf: float  #: strength of the fracture wear, no unit
    wi: float  #: radius that the wheel loses early after a medium dress, mm
    Vi: float  #: volume over which the early wear decays, mm3/mm
    dr: float  #: wear depth that renews the wheel surface, mm
    kA: float  #: wear-flat growth, 1/mm of grain sliding
    kL: float  #: loading rate, 1 per mm3/mm
    Af: float  #: wear-flat area of a surface that has just fractured, fraction of the wheel surface
    Amax: float  #: upper limit of the wear-flat area, fraction of the wheel surface
    Cref: float  #: grain density after the reference dress, 1/mm2
    Vr: float  #: volume over which the dressed topography relaxes, mm3/mm
    RaRef: float  #: roughness scale of the wheel after the reference dress, um
    f0: float  #: floor of the roughness, as a ratio to its scale
    f1: float  #: term of the roughness at the reference removal rate, as a ratio to its scale
    ra_scale: float  #: factor on the roughness for this individual wheel and part; 1 nominally
    #: factor of this material on the G-ratio, no unit; the roughness depends on the wheel wear over this factor
    gm: float
    nr: float  #: exponent of the roughness over the wheel wear
    Ad: float  #: wear-flat area after the reference dress, fraction of the wheel surface
    dd: float  #: depth of the damaged layer that a dress has to remove, mm
    b0: float  #: active width of the new dresser at the reference depth, mm
    nf: float  #: exponent of the roughness that a dress leaves over its lead
    na: float  #: exponent of the roughness that a dress leaves over its depth
    nw: float  #: exponent of the roughness that a dress leaves over the blunting of the diamond, which smooths
    qr: float  #: effect of a rotary dresser's speed ratio on the roughness that it leaves; 1 for a diamond that stands
    qs: float  #: effect of a rotary dresser's speed ratio on the severity of a dress; 1 for a diamond that stands
    bs: float  #: wheel width, mm
    ke: float  #: stiffness of the loop of machine, wheel and work, N/mm
    power: float  #: power limit of the spindle above idle, W
    rs: float  #: share of the wheel speed to which overload slows the spindle before it stalls
    stall_time: float  #: time lost when the spindle stalls, s
    n: float  #: wheel speed at constant rpm, 1/s; 0 for constant surface speed
    vs_set: float  #: wheel surface speed at constant surface speed, m/s; 0 for constant rpm
    per_capacity: float  #: one over the heat capacity of the part for each mm of its length, K mm/J
    w_1: float  #: share of a stroke's heat in the first, slowest mode of the part's temperature, no unit
    w_2: float  #: share of a stroke's heat in the second mode of the part's temperature, no unit
    w_3: float  #: share of a stroke's heat in the third mode of the part's temperature, no unit
    w_4: float  #: share of a stroke's heat in the fourth, fastest mode of the part's temperature, no unit
    r_1: float  #: rate at which the first mode decays, 1/s
    r_2: float  #: rate at which the second mode decays, 1/s
    r_3: float  #: rate at which the third mode decays, 1/s
    r_4: float  #: rate at which the fourth mode decays, 1/s
    swell: float  #: growth in height of the part for each K, mm/K


#: parameters that scale all forces of a stroke if one factor multiplies them; power, heat and deflection follow
FORCES = ("u_ch", "kp", "pa", "pb")


class StrokeConstants(NamedTuple):
    """Constants of the strokes of a cycle, from `StrokeParameters`, table speed and length.

    `per_X` is 1/X: a division takes as long as ten multiplications. Fields without a text are those of
    `StrokeParameters`.
    """

    n: float
    vs_set: float
    vw: float  #: table speed, mm/s
    Lw: float  #: ground length, mm
    pa: float  #: wear-flat pressure on this material at zero curvature difference, N/mm2
    pb: float  #: slope of the wear-flat pressure over 1/(de vs), N/mm2 times mm times m/s
    AL: float
    kp: float
    mu: float
    kc: float
    u_ch: float
    sa: float  #: root of the threshold depth, mm^0.5
    per_ke: float
    Cref: float
    per_Cref: float
    per_Vr: float
    power: float
    rs: float
    stall: float  #: rs over the power limit, 1/W
    stall_time: float
    flattening: float  #: 8 Rr^2/(pi E*), mm2/N
    krw: float
    beta: float
    peclet: float  #: Peclet number over the contact length, 1/mm
    e_ch: float
    hf: float  #: convection times `heat.CARRYING`, W/(m2 K) (mm s/m)^0.5
    kfilm: float
    Tb: float
    u0: float
    Bm: float
    per_G: float  #: 1/Gref, a ratio of volumes
    mG: float
    per_fc: float
    kf: float
    wi: float
    per_Vi: float
    per_dr: float
    turned: float  #: revolutions of the wheel in a stroke, times diameter over wheel speed, mm/(m/s)
    kA: float
    kL: float
    Af: float
    Amax: float
    per_Amax: float
    RaRef: float
    f0: float
    f1: float
    log_gm: float  #: logarithm of gm, no unit
    nr: float
    least_chips: float  #: logarithm of the wear factor at the chip thickness below which grains only plough, no unit
    ra_scale: float
    per_vw: float  #: one over the table speed, s/mm
    per_capacity: float  #: one over the heat capacity of the part for each mm of its length, K mm/J
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

    ae: float  #: real depth of cut, mm
    Q: float  #: specific removal rate, mm2/s
    heq: float  #: equivalent chip thickness, um
    Ft: float  #: tangential force per width, N/mm
    Fn: float  #: normal force per width, N/mm
    power: float  #: grinding power above idle, W; at most the limit of the spindle
    u_s: float  #: specific energy, J/mm3; 0 where nothing is cut
    lc: float  #: contact length, mm
    fg: float  #: normal force per active grain, N
    vs: float  #: wheel speed, m/s: less than set where the spindle has reached its power limit
    #: spindle load that the drive shows, W: torque times set speed; equal to the power unless the spindle slows
    load: float
    mean_load: float  #: mean of the spindle load over time, W
    #: ratio of the torque to the stall torque; from 1 on the spindle has stalled, and the other numbers are invalid
    torque: float
    T: float  #: surface temperature rise, K
    heat: float  #: power that enters the part, W
    eps: float  #: energy partition: share of the power that enters the work
    burn_ratio: float  #: burn ratio: power over the power at which the work burns (Malkin)
    G: float  #: G-ratio, with early wear; 0 where nothing is cut
    dw: float  #: radial wheel wear of the stroke, mm
    worn: float  #: wheel volume worn in the stroke, mm3
    Rg: float  #: roughness that the wheel generates, um
    Ra: float  #: roughness of the surface after the stroke, um
