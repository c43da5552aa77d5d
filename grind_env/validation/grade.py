"""Group 3: a harder grade holds its grains longer, lasts longer and dulls longer."""

from grind_env.validation.check import Basis, Check, Evidence, at_least, at_most
from grind_env.validation.rig import USUAL, Grinder, Rig

GRADES = {"H": 0.8, "J": 1.2, "L": 2.0, "M": 2.5}
"""Force per grain that breaks grain or bond, N, at the reference grit."""
MALKIN_COOK = Basis(Evidence.OWN, "the way of the trend: Malkin & Cook, J. Eng. Ind. 93 (1971) (from memory)")


def ground(rig: Rig, grade: str, volume: float) -> Grinder:
    """The usual wheel in some grade, some mm3/mm after the dress, without early wear."""
    changes = {"wheel": {"fracture_force": GRADES[grade], "initial_wear": 0.0}}
    grinder = rig.fresh(changes=changes)
    grinder.grind_volume(volume)
    return grinder


def g_ratio(rig: Rig, grade: str) -> float:
    """G-ratio of steady wear over 100 mm3/mm."""
    return ground(rig, grade, 100.0).g_ratio()


def flats(rig: Rig, grade: str) -> float:
    """Wear-flat area after 600 mm3/mm."""
    return ground(rig, grade, 600.0).wheel.A


CHECKS = (
    Check(
        name="G of grade L",
        group=3,
        what="G-ratio of grade L over that of grade J",
        at=f"{USUAL}; steady wear over 100 mm3/mm from the dress on",
        band=at_least(1.15),
        measure=lambda rig: g_ratio(rig, "L") / g_ratio(rig, "J"),
        basis=MALKIN_COOK,
    ),
    Check(
        name="flats of grade M",
        group=3,
        what="wear-flat area of grade M over that of grade J",
        at=f"{USUAL}; 600 mm3/mm after the dress",
        band=at_least(1.2),
        measure=lambda rig: flats(rig, "M") / flats(rig, "J"),
        basis=MALKIN_COOK,
    ),
    Check(
        name="flats of grade H",
        group=3,
        what="wear-flat area of grade H over that of grade J",
        at=f"{USUAL}; 600 mm3/mm after the dress",
        band=at_most(0.9),
        measure=lambda rig: flats(rig, "H") / flats(rig, "J"),
        basis=MALKIN_COOK,
    ),
)
