"""Numbers of the test rig that need several wheels, or none; each is a name in `checks.csv`."""

import math
from typing import Any

from grind_env.machine.job import Lots
from grind_env.process.equations import dress_width as active_width
from grind_env.process.stroke_types import StrokeResult
from grind_env.validation import measured_data
from grind_env.validation.fitted_slopes import exponent
from grind_env.validation.quantities import ROUGHING, STEADY, settled_roughness, wear_depth
from grind_env.validation.rig import NO_GROWTH, Rig, grind_plate
from grind_env.validation.unused_fields import idle_fields

HALF_DULL = 0.03  #: wear-flat area, share of the wheel's face, between a sharp wheel (.009) and expected burn (.04)
INTERVAL = 100.0  #: volume over which a wheel loses the grains that a dress has loosened, mm3/mm
VOLUMES = (250.0, 450.0, 600.0)  #: volumes of valve_alloys.csv, mm3/mm, if they are mm3 on a width of 20 mm
AMPLE = 500_000.0  #: power limit of an ample spindle, W; no stroke needs so much
SLOWED = 1.2  #: ratio of the power that a stroke needs to the power limit of a weak spindle
#: entries that a shop looks for in the catalogue, by kind
ENTRIES = {
    "material": (
        *("aisi_52100", "aisi_d2", "aisi_m2", "aisi_1045", "case_hardened_16mncr5", "grey_cast_iron"),
        *("inconel_718", "inc751", "ti_6al_4v"),
    ),
    "wheel": ("a46h", "a60j", "a80k", "a120k", "a46j", "sg60j", "b126", "b91"),
    "fluid": ("emulsion", "synthetic", "oil", "dry"),
    "dresser": ("single_point", "blade", "rotary"),
}


def catalogue_gaps(rig: Rig) -> float:
    """Return how many of `ENTRIES` the catalogue lacks."""
    known = {kind: getattr(rig.catalogue, f"{kind}s") for kind in ENTRIES}
    return float(sum(name not in known[kind] for kind, names in ENTRIES.items() for name in names))


def fields_without_effect(rig: Rig) -> float:
    """Return how many fields of entries change nothing."""
    return float(len(idle_fields(rig)))


def roughness_in_nickel(rig: Rig, wheel: str) -> float:
    """Return the ratio of the settled Ra in a nickel alloy to the settled Ra in steel."""
    nickel, steel = (settled_roughness(rig.fresh(wheel=wheel, material=each)) for each in ("inc751", "aisi_52100"))
    return nickel / steel


def roughness_on_wear(rig: Rig, wheel: str) -> float:
    """Return the exponent of the settled Ra on the wear, from a nickel alloy and steel."""
    grinders = [rig.steady(wheel=wheel, material=each) for each in ("inc751", "aisi_52100")]
    nickel, steel = (grinder.grind_volume(INTERVAL) for grinder in grinders)
    return math.log(nickel.Rg / steel.Rg) / math.log(steel.G / nickel.G)


def roughness_scatter(rig: Rig) -> float:
    """Return the coefficient of variation of Ra from part to part in a job that does not set it."""
    return math.sqrt(math.expm1(Lots().roughness ** 2))


def early_loss(rig: Rig, volume: float = INTERVAL, **setup: Any) -> float:
    """Return the radius that a wheel loses early after a dress in addition to its steady wear, um."""
    return 1000.0 * (wear_depth(rig.fresh(**setup), volume) - wear_depth(rig.steady(**setup), volume))


def wear_on_volume(rig: Rig, wheel: str) -> float:
    """Return the exponent of the wear on the volume ground since the dress."""
    return exponent(VOLUMES, [rig.used(volume, material="inc751", wheel=wheel).worn for volume in VOLUMES])


def excess_removal_by_growth(rig: Rig, waits: float) -> float:
    """Return the stock that is removed in excess because the part grows with heat, um.

    The test is roughing with a wheel due for a dress, `waits` strokes in the air to cool, and two more infeeds.
    """
    depths = []
    for changes in ({}, NO_GROWTH):
        grinder = rig.dulled(HALF_DULL, changes=changes)
        grinder.grind(ROUGHING)
        depth, grinder.Z = grinder.Z, -1.0
        if waits:
            grinder.grind(int(waits), 0.0)
        grinder.Z = depth
        grinder.grind(2)
        depths.append(grinder.S)
    return 1000.0 * (depths[0] - depths[1])


def _spindles(rig: Rig, over: float) -> tuple[StrokeResult, StrokeResult]:
    """Return the stroke of an ample spindle, and the stroke of a spindle with 1/`over` of the power needed."""
    wheel = rig.sharp(changes={"machine": {"power_limit": AMPLE, "idle_power": 0.0}})
    ample = rig.with_setup(wheel).grind(STEADY)
    weak = rig.with_setup(wheel, changes={"machine": {"power_limit": ample.power * (1.0 / over), "idle_power": 0.0}})
    return ample, weak.grind(STEADY)


def slowed(rig: Rig, name: str) -> float:
    """Return the ratio of a field of the stroke between the weak and the ample spindle."""
    ample, weak = (getattr(each, name) for each in _spindles(rig, SLOWED))
    return float(weak / ample)


def power_used(rig: Rig) -> float:
    """Return the ratio of the power of the weak spindle to its power limit."""
    ample, weak = _spindles(rig, SLOWED)
    return SLOWED * weak.load * weak.vs / (ample.vs * ample.power)


def stalled(rig: Rig, over: float) -> float:
    """Return 1 if a spindle stalls when a stroke needs `over` times its power limit, else 0."""
    return float(_spindles(rig, over)[1].torque >= 1.0)


def plate_survival(rig: Rig, power_limit: float) -> float:
    """Return the probability that the part of the example `plate_g82` is good."""
    return float(grind_plate(rig, power_limit).parts["survival"][0])


def plate_seconds(rig: Rig, power_limit: float) -> float:
    """Return the time of the example `plate_g82`, s."""
    return grind_plate(rig, power_limit).seconds


def stall_warnings(rig: Rig, power_limit: float) -> float:
    """Return how many warnings of a stall name block and stroke."""
    return sum("stall" in line and "stroke" in line for line in grind_plate(rig, power_limit).warnings)


def burn_threshold_error(rig: Rig) -> float:
    """Return the largest deviation of the model's burn threshold, u_s/burn_ratio, from the grid, %."""
    errors = []
    for row in measured_data.rows("burn_threshold_grid"):
        speed, depth = float(row["vw_m_min"]) / 0.06, float(row["ae_um"]) / 1000.0
        done = rig.fresh(diameter=float(row["De_mm"]), table_speed=speed, constant_surface_speed=True).cut(depth)
        errors.append(abs(done.u_s / done.burn_ratio / float(row["ustar_J_mm3"]) - 1.0))
    return 100.0 * max(errors)


def linearity(rig: Rig) -> float:
    """Return the ratio of the specific energy at A 4 % to its mean at 2 and 6 %, at the same depth of cut."""
    low, middle, high = (rig.dulled(flats).cut(0.010).u_s for flats in (0.02, 0.04, 0.06))
    return 2.0 * middle / (low + high)


def dress_width(rig: Rig) -> float:
    """Return the active width of an unworn diamond of .38 mm radius, .025 mm deep, mm."""
    return active_width(0.025, 0.38, 0.0)


def dress_overlap(rig: Rig) -> float:
    """Return the overlap ratio of the diamond of `dress_width` at 192.5 mm/min and 1410 rpm."""
    return dress_width(rig) / (192.5 / 1410.0)
