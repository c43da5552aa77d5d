"""From catalogue entries to the numbers of the process model: of a stroke, of its price, and of a good part."""

import math

from grind_env.process.cost import Limits, Rates
from grind_env.process.entries import Dresser, Fluid, Machine, Material, Wheel
from grind_env.process.state import StrokeParameters


def stroke_parameters(
    material: Material,
    wheel: Wheel,
    dresser: Dresser,
    fluid: Fluid,
    machine: Machine,
    *,
    wheel_speed: float,
    constant_surface_speed: bool = False,
) -> StrokeParameters:
    """Parameters of a set-up.

    Args:
        material: of the part.
        wheel: grinding wheel.
        dresser: dressing tool.
        fluid: coolant.
        machine: machine tool.
        wheel_speed: surface speed of the new wheel, m/s. The rpm that gives it is kept as the wheel shrinks,
            unless the control holds the surface speed (12-41).
        constant_surface_speed: hold `wheel_speed` itself.
    """
    return StrokeParameters(
        u_ch=material.chip_energy,
        Fpl0=material.ploughing_force,
        kA=material.wear_flat_growth,
        kL=material.loading_rate,
        gm=material.g_ratio_factor,
        pm=material.pressure_factor,
        u0=material.burn_energy,
        Bm=material.burn_factor,
        beta=material.effusivity,
        alpha=material.diffusivity,
        Cref=wheel.grain_density,
        kg=wheel.grain_conductivity,
        mu=wheel.friction,
        kc=wheel.force_ratio,
        pa=wheel.pressure_base,
        pb=wheel.pressure_slope,
        Gref=wheel.g_ratio,
        mG=wheel.g_ratio_exponent,
        href=wheel.reference_chip_thickness,
        fc=wheel.fracture_force,
        kf=wheel.fracture_factor,
        dr=wheel.renewal_depth,
        RaRef=wheel.roughness,
        x=wheel.roughness_exponent,
        ra_scale=1.0,
        Af=wheel.wear_flat_floor,
        ka=wheel.wear_flat_rate,
        Amax=wheel.wear_flat_limit,
        AL=wheel.loading_area,
        Ad0=wheel.dressed_wear_flat,
        kU=wheel.dressed_wear_flat_slope,
        dd=wheel.damage_depth,
        Rr=wheel.contact_roughness,
        Vr=wheel.settling_volume,
        Vt=wheel.initial_wear_volume,
        kt=wheel.initial_wear_factor,
        Vchi=wheel.chatter_volume,
        ks=wheel.chatter_onset,
        kr=wheel.chatter_reference,
        alw0=wheel.waviness_floor,
        cw=wheel.waviness_passed,
        E_star=contact_modulus(material, wheel),
        hf=fluid.convection,
        Tb=fluid.boiling_rise,
        ke=machine.stiffness,
        n=0.0 if constant_surface_speed else 1000.0 * wheel_speed / (math.pi * wheel.diameter),
        vs_set=wheel_speed if constant_surface_speed else 0.0,
        bs=wheel.width,
        rd=dresser.tip_radius,
        kd=dresser.wear_rate,
    )


def rates_of(wheel: Wheel, dresser: Dresser, machine: Machine) -> Rates:
    """Prices of a set-up."""
    return Rates(machine.hourly_rate, wheel.price, dresser.cost_per_dress)


def limits_of(
    material: Material, machine: Machine, *, rise_allowance: float, roughness_limit: float, tolerance: float
) -> Limits:
    """Limits of a good part; that of the power is what the machine's limit leaves above idle.

    Args:
        material: of the part.
        machine: machine tool.
        rise_allowance: temperature rise allowed beyond that which tempers the material, K.
        roughness_limit: highest Ra, um; 0 for none.
        tolerance: on the size error, um; 0 for none.
    """
    return Limits(
        material.tempering_rise + rise_allowance,
        machine.power_limit - machine.idle_power,
        roughness_limit,
        tolerance,
    )


def contact_modulus(material: Material, wheel: Wheel) -> float:
    """Contact modulus E* of wheel and work (Hertz), N/mm2."""
    wheel_compliance = (1.0 - wheel.poisson_ratio**2) / (1000.0 * wheel.youngs_modulus)
    work_compliance = (1.0 - material.poisson_ratio**2) / (1000.0 * material.youngs_modulus)
    return 1.0 / (wheel_compliance + work_compliance)
