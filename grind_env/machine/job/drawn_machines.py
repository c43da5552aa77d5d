"""Machines drawn from the uncertainty of a job."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from grind_env.array_types import Array
from grind_env.errors import GrindError
from grind_env.machine.job.job import Job
from grind_env.machine.job.job_entries import entries_of, with_entries
from grind_env.machine.job.uncertainty import Uncertainty
from grind_env.process.catalogue import KINDS, UNCERTAINTY
from grind_env.process.entries import CatalogueError, Quantity, quantities

#: logarithmic standard deviations of the catalogue's numbers: the uncertainty of their sources
#: (`catalogue_data/*.toml`, 80 K of tempering; convection by a factor 1.5 to 2), and the differences of machines and
#: wheels of one name. Few rows of the validation test the effect of a dress and the early wear, so these spreads are
#: wide. The film of emulsion boils within 15 K of 130 degC. A flood cools by 1,000 to 6,000 W/(m2 K) and a chuck by
#: 1,000 to 3,000 (`catalogue_data`): nearly all of both is within 1.6 standard deviations. The height of a part has no
#: spread, because a job whose size is judged states it
USUAL_SPREADS: Mapping[str, float] = {
    "material.chip_energy": 0.15,
    "material.ploughing_pressure": math.log(1.5),
    "material.pressure_factor": 0.2,
    "material.wear_flat_growth": math.log(2.0),
    "material.loading_rate": math.log(3.0),
    "material.tempering_rise": 0.18,
    "wheel.dressed_wear_flat": 0.5,
    "wheel.damage_depth": math.log(2.0),
    "wheel.g_ratio": math.log(2.0),
    "wheel.renewal_depth": math.log(2.0),
    "wheel.initial_wear": math.log(1.5),
    "wheel.initial_wear_volume": math.log(2.0),
    "wheel.threshold_depth": math.log(1.5),
    "wheel.roughness": 0.25,
    "wheel.settling_volume": math.log(2.0),
    "fluid.convection": math.log(1.5),
    "fluid.boiling_rise": 0.15,
    "fluid.part_cooling": math.log(2.0),
    "machine.stiffness": 0.4,
    "machine.chuck_conductance": math.log(1.5),
}
#: residual and drift of the forces, which the catalogue does not explain. Models of grinding forces are within 10 to 20
#: %, of which the numbers explain a part. The drift is an estimate: some 7 % in 50 parts
USUAL_RESIDUAL, USUAL_DRIFT = 0.1, 0.01


def usual_uncertainty(job: Job) -> Uncertainty:
    """Return the uncertainty of a machine known only from the catalogue."""
    entries = entries_of(job)
    names = [name for name in USUAL_SPREADS if value_of(entries, name) > 0.0]
    return Uncertainty(
        names=tuple(names),
        spread=tuple(USUAL_SPREADS[name] for name in names),
        correlation=tuple(map(tuple, np.eye(len(names)).tolist())),
        residual=USUAL_RESIDUAL,
        drift=USUAL_DRIFT,
    )


def uncertainty_of(job: Job) -> Uncertainty:
    """Return the uncertainty of the machine of a job: from its calibration, or the usual one."""
    return usual_uncertainty(job) if job.uncertainty is None else job.uncertainty


def draw_machine(job: Job, uncertainty: Uncertainty, root: Array, seed: int, number: int) -> Job:
    """Return the possible machine of a job with this number; `root` is that of the uncertainty.

    A number beyond its legal range is set to the end of the range. The drift, which is no number of an entry, is
    applied while parts are ground.
    """
    entries = entries_of(job)
    *normal, force = np.random.default_rng((seed, number)).standard_normal(len(root) + 1).tolist()
    steps = (root @ np.array(normal)).tolist()
    changes: dict[str, dict[str, float]] = {kind: {} for kind in KINDS}
    for name, spread, step in zip(uncertainty.names, uncertainty.spread, steps, strict=True):
        kind, key = name.split(".")
        value = value_of(entries, name)
        quantity = quantities(KINDS[kind])[key]
        adds = isinstance(quantity, Quantity) and quantity.low < 0.0  # it may be below 0, and so has no logarithm
        changes[kind][key] = value + spread * step if adds else value * math.exp(spread * step)
    material = changes["material"]
    factor = material.get("power_factor", value_of(entries, "material.power_factor"))
    material["power_factor"] = factor * math.exp(uncertainty.residual * force)
    within = {
        kind: {key: entries[kind].within(key, value) for key, value in values.items()}
        for kind, values in changes.items()
    }
    try:
        return with_entries(job, within)
    except GrindError as error:
        why = str(error).rstrip(".")
        raise CatalogueError(
            f"{UNCERTAINTY}: some of the machines that it allows are none, for {why}; give smaller spreads, or leave "
            "names out"
        ) from None


def value_of(entries: Mapping[str, Any], name: str) -> float:
    """Return a number of the entries, by a name such as `material.chip_energy`."""
    kind, key = name.split(".")
    return float(getattr(entries[kind], key))
