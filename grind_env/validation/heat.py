"""Group 8: the energy partition before and after the coolant film boils, and the heat of work and part."""

from functools import partial
from itertools import pairwise
from math import log

import numpy as np

from grind_env.process.equations import part_growth
from grind_env.process.state import StrokeResult
from grind_env.validation.check import Band, Question, around, at_least, at_most, measured, own, remembered
from grind_env.validation.data import MAGNITUDES
from grind_env.validation.measures import Measurement, dull, over, quotient, stroke, value
from grind_env.validation.rig import NO_GROWTH, Grinder, Rig

IRON = "grey_cast_iron"
HALF_DULL = 0.03
"""Wear-flat area, share of the wheel face: between a sharp wheel, .009, and 4 %, where burn is expected."""
SHEN = measured("page_numbers.csv: Shen, Xiao, Guo, Malkin & Shih, ASME JMSE 130 (2008) 051014 (abstract)")
BURNING_SPEEDS = (75.0, 100.0, 150.0, 200.0, 300.0)
"""Table speeds at which a wheel is dulled until it burns, mm/s: 4.5 to 18 m/min."""
FLATS = tuple(np.geomspace(0.004, 0.145, 181).tolist())
"""Wear-flat areas by which the heat flux is raised."""
ROUGHING = 17
"""Strokes of roughing after which the growth of a part is looked at."""

ask = partial(Question, 8)
partition = partial(value, stroke("eps"), material=IRON, table_speed=40.0)
"""The energy partition in cast iron; its table speed is not stated, and is that of other work of the group."""


def heated(grinder: Grinder) -> list[StrokeResult]:
    """Grind strokes of 10 um with more and more wear flats, and so heat flux."""
    strokes = []
    for flats in FLATS:
        grinder.wheel = grinder.wheel._replace(A=flats)
        strokes.append(grinder.cut(0.010))
    return strokes


def flux(done: StrokeResult) -> float:
    """Return the heat flux over the contact, W/mm2."""
    return done.Ft * done.Q / (done.heq * done.lc)


def steepness(strokes: list[StrokeResult]) -> list[float]:
    """Return how steeply the temperature rises with the heat flux between strokes: 1 where it is proportional."""
    return [log(two.T / one.T) / log(flux(two) / flux(one)) for one, two in pairwise(strokes)]


def burn_out_flux(grinder: Grinder) -> float:
    """Return the heat flux at which the film boils: where the temperature rises most steeply with it, W/mm2."""
    strokes = heated(grinder)
    slopes = steepness(strokes)
    return flux(strokes[slopes.index(max(slopes))])


def boiling_range(rig: Rig) -> float:
    """Return the heat flux at which the film has boiled over that at which it begins to boil."""
    strokes = heated(rig.sharp(material=IRON))
    shares = [done.eps for done in strokes]
    middle = max(range(len(shares) - 1), key=lambda k: shares[k + 1] / shares[k])
    steep = [k for k, slope in enumerate(steepness(strokes)) if slope > 2.0]
    if middle not in steep:
        return float("nan")
    first = next(k for k in range(middle, -1, -1) if k - 1 not in steep)
    last = next(k for k in range(middle, len(shares)) if k + 1 not in steep)
    return flux(strokes[last + 1]) / flux(strokes[first])


def burning(grinder: Grinder) -> float:
    """Return the temperature rise where a wheel is so dull that a cut of 10 um burns by Malkin's threshold, K."""
    low, high = FLATS[0], FLATS[-1]
    for _ in range(40):
        middle = 0.5 * (low + high)
        grinder.wheel = grinder.wheel._replace(A=middle)
        low, high = (middle, high) if grinder.cut(0.010).Br < 1.0 else (low, middle)
    return grinder.cut(0.010).T


def growth(grinder: Grinder) -> float:
    """Return by how much the part stands higher after roughing, um."""
    grinder.grind(ROUGHING)
    return 1000.0 * part_growth(grinder.heat.dT, grinder.p.swell)


