"""Group 8: the energy partition before and after the coolant film boils, and the temperature that follows."""

from collections.abc import Callable
from itertools import pairwise
from math import log
from typing import Any

import numpy as np

from grind_env.process.state import StrokeResult
from grind_env.validation.check import Band, Basis, Check, Evidence, around, at_least, at_most
from grind_env.validation.data import MAGNITUDES
from grind_env.validation.rig import USUAL, Grinder, Rig

IRON = "grey_cast_iron"
HALF_DULL = 0.03
"""Wear-flat area, share of the wheel face: between a sharp wheel, .009, and 4 %, where burn is expected."""
SHEN = Basis(
    Evidence.MEASURED, "page_numbers.csv: Shen, Xiao, Guo, Malkin & Shih, ASME JMSE 130 (2008) 051014 (abstract)"
)
SLOW = 40.0
"""Table speed of the partitions, mm/s: not stated, and that of other work of the same group (from memory)."""
BURNING_SPEEDS = (75.0, 100.0, 150.0, 200.0, 300.0)
"""Table speeds at which a wheel is dulled until it burns, mm/s: 4.5 to 18 m/min."""
FLATS = tuple(np.geomspace(0.004, 0.145, 181).tolist())
"""Wear-flat areas by which the heat flux is raised."""


def partition(rig: Rig, flats: float | None = None, **setup: Any) -> float:
    """Energy partition in cast iron, of a sharp wheel or one of some wear-flat area."""
    chosen = {"material": IRON, "table_speed": SLOW, **setup}
    return (rig.sharp(**chosen) if flats is None else rig.dulled(flats, **chosen)).grind(5).eps


def heated(grinder: Grinder) -> list[StrokeResult]:
    """Strokes of 10 um with more and more wear flats, and so heat flux."""
    strokes = []
    for flats in FLATS:
        grinder.wheel = grinder.wheel._replace(A=flats)
        strokes.append(grinder.cut(0.010))
    return strokes


def flux(done: StrokeResult) -> float:
    """Heat flux over the contact, W/mm2."""
    return done.Ft * done.Q / (done.heq * done.lc)


def steepness(strokes: list[StrokeResult]) -> list[float]:
    """How steeply the temperature rises with the heat flux between strokes: 1 where it is proportional."""
    return [log(two.T / one.T) / log(flux(two) / flux(one)) for one, two in pairwise(strokes)]


def burn_out_flux(rig: Rig, fluid: str) -> float:
    """Heat flux at which the film boils: where the temperature rises most steeply with it, W/mm2."""
    strokes = heated(rig.sharp(material="aisi_52100", fluid=fluid))
    slopes = steepness(strokes)
    return flux(strokes[slopes.index(max(slopes))])


def boiling_range(rig: Rig) -> float:
    """Heat flux at which the film has boiled over that at which it begins to: where the partition has its jump."""
    strokes = heated(rig.sharp(material=IRON))
    shares = [done.eps for done in strokes]
    middle = max(range(len(shares) - 1), key=lambda k: shares[k + 1] / shares[k])
    steep = [k for k, slope in enumerate(steepness(strokes)) if slope > 2.0]
    if middle not in steep:
        return float("nan")
    first = next(k for k in range(middle, -1, -1) if k - 1 not in steep)
    last = next(k for k in range(middle, len(shares)) if k + 1 not in steep)
    return flux(strokes[last + 1]) / flux(strokes[first])


def burning(rig: Rig, table_speed: float) -> float:
    """Temperature rise of a wheel so dull that a cut of 10 um burns by Malkin's threshold, K; found by bisection."""
    grinder = rig.sharp(table_speed=table_speed)
    low, high = FLATS[0], FLATS[-1]
    for _ in range(40):
        middle = 0.5 * (low + high)
        grinder.wheel = grinder.wheel._replace(A=middle)
        low, high = (middle, high) if grinder.cut(0.010).Br < 1.0 else (low, middle)
    return grinder.cut(0.010).T


def burning_spread(rig: Rig) -> float:
    """Highest over lowest of these rises over the table speeds."""
    rises = [burning(rig, speed) for speed in BURNING_SPEEDS]
    return max(rises) / min(rises)


def rise(flats: float | None = None) -> Callable[[Rig], float]:
    """Temperature rise of a sharp wheel, or of one of some wear-flat area, K."""
    return lambda rig: (rig.sharp() if flats is None else rig.dulled(flats)).grind(5).T


IN_IRON = f"{USUAL}; cast iron"
AT = f"{IN_IRON}; table 2.4 m/min"

CHECKS = (
    Check(
        name="partition wet",
        group=8,
        what="energy partition, wet, before the film boils",
        at=f"{AT}; sharp",
        reference=0.24,
        band=around(0.24, 0.05),
        measure=partition,
        basis=SHEN,
    ),
    Check(
        name="partition boiling",
        group=8,
        what="energy partition, wet, the film boils",
        at=f"{AT}; 25 um; A 3 %",
        reference=0.92,
        band=around(0.90, 0.06),
        measure=lambda rig: partition(rig, HALF_DULL, downfeed=0.025),
        basis=SHEN,
    ),
    Check(
        name="partition dry",
        group=8,
        what="energy partition, dry",
        at=f"{AT}; dry; sharp",
        reference=0.84,
        band=around(0.84, 0.08),
        measure=lambda rig: partition(rig, fluid="dry"),
        basis=SHEN,
    ),
    Check(
        name="boiling range",
        group=8,
        what="heat flux at which the film has boiled over that at which it begins to",
        at=f"{IN_IRON}; A raised from .4 to 14.5 %",
        band=Band(1.0, 1.4),
        measure=boiling_range,
    ),
    Check(
        name="burn-out flux of oil",
        group=8,
        what="heat flux at which oil boils over that of emulsion",
        at=f"{USUAL}; A raised from .4 to 14.5 %",
        band=at_least(1.02),
        measure=lambda rig: burn_out_flux(rig, "oil") / burn_out_flux(rig, "emulsion"),
    ),
    Check(
        name="temperature at burn over table speeds",
        group=8,
        what="highest over lowest temperature rise at burn ratio 1: work burns at one, however fast it passes",
        at=f"{USUAL}; 4.5 to 18 m/min, each with the flats at which a cut of 10 um burns",
        band=at_most(1.3),
        measure=burning_spread,
        basis=Basis(Evidence.OWN, "the burn threshold of Malkin 1978 is that of one temperature"),
    ),
    Check(
        name="temperature sharp",
        group=8,
        what="temperature rise",
        at=f"{USUAL}; sharp",
        unit="K",
        band=Band(60.0, 250.0),
        measure=rise(),
        basis=Basis(Evidence.REMEMBERED, f"{MAGNITUDES}; 100 to 250 K excludes a partition of .24 and was not chosen"),
    ),
    Check(
        name="temperature dull",
        group=8,
        what="temperature rise",
        at=f"{USUAL}; A 4 %",
        unit="K",
        band=Band(300.0, 800.0),
        measure=rise(0.04),
        basis=Basis(Evidence.REMEMBERED, MAGNITUDES),
    ),
    Check(
        name="cBN cooler",
        group=8,
        what="energy partition of cBN over that of alumina",
        at=f"{USUAL}; b126 and a60j; dry; sharp",
        band=at_most(0.9),
        measure=lambda rig: rig.sharp(wheel="b126", fluid="dry").grind(5).eps / rig.sharp(fluid="dry").grind(5).eps,
        basis=Basis(Evidence.OWN, "which way, by the conductivity of the grains: thermal_partition.csv, Rowe et al."),
    ),
)
