"""Group 10: wear and roughness of alumina and cBN in two valve alloys.

`valve_alloys.csv` states neither units nor conditions, so only exponents and ratios are compared. Rates are read as
mm3/s per mm of width and volumes as mm3 on a width of 20 mm. Valves are ground by plunging at one work speed, so the
infeed sets the rate. 3NQ is assumed to be a wheel of ceramic alumina.
"""

from itertools import groupby, product
from typing import NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.evidence import Basis, Evidence
from grind_env.validation import measured_data
from grind_env.validation.check import Band, Check
from grind_env.validation.fitted_slopes import exponent, exponents
from grind_env.validation.rig import Rig

WIDTH = 20.0  #: assumed width on which the volumes are ground, mm
TABLE_SPEED = 200.0  #: table speed, mm/s; the downfeed sets the removal rate
AMPLE = {"machine": {"power_limit": 200_000.0}}  #: changes of a set-up for a spindle that no run slows
ALLOY = "INC751"
RESPONSES = {"wheel_wear_um": "wear", "Ra_um": "Ra"}
FACTORS = ("removal rate", "volume removed")
LEAST = 0.1  #: least half width of the band of an exponent; above it, the half width is twice the standard error
SOURCE = Basis(
    Evidence.MEASURED, "valve_alloys.csv (Nametala, CIRP JMST 2020): within two standard errors, at least .1"
)
#: exponent of Ra on the removal rate over all wheels and alloys of the data, and its standard error
POOLED, POOLED_ERROR = 0.29, 0.03


class AlloyWheel(NamedTuple):
    """Wheel of the data, with its counterpart in the catalogue."""

    measured: str
    speed: float  #: wheel speed, m/s
    entry: str


WHEELS = (AlloyWheel("3NQ", 45.0, "sg60j"), AlloyWheel("3NQ", 80.0, "sg60j"), AlloyWheel("cBN", 80.0, "b126"))


class AlloyRuns(NamedTuple):
    """Runs of a wheel in an alloy, over the same nine pairs of rate and volume in the same order."""

    rate: Array  #: removal rate, mm3/s per mm
    volume: Array  #: volume removed, mm3
    wheel_wear_um: Array
    Ra_um: Array


def measured(wheel: AlloyWheel) -> AlloyRuns:
    """Return the nine runs of a wheel in INC751."""
    chosen = [
        row
        for row in measured_data.rows("valve_alloys")
        if row["wheel"] == wheel.measured and float(row["vs_m_s"]) == wheel.speed and row["mat"] == ALLOY
    ]
    names = ("removal_rate_per_s", "volume_removed", "wheel_wear_um", "Ra_um")
    return AlloyRuns(*(np.array([float(row[name]) for row in chosen]) for name in names))


def simulated(rig: Rig, wheel: AlloyWheel) -> AlloyRuns:
    """Return the same nine runs of the model: for each rate, a dressed wheel grinds up to the greatest volume."""
    plan = measured(wheel)
    wear, roughness = [], []
    for rate, runs in groupby(zip(plan.rate.tolist(), plan.volume.tolist(), strict=True), lambda run: run[0]):
        grinder = rig.fresh(
            material="inc751",
            wheel=wheel.entry,
            wheel_speed=wheel.speed,
            table_speed=TABLE_SPEED,
            downfeed=rate / TABLE_SPEED,
            width=WIDTH,
            changes=AMPLE,
        )
        ground = 0.0
        for _, volume in runs:
            roughness.append(grinder.grind_volume((volume - ground) / WIDTH).Rg)
            wear.append(1000.0 * grinder.wheel.W)
            ground = volume
    return AlloyRuns(plan.rate, plan.volume, np.array(wear), np.array(roughness))


def fitted(runs: AlloyRuns, response: str) -> Array:
    """Return the exponents of a response on rate and volume."""
    return exponents([runs.rate, runs.volume], getattr(runs, response))


def target(wheel: AlloyWheel, response: str, factor: str) -> tuple[float, float]:
    """Return a measured exponent in INC751 and its standard error."""
    subset = f"{wheel.measured} vs={wheel.speed:g} {ALLOY}"
    return next(
        (float(row["value"]), float(row["std_err"]))
        for row in measured_data.rows("derived_targets")
        if (row["subset"], row["response"], row["quantity"]) == (subset, response, f"exponent on {factor}")
    )


def exponent_check(wheel: AlloyWheel, response: str, factor: str) -> Check:
    """Return the check of an exponent of the model beside the measured one."""
    value, error = target(wheel, response, factor)
    place, name = FACTORS.index(factor), RESPONSES[response]
    return Check(
        name=f"valve {wheel.measured} {wheel.speed:g} {name} on {factor}",
        group=10,
        what=f"exponent of {name} on {factor}, INC751, {wheel.measured} at {wheel.speed:g} m/s",
        at=f"{wheel.entry}, {wheel.speed:g} m/s, emulsion; 4.2 to 12.5 um, 12 m/min; 250 to 600 mm3/mm; ample spindle",
        band=within(value, max(2.0 * error, LEAST)),
        measure=lambda rig: float(fitted(simulated(rig, wheel), response)[place]),
        reference=value,
        basis=SOURCE,
    )


def within(value: float, half: float) -> Band:
    """Return the band of half width `half` about a value."""
    return Band(round(value - half, 9), round(value + half, 9))


def pooled(rig: Rig) -> float:
    """Return the exponent of Ra on the rate in the usual set-up."""
    wheel, rates = rig.sharp(), np.unique(measured(WHEELS[0]).rate)
    Ra = [rig.with_setup(wheel, downfeed=float(rate) / TABLE_SPEED).grind(5).Rg for rate in rates]
    return exponent(rates.tolist(), Ra)


CHECKS = (
    *(exponent_check(*each) for each in product(WHEELS, RESPONSES, FACTORS)),
    Check(
        name="roughness on removal rate",
        group=10,
        what="exponent of Ra on removal rate, all wheels and alloys",
        at="52100, A60J, emulsion, 30 m/s; sharp; 4.2 to 12.5 um, 12 m/min",
        band=within(POOLED, 2.0 * POOLED_ERROR),
        measure=pooled,
        reference=POOLED,
        basis=Basis(Evidence.MEASURED, "valve_alloys.csv with its third alloy, pooled: within two standard errors"),
    ),
)
