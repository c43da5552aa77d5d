"""Second implementation of the process model in plain scalar Python, from its specification and not from the package.

It searches where the package has closed forms: for the depth of cut and the speed of an overloaded spindle. From the
package it takes only the catalogue. Units are mm, s, N, W, J, K; roughness and chips um, wheel speeds m/s. Forces,
powers and removal rates are per mm of width.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, exp, pi, sin, sqrt

import numpy as np

from grind_env.process.entries import Dresser, Fluid, Machine, Material, Wheel


@dataclass(frozen=True)
class Setup:
    """Material, wheel, dresser, fluid and machine of a cut, with its speeds and sizes."""

    material: Material
    wheel: Wheel
    dresser: Dresser
    fluid: Fluid
    machine: Machine
    wheel_speed: float  #: speed of the new wheel; the rpm are constant
    table_speed: float
    width: float = 20.0  #: width of the part, all of it engaged
    height: float = 20.0
    length: float = 200.0

    @cached_property
    def modes(self) -> tuple[list[float], list[float]]:
        """Shares and time constants of the part's heat."""
        return modes_of(self)


@dataclass(frozen=True)
class State:
    """State of wheel, diamond and part with their positions; `dT` is the part's rise by mode."""

    ds: float
    A: float = 0.0
    lam: float = 0.0
    V: float = 0.0
    Rd: float = 0.0
    Cd: float = 0.0
    W: float = 0.0
    wd: float = 0.0
    Z: float = 0.0
    S: float = 0.0
    Rs: float = 1.6
    dT: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)


def zero_of(falling: Callable[[float], float], low: float, high: float) -> float:
    """Return the zero of a falling function by bisection to neighbouring floats, or an end if there is none."""
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if falling(middle) > 0.0 else (low, middle)
    return high if falling(high) >= 0.0 else low


def clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


# --- combinations of material, wheel and fluid ----------------------------------------------------------------


def fineness(wheel: Wheel) -> float:
    return 0.25 / wheel.grit_size


def structure(wheel: Wheel) -> float:
    return wheel.grain_fraction / 0.52


def grains(wheel: Wheel) -> float:
    """Return the grain density after a medium dress, 1/mm2."""
    return 0.36 * wheel.grain_fraction / wheel.grit_size**2


def smoothness(wheel: Wheel) -> float:
    """Return the scale of the roughness."""
    return wheel.roughness * fineness(wheel) ** -0.7 * structure(wheel) ** -0.3


def hardness(wheel: Wheel) -> float:
    """Return the hardness of the grade relative to the reference grade."""
    return wheel.fracture_force / (1.2 if wheel.abrasive == "alumina" else 4.0)


def durability(at: Setup) -> float:
    """Return the G-ratio factor of this material relative to hardened steel."""
    return at.material.g_ratio_factor if at.wheel.abrasive == "alumina" else at.material.g_ratio_factor_cbn


# --- a dress --------------------------------------------------------------------------------------------------


def dressed(state: State, at: Setup, passes: float, lead: float, depth: float) -> State:
    wheel, tool = at.wheel, at.dresser
    blunt = 1.0 + state.wd / (2.0 * sqrt(2.0 * tool.tip_radius * 0.02 - 0.02**2))
    q = max(tool.speed_ratio, 0.1) / 0.6
    severity = depth / 0.02 * sqrt(lead / 0.1) * q**tool.sharpness_exponent / blunt
    flats = wheel.dressed_wear_flat * sqrt(fineness(wheel) * structure(wheel)) * (0.25 + 0.75 / sqrt(severity))
    left = smoothness(wheel) * (lead / 0.1) ** tool.lead_exponent * (depth / 0.02) ** tool.depth_exponent
    left *= blunt**-tool.blunting_exponent * q**tool.speed_ratio_exponent
    kept = exp(-passes * depth / (wheel.damage_depth * (1.0 + state.lam + state.A / 0.05)))
    return replace(
        state,
        ds=state.ds - 2.0 * passes * depth,
        A=flats + kept * (state.A - flats),
        lam=kept * state.lam,
        V=kept * state.V,
        Rd=left + kept * (state.Rd - left),
        Cd=grains(wheel) * severity**-0.25 + kept * (state.Cd - grains(wheel) * severity**-0.25),
        W=0.0,
        wd=state.wd,
    )


def dressed_off(state: State, at: Setup, passes: float, depth: float) -> float:
    """Return the wheel volume that a dress removes, mm3."""
    return passes * depth * pi * state.ds * at.wheel.width


