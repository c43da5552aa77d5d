"""Group 7: the G-ratio by material, wheel, removal rate and volume."""

from functools import partial
from itertools import product
from typing import Any

from grind_env.validation.check import TREND, Band, Check, Question, at_least, drawn, own
from grind_env.validation.measures import Measurement, exponent_on, g_over, over, quotient, used
from grind_env.validation.rig import Rig
from grind_env.validation.slopes import exponent

INTERVAL = 100.0
"""mm3/mm from the dress on over which slopes and ratios of G are taken: for every material, because alumina in nickel
alloys is dressed that soon. Of steady wear alone, which is what a G-ratio is of."""
SPEEDS = (100.0, 200.0, 300.0)
"""Table speeds, mm/s: removal rates of 1 to 2 to 3, as in valve_alloys.csv."""
VOLUMES = (250.0, 450.0, 600.0)
"""mm3/mm; the volumes of valve_alloys.csv, if they are mm3 on a width of 20 mm."""

EASY, BETWEEN, HARD = Band(-0.35, -0.1), Band(-1.0, -0.1), Band(-1.0, -0.7)
SLOPES = {
    "aisi_52100": EASY,
    "aisi_1045": EASY,
    "case_hardened_16mncr5": EASY,
    "grey_cast_iron": EASY,
    "aisi_d2": BETWEEN,
    "aisi_m2": BETWEEN,
    "inconel_718": HARD,
    "inc751": HARD,
}
NICKEL, STEEL = Band(8.0, 36.0), Band(20.0, 500.0)
RATIOS = {
    "inconel_718": NICKEL,
    "inc751": NICKEL,
    "aisi_52100": STEEL,
    "case_hardened_16mncr5": STEEL,
    "aisi_d2": STEEL,
    "aisi_m2": STEEL,
}
WHEELS = {"a60j": "alumina", "b126": "cBN"}
VALVES = "valve_alloys.csv (Nametala, CIRP JMST 2020)"
UNMEASURED = own("nothing was measured of what is neither an easy alloy nor a nickel alloy")
TWO_ALLOYS = drawn(f"wear exponents of two valve alloys, {VALVES}")
STEADY = "steady wear over 100 mm3/mm from the dress on"

ask = partial(Question, 7)


def slope(material: str, wheel: str) -> Check:
    """Return the check of the exponent of the G-ratio on the removal rate."""
    band = SLOPES[material]
    return ask(
        f"G slope {material} {wheel}",
        f"exponent of G on the removal rate, {material}, {WHEELS[wheel]}",
        f"usual; {material}, {wheel}; 6, 12, 18 m/min; {STEADY}",
    ).within(
        band,
        exponent_on("table_speed", SPEEDS, g_over(INTERVAL), Rig.steady, material=material, wheel=wheel),
        UNMEASURED if band is BETWEEN else TWO_ALLOYS,
    )


def cbn_over_alumina(material: str) -> Check:
    """Return the check of the G-ratio of cBN over that of alumina."""
    return ask(
        f"G of cBN {material}",
        f"G-ratio of cBN over that of alumina, {material}",
        f"usual; {material}, b126 and a60j; {STEADY}",
    ).within(
        RATIOS[material],
        Measurement(g_over(INTERVAL), over("wheel", ("b126", "a60j"), material=material), quotient, Rig.steady),
        drawn(VALVES) if RATIOS[material] is NICKEL else TREND,
    )


def on_volume(rig: Rig, wheel: str) -> float:
    """Return the exponent of the wear on the volume ground since the dress."""
    return exponent(VOLUMES, [used(volume)(rig, material="inc751", wheel=wheel).worn for volume in VOLUMES])


def early_loss(rig: Rig, **setup: Any) -> float:
    """Return the radius that a wheel loses early after a dress, beside its steady wear, um."""
    loose, steady = rig.fresh(**setup), rig.steady(**setup)
    for grinder in (loose, steady):
        grinder.grind_volume(INTERVAL)
    return 1000.0 * (loose.wheel.W - steady.wheel.W)


def early_wear(wheel: str, band: Band) -> Check:
    """Return the check of the radius that a wheel loses early."""
    return ask(
        f"early wear {wheel}",
        f"radius lost early after a dress, {WHEELS[wheel]}",
        f"usual; inc751, {wheel}; 100 mm3/mm after the dress",
    ).within(
        band, lambda rig: early_loss(rig, material="inc751", wheel=wheel), drawn(f"wear at no volume in {VALVES}"), "um"
    )


THREE = "250, 450, 600 mm3/mm"

CHECKS = (
    early_wear("a60j", Band(4.0, 9.0)),
    early_wear("b126", Band(1.3, 2.5)),
    ask(
        "early wear in steel",
        "radius lost early in inc751 over that in aisi_52100: a dress loosens grains, whatever is ground",
        "usual; 100 mm3/mm after the dress",
    ).within(
        Band(0.9, 1.1),
        lambda rig: early_loss(rig, material="inc751") / early_loss(rig),
        own(f"no alloy of {VALVES} loses more"),
    ),
    ask(
        "early wear of a coarse dress",
        "radius lost early after a dress twice as deep over that after a medium one",
        "usual; depth .04 and .02 mm; 100 mm3/mm after the dress",
    ).within(at_least(1.3), lambda rig: early_loss(rig, depth=0.040) / early_loss(rig)),
    *(slope(*each) for each in product(SLOPES, WHEELS)),
    *map(cbn_over_alumina, RATIOS),
    ask(
        "wear on volume b126", "exponent of wear on volume since the dress, cBN", f"usual; inc751, b126; {THREE}"
    ).within(Band(0.4, 0.65), partial(on_volume, wheel="b126"), drawn(f"{VALVES}: .41 and .64")),
    ask("wear on volume a60j", "exponent of wear on volume since the dress, alumina", f"usual; inc751; {THREE}").within(
        Band(0.85, 1.25), partial(on_volume, wheel="a60j"), drawn(f"{VALVES}: .95 to 1.25")
    ),
    ask(
        "initial wear",
        "that exponent of alumina less that of cBN: initial wear matters more for cBN",
        f"usual; inc751; {THREE}",
    ).within(
        at_least(0.2), lambda rig: on_volume(rig, "a60j") - on_volume(rig, "b126"), drawn(f"{VALVES}: .31 to .84")
    ),
)