def too_thin(rig: Rig, waits: int) -> float:
    """Return by how much more the last of a part is ground off than where it does not grow, um.

    Roughing with a wheel due for a dress, some strokes in the air to cool, and two more infeeds.
    """
    depths = []
    for changes in ({}, NO_GROWTH):
        grinder = rig.dulled(HALF_DULL, changes=changes)
        grinder.grind(ROUGHING)
        depth, grinder.Z = grinder.Z, -1.0
        if waits:
            grinder.grind(waits, 0.0)
        grinder.Z = depth
        grinder.grind(2)
        depths.append(grinder.S)
    return 1000.0 * (depths[0] - depths[1])


AT = "usual; cast iron; table 2.4 m/min"
TALL = "usual; 20 mm high"

CHECKS = (
    ask("partition wet", "energy partition, wet, before the film boils", f"{AT}; sharp").within(
        around(0.24, 0.05), partition(), SHEN, reference=0.24
    ),
    ask("partition boiling", "energy partition, wet, the film boils", f"{AT}; 25 um; A 3 %").within(
        around(0.90, 0.06), partition(make=dull(HALF_DULL), downfeed=0.025), SHEN, reference=0.92
    ),
    ask("partition dry", "energy partition, dry", f"{AT}; dry; sharp").within(
        around(0.84, 0.08), partition(fluid="dry"), SHEN, reference=0.84
    ),
    ask(
        "boiling range",
        "heat flux at which the film has boiled over that at which it begins to",
        "usual; cast iron; A raised from .4 to 14.5 %",
    ).within(Band(1.0, 1.4), boiling_range),
    ask(
        "burn-out flux of oil",
        "heat flux at which oil boils over that of emulsion",
        "usual; A raised from .4 to 14.5 %",
    ).within(at_least(1.02), Measurement(burn_out_flux, over("fluid", ("oil", "emulsion")), quotient, Rig.sharp)),
    ask(
        "temperature at burn over table speeds",
        "highest over lowest temperature rise at burn ratio 1: work burns at one, however fast it passes",
        "usual; 4.5 to 18 m/min, each with the flats at which a cut of 10 um burns",
    ).within(
        at_most(1.3),
        Measurement(burning, over("table_speed", BURNING_SPEEDS), lambda rises: max(rises) / min(rises), Rig.sharp),
        own("the burn threshold of Malkin 1978 is that of one temperature"),
    ),
    ask("temperature sharp", "temperature rise", "usual; sharp").within(
        Band(60.0, 250.0),
        value(stroke("T")),
        remembered(f"{MAGNITUDES}; 100 to 250 K excludes a partition of .24 and was not chosen"),
        "K",
    ),
    ask("temperature dull", "temperature rise", "usual; A 4 %").within(
        Band(300.0, 800.0), value(stroke("T"), dull(0.04)), remembered(MAGNITUDES), "K"
    ),
    ask("cBN cooler", "energy partition of cBN over that of alumina", "usual; b126 and a60j; dry; sharp").within(
        at_most(0.9),
        Measurement(stroke("eps"), over("wheel", ("b126", "a60j")), quotient, partial(Rig.sharp, fluid="dry")),
        own("which way, by the conductivity of the grains: thermal_partition.csv, Rowe et al."),
    ),
    # without a pause between strokes nothing cools
    ask("growth sharp", "growth of the part", f"{TALL}; sharp; after {ROUGHING} strokes that follow at once").within(
        Band(3.0, 8.0), value(growth, pause=0.0), own("heat balance with a partition of .2 to .3"), "um"
    ),
    ask("growth dull", "growth of the part", f"{TALL}; A 3 %; after {ROUGHING} strokes that follow at once").within(
        Band(15.0, 40.0), value(growth, dull(HALF_DULL), pause=0.0), own("heat balance with a partition of .8"), "um"
    ),
    ask(
        "growth cools",
        "what a pause of a minute before the last two infeeds leaves of the size that the growth costs",
        f"{TALL}; A 3 %; after {ROUGHING} strokes",
    ).within(at_most(0.5), lambda rig: too_thin(rig, 40) / too_thin(rig, 0)),
)