def fresh(at: Setup, lead: float = 0.10, depth: float = 0.020, *, diameter: float = 300.0, wd: float = 0.0) -> State:
    """Return a wheel dressed until nothing of its old face is left."""
    wheel = dressed(State(diameter, wd=wd), at, 1e9, lead, depth)
    return replace(wheel, ds=diameter, wd=wd)


# --- a stroke -------------------------------------------------------------------------------------------------


def faded(state: State, wheel: Wheel) -> float:
    """Return the share of the dressed topography that is left."""
    return exp(-state.V / wheel.settling_volume)


def density(state: State, wheel: Wheel) -> float:
    """Return the density of active grains, 1/mm2."""
    return 1.1 * grains(wheel) + (state.Cd - 1.1 * grains(wheel)) * faded(state, wheel)


def pressures(state: State, at: Setup, speed: float) -> tuple[float, float]:
    """Return tangential and normal force per mm2 of contact by flats and ploughing grains, without chips."""
    mat, wheel, fluid = at.material, at.wheel, at.fluid
    difference = 4.0 * at.table_speed / (state.ds * speed * 1000.0)
    flats = mat.pressure_factor * (wheel.pressure_base + wheel.pressure_slope * difference)
    flats *= state.A + wheel.loading_area * state.lam
    ploughing = mat.ploughing_pressure * fluid.ploughing_factor * sqrt(fineness(wheel) * structure(wheel))
    ploughing *= sqrt(density(state, wheel) / grains(wheel)) * (1.0 + 0.5 * state.lam)
    return ploughing + wheel.friction * fluid.friction_factor * flats, normal_force_ratio(at) * ploughing + flats


def normal_force_ratio(at: Setup) -> float:
    return at.wheel.normal_force_ratio / at.fluid.force_ratio_factor


def heated(state: State, at: Setup, Q: float, power: float, length: float, lc: float, vs: float) -> dict[str, float]:
    """Return the rise of the surface, the share of power entering the part, and the burn ratio."""
    mat, wheel, vw = at.material, at.wheel, at.table_speed
    if power <= 0.0:
        return {"T": 0.0, "eps": 0.0, "burn_ratio": 0.0}
    contact = 20e-6 / sqrt(fineness(wheel))
    sink = 0.97 * wheel.grain_conductivity / (mat.effusivity * sqrt(contact * (1.0 + 20.8 * state.A) * vs))
    jaeger = 1.16 / (1.0 + 0.29 * (vw * lc / (4.0 * mat.diffusivity)) ** -0.75)
    work = mat.effusivity * sqrt(vw * lc / jaeger)
    film = at.fluid.convection * sqrt(vs / 30.0) * sqrt(2.4 * lc) * (1.0 - 0.5 * state.lam)
    kept = 1e6 * (power - min(mat.chip_heat * Q, 0.45 * power))
    wet, boiled = (kept / (work * (1.0 + sink) + left * film) for left in (1.0, at.fluid.film_share))
    y = clip((wet - at.fluid.boiling_rise) / 20.0 + 0.5, 0.0, 1.0)
    T = wet + (boiled - wet) * y * y * (3.0 - 2.0 * y)
    burning = mat.burn_energy * Q + 0.88 * mat.burn_factor * (1.0 + sink) * sqrt(length * vw)
    return {"T": T, "eps": T * work / (1e6 * power), "burn_ratio": power / burning}


def fractured(at: Setup, fg: float) -> float:
    z = fg / (at.wheel.fracture_force * fineness(at.wheel) ** -1.5) - 1.0
    return 1.0 + 0.5 * at.wheel.fracture_factor * (z + sqrt(z * z + 0.1))


def thickened(at: Setup, heq: float) -> float:
    return float((heq / 0.1) ** at.material.g_ratio_exponent)


def worn(state: State, at: Setup, dV: float, heq: float, fg: float) -> tuple[float, float]:
    """Return the steady and the early loss of wheel radius."""
    wheel = at.wheel
    G = wheel.g_ratio * sqrt(hardness(wheel)) * durability(at) * at.fluid.g_ratio_factor**wheel.g_ratio_fluid
    steady = dV * fractured(at, fg) * thickened(at, max(heq, 0.001)) / G / (pi * state.ds)
    loss = wheel.initial_wear * (grains(wheel) / state.Cd) ** 4
    before, after = ((1.0 + V / wheel.initial_wear_volume) ** -2 for V in (state.V, state.V + dV))
    return steady, loss * (before - after)


