"""The relations of the process model, one function each.

Scalar, in the symbols of the literature; units are mm, s, N, W, J and K rise, except wheel speed `vs` m/s,
equivalent chip thickness and roughness um, effusivity and heat flux SI. In these units J/mm3 * mm2/s / (m/s)
is N/mm and W/mm / mm is W/mm2, so the force equations need no factors.

Sources: [M] Malkin, Grinding Technology; [R] Rowe, Principles of Modern Grinding Technology; [W] Wen, Tay & Nee
1992; [D] fitted to the measured data of `make validate`; [C] calibrated for this model so that magnitudes and trends
come out right.
"""

from grind_env.process.equations.cutting import (
    chip_force,
    contact_length,
    curvature_difference,
    cut_root,
    depth_of_cut,
    flat_area,
    force_per_grain,
    freshness,
    grain_density,
    ploughing_pressure,
    pressed_share,
    rubbing_length,
    specific_energy,
    threshold_force,
    wear_flat_pressure,
    wheel_speed,
)
from grind_env.process.equations.dressing import (
    REFERENCE_DEPTH,
    REFERENCE_LEAD,
    blunting,
    dress_width,
    dressed_density,
    dressed_flat_area,
    dressed_roughness,
    dressed_volume,
    overlap_ratio,
    restoration,
    restored_fraction,
    severity,
    sharpening_effort,
    speed_ratio_effect,
)
from grind_env.process.equations.heat import (
    CARRYING,
    burn_power,
    burn_ratio,
    conductances,
    cooled,
    energy_partition,
    film_conductance,
    heat_flow,
    jaeger_factor,
    part_growth,
    part_heating,
    retained_heat,
    temperature,
)
from grind_env.process.equations.roughness import (
    INITIAL_ROUGHNESS,
    PLOUGHING_CHIP,
    generated_roughness,
    roughening,
    surface_roughness,
    wheel_roughness,
)
from grind_env.process.equations.spindle import slowing
from grind_env.process.equations.wear import (
    LEAST_DIAMETER,
    early_loss,
    early_wear,
    fracture,
    g_ratio,
    grain_sliding,
    log_chip_wear,
    steady_wear,
    turning,
    wear_flat_growth,
    worn_diameter,
    worn_flat_area,
)
from grind_env.process.equations.wheel_composition import (
    REFERENCE_GRADE,
    REFERENCE_GRADE_CBN,
    RENEWAL_EXPONENT,
    active_grains,
    bond_post_strength,
    density,
    dulling,
    fineness,
    fresh_flats,
    graded_g_ratio,
    graded_renewal,
    grain_contact_radius,
    grit_roughness,
    hardness,
    ploughing_share,
)
