"""Group 8: a part grows while it is hot, and is ground too thin by as much."""

from grind_env.process.equations import part_growth
from grind_env.validation.check import Band, Basis, Check, Evidence, at_most
from grind_env.validation.rig import NO_GROWTH, USUAL, Grinder, Rig

ROUGHING = 17
"""Strokes of roughing after which a part is looked at."""
FLATS = 0.03
"""Wear-flat area of a wheel that is due for a dress, share of its face."""
NO_PAUSE = 0.0
"""s; strokes that follow at once, so that nothing cools between them."""


def growth(grinder: Grinder) -> float:
    """By how much the part stands higher after roughing, um."""
    grinder.grind(ROUGHING)
    return 1000.0 * part_growth(grinder.heat.dT, grinder.p.swell)


def too_thin(rig: Rig, waits: int) -> float:
    """By how much more the last of a part is ground off than where it does not grow, um.

    Roughing with a wheel due for a dress, some strokes in the air to cool, and two more infeeds.
    """
    depths = []
    for changes in ({}, NO_GROWTH):
        grinder = rig.dulled(FLATS, changes=changes)
        grinder.grind(ROUGHING)
        depth, grinder.Z = grinder.Z, -1.0
        if waits:
            grinder.grind(waits, 0.0)
        grinder.Z = depth
        grinder.grind(2)
        depths.append(grinder.S)
    return 1000.0 * (depths[0] - depths[1])


CHECKS = (
    Check(
        name="growth sharp",
        group=8,
        what="growth of the part",
        at=f"{USUAL}; 20 mm high; sharp; after {ROUGHING} strokes that follow at once",
        unit="um",
        band=Band(3.0, 8.0),
        measure=lambda rig: growth(rig.sharp(pause=NO_PAUSE)),
        basis=Basis(Evidence.OWN, "heat balance with a partition of .2 to .3"),
    ),
    Check(
        name="growth dull",
        group=8,
        what="growth of the part",
        at=f"{USUAL}; 20 mm high; A 3 %; after {ROUGHING} strokes that follow at once",
        unit="um",
        band=Band(15.0, 40.0),
        measure=lambda rig: growth(rig.dulled(FLATS, pause=NO_PAUSE)),
        basis=Basis(Evidence.OWN, "heat balance with a partition of .8"),
    ),
    Check(
        name="growth cools",
        group=8,
        what="what a pause of a minute before the last two infeeds leaves of the size that the growth costs",
        at=f"{USUAL}; 20 mm high; A 3 %; after {ROUGHING} strokes",
        band=at_most(0.5),
        measure=lambda rig: too_thin(rig, 40) / too_thin(rig, 0),
    ),
)