def grown(state: State, at: Setup, length: float, vs: float, T: float) -> float:
    """Return the growth of the flats before renewal."""
    wheel = at.wheel
    rate = at.material.wear_flat_growth * at.fluid.wear_flat_factor
    rate *= wheel.wear_flat_rate * fineness(wheel) * structure(wheel)
    sliding = 1000.0 * vs * at.length / (at.table_speed * pi * state.ds) * length
    return rate * sliding * exp(clip((T - 200.0) / 500.0, -1.0, 2.0)) * (1.0 - state.A / wheel.wear_flat_limit)


def generated(state: State, at: Setup, Q: float, vs: float, fg: float) -> float:
    """Return the roughness that the wheel generates."""
    wheel, scale = at.wheel, smoothness(at.wheel)
    texture = 0.9 * scale + (state.Rd - 0.9 * scale) * faded(state, wheel)
    nr, x = wheel.roughness_wear_exponent, 0.5 * (fractured(at, fg) - 1.0)
    worse = (thickened(at, max(Q / vs, 0.02)) / durability(at)) ** nr
    worse *= (1.0 + (1.0 + nr) * x) / (1.0 + (1.0 - nr) * x)  # for (1 + 2x)^nr, as the package has it
    rate = wheel.roughness_floor + wheel.roughness_rate * sqrt(Q / 3.0)
    return worse * texture * sqrt(30.0 / vs) * rate * (1.0 + 0.6 * state.lam)


def ground(state: State, at: Setup, downfeed: float, seconds: float) -> tuple[State, dict[str, float]]:
    """Return the state after one stroke of `seconds`, and the quantities of the stroke by their record names."""
    wheel, de, b, vw = at.wheel, state.ds, at.width, at.table_speed
    Z = state.Z + downfeed
    u = Z + at.material.thermal_expansion * at.height * sum(state.dT) - state.W - state.S
    speed = at.wheel_speed * de / wheel.diameter
    Kt, Kn = pressures(state, at, speed)

    def slack(ae: float) -> float:
        """Return the interference that the deflection at this depth does not take up."""
        chips = normal_force_ratio(at) * at.material.chip_energy * ae * vw / speed
        return u - ae - b / at.machine.stiffness * (chips + Kn * sqrt(de * (ae + wheel.threshold_depth)))

    ae = zero_of(slack, 0.0, max(u, 0.0))
    # contact of a wheel that only rubs: all of the interference is deflection
    rubs = max(u, 0.0) * at.machine.stiffness / (b * Kn)
    length = sqrt(de * (ae + wheel.threshold_depth)) if ae > 0.0 else rubs
    Q, limit = ae * vw, at.machine.power_limit - at.machine.idle_power
    chips = at.material.chip_energy * Q
    vs = zero_of(lambda v: limit - b * (chips + Kt * length * v), at.machine.stall_speed * speed, speed)
    Ft, Fn = chips / vs + Kt * length, normal_force_ratio(at) * chips / vs + Kn * length
    bodies = ((wheel.youngs_modulus, wheel.poisson_ratio), (at.material.youngs_modulus, at.material.poisson_ratio))
    yielding = sum((1.0 - ratio**2) / (1000.0 * modulus) for modulus, ratio in bodies)
    lc = sqrt(ae * de + 8.0 * wheel.contact_roughness**2 * Fn * de * yielding / pi)
    fg = Fn / (density(state, wheel) * lc) if lc > 0.0 else 0.0
    heat = heated(state, at, Q, Ft * vs, length, lc, vs)
    entering = heat["eps"] * Ft * vs * b
    dV = ae * at.length
    steady, early = worn(state, at, dV, Q / vs, fg)
    dw = steady + early
    renewed = min(steady / (wheel.renewal_depth * hardness(wheel) ** 1.35), 1.0)
    A = state.A + grown(state, at, length, vs, heat["T"]) - (state.A - wheel.wear_flat_floor) * renewed
    clogged = at.material.loading_rate * at.fluid.loading_factor * dV * (1.0 - state.lam)
    Rg, reach = generated(state, at, Q, vs, fg), 1000.0 * ae + clip(1000.0 * u, 0.0, 0.5)
    after = replace(
        state,
        ds=de - 2.0 * dw,
        A=min(A, wheel.wear_flat_limit),
        lam=state.lam + clogged - state.lam * renewed,
        V=state.V + dV,
        W=state.W + dw,
        Z=Z,
        S=state.S + ae,
        Rs=state.Rs + (Rg - state.Rs) * reach / (reach + 2.0 * state.Rs),
        dT=cooled(heated_by(state.dT, entering / (vw * capacity(at) * b), at), at, seconds),
    )
    return after, heat | {
        "ae": ae,
        "Q": Q,
        "heq": Q / vs,
        "Ft": Ft,
        "Fn": Fn,
        "power": min(b * Ft * vs, limit),
        "u_s": Ft * vs / Q if Q > 0.0 else 0.0,
        "lc": lc,
        "fg": fg,
        "vs": vs,
        "load": b * Ft * speed,
        "mean_load": b * Ft * speed,
        "torque": b * Ft * speed * at.machine.stall_speed / limit,
        "heat": entering,
        "G": dV / (pi * de * dw) if dV > 0.0 else 0.0,
        "dw": dw,
        "worn": pi * de * dw * b,
        "Rg": Rg,
        "Ra": after.Rs,
    }


