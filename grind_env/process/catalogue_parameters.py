"""Process parameters from catalogue entries: of a stroke, of its price, and of a good part."""

import math

from grind_env.process import equations as eq
from grind_env.process.cost import Limits, Rates
from grind_env.process.entries import ALUMINA, Dresser, Fluid, Machine, Material, Wheel
from grind_env.process.equations.part_slab import slab_modes
from grind_env.process.stroke_types import StrokeParameters

USUAL_HEIGHT = 20.0  #: height of a part if none is given, mm; the warming and growth of the part depend on it


def stroke_parameters(
    material: Material,
    wheel: Wheel,
    dresser: Dresser,
    fluid: Fluid,
    machine: Machine,
    *,
    wheel_speed: float,
    constant_surface_speed: bool = False,
    width: float,
    height: float,
) -> StrokeParameters:
    """Return the stroke parameters of a set-up.

    Args:
        material: material of the part.
        wheel: grinding wheel.
        dresser: dressing tool.
        fluid: coolant.
        machine: machine tool.
        wheel_speed: surface speed of the new wheel, m/s. The rpm stays constant as the wheel shrinks,
            unless the control holds the surface speed (12-41).
        constant_surface_speed: whether the control holds `wheel_speed`.
        width: width of the part, mm.
        height: height of the part, mm.
    """
    z, st = eq.fineness(wheel.grit_size), eq.density(wheel.grain_fraction)
    alumina = wheel.abrasive == ALUMINA
    on_wear = material.g_ratio_factor if alumina else material.g_ratio_factor_cbn
    hard = eq.hardness(wheel.fracture_force, eq.REFERENCE_GRADE if alumina else eq.REFERENCE_GRADE_CBN)
    heat_capacity = 1e-9 * material.density * material.specific_heat * height  # J/(mm2 K)
    r0 = eq.grain_contact_radius(z)
    shares, rates = slab_modes(
        0.001 * height,
        material.conductivity,
        material.density * material.specific_heat,
        fluid.part_cooling,
        machine.chuck_conductance,
    )
    # a factor on the heat equals the inverse factor on all that takes up heat
    hotter = material.heat_factor
    return StrokeParameters(
        u_ch=material.power_factor * material.chip_energy,
        e_ch=material.chip_heat,
        kp=material.power_factor * material.ploughing_pressure * fluid.ploughing_factor * eq.ploughing_share(z, st),
        mu=wheel.friction * fluid.friction_factor,
        kc=wheel.normal_force_ratio / fluid.force_ratio_factor,
        pm=material.power_factor * material.pressure_factor,
        pa=wheel.pressure_base,
        pb=wheel.pressure_slope,
        a0=wheel.threshold_depth,
        AL=wheel.loading_area,
        E_star=contact_modulus(material, wheel),
        Rr=wheel.contact_roughness,
        beta=material.effusivity / hotter,
        alpha=material.diffusivity,
        krw=0.97 * wheel.grain_conductivity / (material.effusivity * math.sqrt(r0)),
        hf=fluid.convection / hotter,
        Tb=fluid.boiling_rise,
        kfilm=fluid.film_share,
        u0=material.burn_energy / hotter,
        Bm=material.burn_factor / hotter,
        Gref=eq.graded_g_ratio(wheel.g_ratio, hard) * on_wear * fluid.g_ratio_factor**wheel.g_ratio_fluid,
        mG=material.g_ratio_exponent,
        fc=eq.bond_post_strength(wheel.fracture_force, z),
        kf=wheel.fracture_factor,
        wi=wheel.initial_wear,
        Vi=wheel.initial_wear_volume,
        dr=eq.graded_renewal(wheel.renewal_depth, hard),
        kA=material.wear_flat_growth * fluid.wear_flat_factor * eq.dulling(wheel.wear_flat_rate, z, st),
        kL=material.loading_rate * fluid.loading_factor,
        Af=wheel.wear_flat_floor,
        Amax=wheel.wear_flat_limit,
        Cref=eq.active_grains(wheel.grit_size, wheel.grain_fraction),
        Vr=wheel.settling_volume,
        RaRef=eq.grit_roughness(wheel.roughness, z, st),
        f0=wheel.roughness_floor,
        f1=wheel.roughness_rate,
        ra_scale=1.0,
        gm=on_wear,
        nr=wheel.roughness_wear_exponent,
        Ad=eq.fresh_flats(wheel.dressed_wear_flat, z, st),
        dd=wheel.damage_depth,
        b0=eq.dress_width(eq.REFERENCE_DEPTH, dresser.tip_radius, 0.0),
        nf=dresser.lead_exponent,
        na=dresser.depth_exponent,
        nw=dresser.blunting_exponent,
        qr=eq.speed_ratio_effect(dresser.speed_ratio, dresser.speed_ratio_exponent),
        qs=eq.speed_ratio_effect(dresser.speed_ratio, dresser.sharpness_exponent),
        bs=wheel.width,
        ke=machine.stiffness,
        power=machine.power_limit - machine.idle_power,
        rs=machine.stall_speed,
        stall_time=machine.stall_time,
        n=0.0 if constant_surface_speed else 1000.0 * wheel_speed / (math.pi * wheel.diameter),
        vs_set=wheel_speed if constant_surface_speed else 0.0,
        per_capacity=hotter / (heat_capacity * width),
        **{f"w_{mode}": share for mode, share in enumerate(shares, 1)},
        **{f"r_{mode}": rate for mode, rate in enumerate(rates, 1)},
        swell=material.thermal_expansion * height,
    )


def rates_of(wheel: Wheel, dresser: Dresser, machine: Machine) -> Rates:
    """Return the prices of a set-up."""
    return Rates(machine.hourly_rate, wheel.price, dresser.cost_per_dress)


def limits_of(
    material: Material, machine: Machine, *, rise_allowance: float, roughness_limit: float, tolerance: float
) -> Limits:
    """Return the limits of a good part; the power limit is that of the machine less idle power.

    Args:
        material: material of the part.
        machine: machine tool.
        rise_allowance: temperature rise allowed beyond tempering, K.
        roughness_limit: highest Ra, um; 0 for none.
        tolerance: limit of the size error, um; 0 for none.
    """
    return Limits(
        material.tempering_rise + rise_allowance, machine.power_limit - machine.idle_power, roughness_limit, tolerance
    )


def contact_modulus(material: Material, wheel: Wheel) -> float:
    """Return the contact modulus E* of wheel and work (Hertz), N/mm2."""
    wheel_compliance = (1.0 - wheel.poisson_ratio**2) / (1000.0 * wheel.youngs_modulus)
    work_compliance = (1.0 - material.poisson_ratio**2) / (1000.0 * material.youngs_modulus)
    return 1.0 / (wheel_compliance + work_compliance)
