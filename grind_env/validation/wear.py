"""Group 7: the G-ratio by material, wheel, removal rate and volume."""

from typing import Any

from grind_env.validation.check import TREND, Band, Basis, Check, Evidence, at_least
from grind_env.validation.rig import USUAL, Grinder, Rig
from grind_env.validation.slopes import exponent

INTERVAL = 100.0
"""mm3/mm from the dress on over which slopes and ratios of G are taken: for every material, because alumina in nickel
alloys is dressed that soon."""
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


def used(rig: Rig, volume: float, **setup: Any) -> Grinder:
    """A wheel that has ground some mm3/mm from the dress on."""
    grinder = rig.fresh(**setup)
    grinder.grind_volume(volume)
    return grinder


def slope(material: str, wheel: str) -> Check:
    """Exponent of the G-ratio on the removal rate."""

    def measure(rig: Rig) -> float:
        ground = [used(rig, INTERVAL, material=material, wheel=wheel, table_speed=speed) for speed in SPEEDS]
        return exponent(SPEEDS, [grinder.g_ratio() for grinder in ground])

    band = SLOPES[material]
    unmeasured = Basis(Evidence.OWN, "nothing was measured of what is neither an easy alloy nor a nickel alloy")
    return Check(
        name=f"G slope {material} {wheel}",
        group=7,
        what=f"exponent of G on the removal rate, {material}, {WHEELS[wheel]}",
        at=f"{USUAL}; {material}, {wheel}; 6, 12, 18 m/min; over 100 mm3/mm from the dress on",
        band=band,
        measure=measure,
        basis=unmeasured if band is BETWEEN else Basis(Evidence.DRAWN, f"wear exponents of two valve alloys, {VALVES}"),
    )


def cbn_over_alumina(material: str) -> Check:
    """G-ratio of cBN over that of alumina."""

    def measure(rig: Rig) -> float:
        cbn, alumina = (used(rig, INTERVAL, material=material, wheel=wheel).g_ratio() for wheel in ("b126", "a60j"))
        return cbn / alumina

    return Check(
        name=f"G of cBN {material}",
        group=7,
        what=f"G-ratio of cBN over that of alumina, {material}",
        at=f"{USUAL}; {material}, b126 and a60j; over 100 mm3/mm from the dress on",
        band=RATIOS[material],
        measure=measure,
        basis=Basis(Evidence.DRAWN, VALVES) if RATIOS[material] is NICKEL else TREND,
    )


def on_volume(rig: Rig, wheel: str) -> float:
    """Exponent of the wear on the volume ground since the dress."""
    return exponent(VOLUMES, [used(rig, volume, wheel=wheel).worn for volume in VOLUMES])


CHECKS = (
    *(slope(material, wheel) for material in SLOPES for wheel in WHEELS),
    *(cbn_over_alumina(material) for material in RATIOS),
    Check(
        name="wear on volume b126",
        group=7,
        what="exponent of wear on volume since the dress, cBN",
        at=f"{USUAL}; b126; 250, 450, 600 mm3/mm",
        band=Band(0.4, 0.65),
        measure=lambda rig: on_volume(rig, "b126"),
        basis=Basis(Evidence.DRAWN, f"{VALVES}: .41 and .64"),
    ),
    Check(
        name="wear on volume a60j",
        group=7,
        what="exponent of wear on volume since the dress, alumina",
        at=f"{USUAL}; 250, 450, 600 mm3/mm",
        band=Band(0.85, 1.25),
        measure=lambda rig: on_volume(rig, "a60j"),
        basis=Basis(Evidence.DRAWN, f"{VALVES}: .95 to 1.25"),
    ),
    Check(
        name="initial wear",
        group=7,
        what="that exponent of alumina less that of cBN: initial wear matters more for cBN",
        at=f"{USUAL}; 250, 450, 600 mm3/mm",
        band=at_least(0.2),
        measure=lambda rig: on_volume(rig, "a60j") - on_volume(rig, "b126"),
        basis=Basis(Evidence.DRAWN, f"{VALVES}: .31 to .84"),
    ),
)
