"""The relations of the process model, one function each.

Scalar, in the symbols of the literature; units are mm, s, N, W, J and K rise, except wheel speed `vs` m/s,
equivalent chip thickness, waviness and roughness um, effusivity and heat flux SI. With these J/mm3 * mm2/s / (m/s)
is N/mm and W/mm / mm is W/mm2, so the force equations need no factors.

Sources: [M] Malkin, Grinding Technology; [R] Rowe, Principles of Modern Grinding Technology; [W] Wen, Tay & Nee
1992; [C] calibrated for this model so that magnitudes and trends come out right.
"""

from grind_env.process.equations.cutting import (
    SMALLEST_CUT,
    chip_force,
    contact_length,
    curvature_difference,
    depth_of_cut,
    flat_area,
    force_per_grain,
    grain_density,
    grinding_stiffness,
    normal_force,
    ploughing_force,
    sliding_force,
    specific_energy,
    tangential_force,
    wear_flat_pressure,
    wheel_speed,
)
from grind_env.process.equations.dressing import (
    dress_width,
    dressed_density,
    dressed_flat_area,
    dressed_roughness,
    dressed_volume,
    overlap_ratio,
    restoration,
    restored_fraction,
    sharpening_effort,
)
from grind_env.process.equations.heat import (
    burn_threshold,
    jaeger_factor,
    temperature,
    thermal_bow,
    work_conductance,
    work_partition,
)
from grind_env.process.equations.roughness import (
    INITIAL_ROUGHNESS,
    generated_roughness,
    surface_roughness,
    wheel_roughness,
)
from grind_env.process.equations.wear import (
    LEAST_DIAMETER,
    g_ratio,
    grain_sliding,
    waviness,
    wear_flat_growth,
    worn_diameter,
    worn_flat_area,
)

__all__ = [
    "INITIAL_ROUGHNESS",
    "LEAST_DIAMETER",
    "SMALLEST_CUT",
    "burn_threshold",
    "chip_force",
    "contact_length",
    "curvature_difference",
    "depth_of_cut",
    "dress_width",
    "dressed_density",
    "dressed_flat_area",
    "dressed_roughness",
    "dressed_volume",
    "flat_area",
    "force_per_grain",
    "g_ratio",
    "generated_roughness",
    "grain_density",
    "grain_sliding",
    "grinding_stiffness",
    "jaeger_factor",
    "normal_force",
    "overlap_ratio",
    "ploughing_force",
    "restoration",
    "restored_fraction",
    "sharpening_effort",
    "sliding_force",
    "specific_energy",
    "surface_roughness",
    "tangential_force",
    "temperature",
    "thermal_bow",
    "waviness",
    "wear_flat_growth",
    "wear_flat_pressure",
    "wheel_roughness",
    "wheel_speed",
    "work_conductance",
    "work_partition",
    "worn_diameter",
    "worn_flat_area",
]