# --- heat of the part -----------------------------------------------------------------------------------------


def capacity(at: Setup) -> float:
    """Return the heat capacity per mm2 of the part seen from above, J/K."""
    return 1e-9 * at.material.density * at.material.specific_heat * at.height


def mean_transform(s: float, at: Setup) -> float:
    """Return the Laplace transform of the mean rise after a pulse on top, relative to the initial rise."""
    k, H = at.material.conductivity, 0.001 * at.height
    q = sqrt(1e9 * capacity(at) / at.height * s / k)
    top, chuck, far = at.fluid.part_cooling, at.machine.chuck_conductance, exp(-q * H)
    # profile a exp(-q z) + b exp(-q (H - z)); a flux of 1 enters on top
    ends = [[k * q + top, (top - k * q) * far], [(chuck - k * q) * far, k * q + chuck]]
    a, b = np.linalg.solve(ends, [1.0, 0.0])
    return float(1e6 * capacity(at) * (a + b) * (1.0 - far) / (q * H))


def modes_of(at: Setup) -> tuple[list[float], list[float]]:
    """Return shares and time constants by least squares over the transforms, with sum and steady state fixed."""
    k, H, top, chuck = at.material.conductivity, 0.001 * at.height, at.fluid.part_cooling, at.machine.chuck_conductance
    Bt, Bb = top * H / k, chuck * H / k
    b = zero_of(lambda b: b * (Bt + Bb) * cos(b) - (b * b - Bt * Bb) * sin(b), 0.0, pi)
    slowest = 1e6 * capacity(at) * H / (k * b * b)
    fastest = min(0.12, slowest / 50.0)
    times = slowest * (fastest / slowest) ** (np.arange(4) / 3.0)
    s = np.array([0.03, 0.072, 0.173, 0.416, 1.0])
    exact = np.array([mean_transform(each, at) for each in s])
    seen = times / (1.0 + np.outer(s, times)) / exact[:, None]
    # Lagrange: the shares and the multipliers of the two conditions
    surface = 1.0 / (top + 1.0 / (H / k + 1.0 / chuck))
    lower = surface * (1.0 - H / k / (H / k + 1.0 / chuck))
    conditions = np.array([np.ones(4), times])
    system = np.block([[seen.T @ seen, conditions.T], [conditions, np.zeros((2, 2))]])
    wanted = np.concatenate([seen.sum(0), [1.0, 1e6 * capacity(at) * 0.5 * (surface + lower)]])
    return np.linalg.solve(system, wanted)[:4].tolist(), times.tolist()


def heated_by(dT: tuple[float, ...], warmer: float, at: Setup) -> tuple[float, ...]:
    """Return the modes after a stroke that would warm an uncooled part by `warmer`."""
    return tuple(rise + share * warmer for rise, share in zip(dT, at.modes[0], strict=True))


def cooled(dT: tuple[float, ...], at: Setup, seconds: float) -> tuple[float, ...]:
    """Return the modes after cooling by fluid and chuck."""
    return tuple(rise * exp(-seconds / time) for rise, time in zip(dT, at.modes[1], strict=True))


def waited(state: State, at: Setup, seconds: float) -> State:
    return replace(state, dT=cooled(state.dT, at, seconds))


def loaded(state: State) -> State:
    """Return the state after touching off on the next part, which is as warm as the hall."""
    return replace(state, Z=0.0, S=0.0, Rs=1.6, W=0.0, dT=(0.0,) * 4)
