"""Group 7: the G-ratio by material, wheel, removal rate and volume."""

from typing import Any

from grind_env.validation.check import TREND, Band, Basis, Check, Evidence, at_least
from grind_env.validation.rig import USUAL, Grinder, Rig
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


def steady_g(rig: Rig, **setup: Any) -> float:
    """G-ratio of steady wear."""
    grinder = rig.steady(**setup)
    grinder.grind_volume(INTERVAL)
    return grinder.g_ratio()


def used(rig: Rig, volume: float, **setup: Any) -> Grinder:
    """A wheel that has ground some mm3/mm from the dress on."""
    grinder = rig.fresh(**setup)
    grinder.grind_volume(volume)
    return grinder


def slope(material: str, wheel: str) -> Check:
    """Exponent of the G-ratio on the removal rate."""

    def measure(rig: Rig) -> float:
        return exponent(SPEEDS, [steady_g(rig, material=material, wheel=wheel, table_speed=vw) for vw in SPEEDS])

    band = SLOPES[material]
    unmeasured = Basis(Evidence.OWN, "nothing was measured of what is neither an easy alloy nor a nickel alloy")
    return Check(
        name=f"G slope {material} {wheel}",
        group=7,
        what=f"exponent of G on the removal rate, {material}, {WHEELS[wheel]}",
        at=f"{USUAL}; {material}, {wheel}; 6, 12, 18 m/min; steady wear over 100 mm3/mm from the dress on",
        band=band,
        measure=measure,
        basis=unmeasured if band is BETWEEN else Basis(Evidence.DRAWN, f"wear exponents of two valve alloys, {VALVES}"),
    )


def cbn_over_alumina(material: str) -> Check:
    """G-ratio of cBN over that of alumina."""

    def measure(rig: Rig) -> float:
        cbn, alumina = (steady_g(rig, material=material, wheel=wheel) for wheel in ("b126", "a60j"))
        return cbn / alumina

    return Check(
        name=f"G of cBN {material}",
        group=7,
        what=f"G-ratio of cBN over that of alumina, {material}",
        at=f"{USUAL}; {material}, b126 and a60j; steady wear over 100 mm3/mm from the dress on",
        band=RATIOS[material],
        measure=measure,
        basis=Basis(Evidence.DRAWN, VALVES) if RATIOS[material] is NICKEL else TREND,
    )


def on_volume(rig: Rig, wheel: str) -> float:
    """Exponent of the wear on the volume ground since the dress."""
    return exponent(VOLUMES, [used(rig, volume, material="inc751", wheel=wheel).worn for volume in VOLUMES])


def early_loss(rig: Rig, **setup: Any) -> float:
    """Radius that a wheel loses early after a dress, beside its steady wear, um."""
    whole, steady = (make(**setup) for make in (rig.fresh, rig.steady))
    for grinder in (whole, steady):
        grinder.grind_volume(INTERVAL)
    return 1000.0 * (whole.wheel.W - steady.wheel.W)


def early_wear(wheel: str, band: Band) -> Check:
    """Radius that a wheel loses early."""
    return Check(
        name=f"early wear {wheel}",
        group=7,
        what=f"radius lost early after a dress, {WHEELS[wheel]}",
        at=f"{USUAL}; inc751, {wheel}; 100 mm3/mm after the dress",
        unit="um",
        band=band,
        measure=lambda rig: early_loss(rig, material="inc751", wheel=wheel),
        basis=Basis(Evidence.DRAWN, f"wear at no volume in {VALVES}"),
    )


CHECKS = (
    early_wear("a60j", Band(4.0, 9.0)),
    early_wear("b126", Band(1.3, 2.5)),
    Check(
        name="early wear in steel",
        group=7,
        what="radius lost early in inc751 over that in aisi_52100: a dress loosens grains, whatever is ground",
        at=f"{USUAL}; 100 mm3/mm after the dress",
        band=Band(0.9, 1.1),
        measure=lambda rig: early_loss(rig, material="inc751") / early_loss(rig),
        basis=Basis(Evidence.OWN, f"no alloy of {VALVES} loses more"),
    ),
    Check(
        name="early wear of a coarse dress",
        group=7,
        what="radius lost early after a dress twice as deep over that after a medium one",
        at=f"{USUAL}; depth .04 and .02 mm; 100 mm3/mm after the dress",
        band=at_least(1.3),
        measure=lambda rig: early_loss(rig, depth=0.040) / early_loss(rig),
    ),
    *(slope(material, wheel) for material in SLOPES for wheel in WHEELS),
    *(cbn_over_alumina(material) for material in RATIOS),
    Check(
        name="wear on volume b126",
        group=7,
        what="exponent of wear on volume since the dress, cBN",
        at=f"{USUAL}; inc751, b126; 250, 450, 600 mm3/mm",
        band=Band(0.4, 0.65),
        measure=lambda rig: on_volume(rig, "b126"),
        basis=Basis(Evidence.DRAWN, f"{VALVES}: .41 and .64"),
    ),
    Check(
        name="wear on volume a60j",
        group=7,
        what="exponent of wear on volume since the dress, alumina",
        at=f"{USUAL}; inc751; 250, 450, 600 mm3/mm",
        band=Band(0.85, 1.25),
        measure=lambda rig: on_volume(rig, "a60j"),
        basis=Basis(Evidence.DRAWN, f"{VALVES}: .95 to 1.25"),
    ),
    Check(
        name="initial wear",
        group=7,
        what="that exponent of alumina less that of cBN: initial wear matters more for cBN",
        at=f"{USUAL}; inc751; 250, 450, 600 mm3/mm",
        band=at_least(0.2),
        measure=lambda rig: on_volume(rig, "a60j") - on_volume(rig, "b126"),
        basis=Basis(Evidence.DRAWN, f"{VALVES}: .31 to .84"),
    ),
)
