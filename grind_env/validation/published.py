"""Group 10: single numbers of books, papers and practice."""

from collections.abc import Callable, Mapping
from typing import Any

from grind_env.evidence import Basis, Evidence
from grind_env.validation import data
from grind_env.validation.check import Band, Check, around, at_most
from grind_env.validation.measures import dull, value
from grind_env.validation.rig import NO_GROWTH, USUAL, Grinder, Rig, dress_width
from grind_env.validation.spark_out import after_passes

CASES: Mapping[str, tuple[str, dict[str, Any]]] = {
    "R1": ("52100/A60J, 30 m/s, 12 m/min, 10 um", {}),
    "R2": ("1020/A60J, 30 m/s, 18 m/min, 15 um", {"material": "aisi_1020", "table_speed": 300.0, "downfeed": 0.015}),
    "R3a": (
        "718/A60J, 25 m/s, 10 m/min, 10 um",
        {"material": "inconel_718", "wheel_speed": 25.0, "table_speed": 1000.0 / 6.0},
    ),
    "R3b": (
        "718/B126, 35 m/s, 10 m/min, 10 um",
        {"material": "inconel_718", "wheel": "b126", "wheel_speed": 35.0, "table_speed": 1000.0 / 6.0},
    ),
}
"""The set-ups of expected_magnitudes.csv."""
DULL = 0.04
"""Wear-flat area of a dull wheel."""

QUANTITIES: Mapping[str, Callable[[Grinder], float]] = {
    "specific energy": lambda grinder: grinder.grind(5).u_s,
    "tangential force": lambda grinder: grinder.grind(5).Ft,
    "normal force": lambda grinder: grinder.grind(5).Fn,
    "power": lambda grinder: grinder.grind(5).power / grinder.setup.width,
    "temperature rise": lambda grinder: grinder.grind(5).T,
    "roughness": lambda grinder: grinder.grind(5).Rg,
    "G-ratio": lambda grinder: grinder.grind(5).G,
}

KALPAKJIAN = Basis(Evidence.REMEMBERED, "specific_energy_ranges.csv: Kalpakjian & Schmid")
GRID = Basis(Evidence.REMEMBERED, "burn_threshold_grid.csv: Malkin 1978; Wen, Tay & Nee 1992")
OPTIMA = Basis(Evidence.REMEMBERED, "wen_optima.csv: their Ra follows from dress and speeds alone; within x 2")
OVERLAP = Basis(
    Evidence.DRAWN,
    "dressing_overlap_worked_example.csv: moderngrindingtechnology.com, worked out there and not measured",
)


def magnitude(row: dict[str, str]) -> Check:
    """An order of magnitude of a set-up."""
    conditions, setup = CASES[row["case"]]
    setup = {**setup, "changes": NO_GROWTH}  # of the depth of cut that is told
    name, _, state = row["quantity"].rpartition(" ")

    def measure(rig: Rig) -> float:
        return QUANTITIES[name](rig.sharp(**setup) if state == "sharp" else rig.dulled(DULL, **setup))

    return Check(
        name=f"{row['case']} {row['quantity']}",
        group=10,
        what=f"{name}, {row['case']}",
        at=f"{conditions}, emulsion, 20 mm wide; {'sharp' if state == 'sharp' else 'A 4 %'}",
        unit=row["unit"].strip("-"),
        band=Band(float(row["low"]), float(row["high"])),
        measure=measure,
        basis=Basis(Evidence.REMEMBERED, data.MAGNITUDES),
    )


def energy_range(published: str, material: str) -> Check:
    """The range of the specific energy of a material."""
    row = next(row for row in data.rows("specific_energy_ranges") if row["material"] == published)
    return Check(
        name=f"specific energy {material}",
        group=10,
        what=f"specific energy, {published} ({row['hardness']}) by {material}",
        at=f"{USUAL}; {material}; sharp",
        unit="J/mm3",
        band=Band(float(row["u_min_J_mm3"]), float(row["u_max_J_mm3"])),
        measure=lambda rig: rig.sharp(material=material).grind(5).u_s,
        basis=KALPAKJIAN,
    )


def optimum(row: dict[str, str]) -> Check:
    """Ra at a published optimum of the problem of Wen, Tay and Nee."""
    setup = {
        "wheel_speed": float(row["Vs_m_min"]) / 60.0,
        "table_speed": float(row["Vw_m_min"]) / 0.06,
        "downfeed": float(row["ap_mm"]),
        "depth": float(row["doc_mm"]),
        "lead": float(row["L_mm"]),
        "diameter": 355.0,
        "changes": {"wheel": {"grit_size": 0.3}},
    }
    Ra = float(row["Ra_um"])
    return Check(
        name=f"optimum {row['id']}",
        group=10,
        what=f"Ra at an optimum of Wen, Tay & Nee: {row['source']}, {row['case']}",
        at=f"{USUAL}; grit .3 mm, 355 mm; freshly dressed; speeds, depth and dress of the optimum",
        unit="um",
        reference=Ra,
        band=Band(0.5 * Ra, 2.0 * Ra),
        measure=lambda rig: rig.fresh(**setup).grind(5).Rg,
        basis=OPTIMA,
    )


def burn_threshold_error(rig: Rig) -> float:
    """Largest deviation of the model's burn threshold, u_s/Br, from the grid, %."""
    errors = []
    for row in data.rows("burn_threshold_grid"):
        speed, depth = float(row["vw_m_min"]) / 0.06, float(row["ae_um"]) / 1000.0
        done = rig.fresh(diameter=float(row["De_mm"]), table_speed=speed, constant_surface_speed=True).cut(depth)
        errors.append(abs(done.u_s / done.Br / float(row["ustar_J_mm3"]) - 1.0))
    return 100.0 * max(errors)


def dull_to_burn(rig: Rig) -> Grinder:
    """A wheel with the wear-flat area at which the burn ratio of its steady stroke is 1; found by bisection."""
    low, high = 0.005, 0.14
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rig.dulled(middle).grind(5).Br < 1.0 else (low, middle)
    return rig.dulled(high)


def linearity(rig: Rig) -> float:
    """Specific energy at A 4 % over the mean of those at 2 and 6 %, at one depth of cut."""
    low, middle, high = (rig.dulled(flats).cut(0.010).u_s for flats in (0.02, 0.04, 0.06))
    return 2.0 * middle / (low + high)


def least_energy(rig: Rig) -> float:
    """Specific energy of a cut so deep that only chips count, J/mm3.

    What flats and ploughing add falls with the square root of the depth; cuts of 20 and 80 um give what is left.
    """
    grinder = rig.sharp(width=5.0)
    return 2.0 * grinder.cut(0.080).u_s - grinder.cut(0.020).u_s


def dressed_share(rig: Rig) -> float:
    """Share of the wheel that the dresser takes: a dress every 15 parts of 0.1 mm stock, %."""
    grinder = rig.sharp()
    removed = grinder.dress()
    worn = 0.0
    for _ in range(15):
        grinder.new_part()
        grinder.grind(10)
        grinder.grind(2, 0.0)
        worn += grinder.worn
    return 100.0 * removed / (removed + worn)


def diameter_effect(rig: Rig) -> float:
    """Radial wear of a 15 in wheel over that of an 18 in one after the same stock, at one surface speed."""
    depths = []
    for inches in (15.0, 18.0):
        grinder = rig.steady(diameter=25.4 * inches, constant_surface_speed=True)
        grinder.grind_volume(100.0)
        depths.append(grinder.wheel.W)
    return depths[0] / depths[1]


def fine_cbn(rig: Rig) -> float:
    """Ra of a finely dressed cBN wheel after full spark-out, um."""
    grinder = rig.sharp(wheel="b126", wheel_speed=35.0, lead=0.04, depth=0.005)
    grinder.grind(10)
    return grinder.grind(40, 0.0).Ra


CHECKS = (
    *(magnitude(row) for row in data.rows("expected_magnitudes")),
    energy_range("Cast iron (class 40)", "grey_cast_iron"),
    energy_range("Tool steel T15", "aisi_m2"),
    *(optimum(row) for row in data.rows("wen_optima")),
    Check(
        name="specific energy 1045 by handbook",
        group=10,
        what="specific energy, Ck45 by the handbook method k_c1.1",
        at=f"{USUAL}; aisi_1045; 20 um, 15 m/min; sharp",
        unit="J/mm3",
        band=Band(21.6, 25.5),
        measure=lambda rig: rig.sharp(material="aisi_1045", downfeed=0.020, table_speed=250.0).grind(5).u_s,
        basis=Basis(Evidence.DRAWN, "page_numbers.csv: Dietrich & Tschaetsch as coded by others"),
    ),
    Check(
        name="least specific energy",
        group=10,
        what="specific energy of a cut so deep that only chips count",
        at=f"{USUAL}; 5 mm wide; from cuts of 20 and 80 um; sharp",
        unit="J/mm3",
        reference=data.number("malkin_energy_wearflat", "u_ch", "value_or_min"),
        band=around(13.8, 0.7),
        measure=least_energy,
        basis=Basis(Evidence.REMEMBERED, "malkin_energy_wearflat.csv: Malkin"),
    ),
    Check(
        name="energy linear in flats",
        group=10,
        what="specific energy at A 4 % over the mean of 2 and 6 %",
        at=f"{USUAL}; 10 um cut",
        band=around(1.0, 0.01),
        measure=linearity,
        basis=Basis(Evidence.REMEMBERED, "Malkin & Cook 1971"),
    ),
    Check(
        name="flats at burn",
        group=10,
        what="wear-flat area at which the burn ratio is 1",
        at=USUAL,
        unit="%",
        reference=data.number("malkin_energy_wearflat", "A_burn", "value_or_min"),
        band=Band(2.0, 6.0),
        measure=lambda rig: 100.0 * dull_to_burn(rig).wheel.A,
        basis=Basis(Evidence.REMEMBERED, "malkin_energy_wearflat.csv: Malkin & Cook 1971"),
    ),
    Check(
        name="temperature at burn",
        group=10,
        what="temperature rise at which the burn ratio is 1",
        at=USUAL,
        unit="K",
        band=Band(230.0, 980.0),
        measure=lambda rig: dull_to_burn(rig).grind(5).T,
        basis=Basis(
            Evidence.DRAWN,
            "page_numbers.csv: temper colours from 250, damage up to 1000 degC (Badger 2012, Tarasov 1951)",
        ),
    ),
    Check(
        name="burn threshold grid",
        group=10,
        what="burn threshold, largest deviation over 32 depths, speeds and diameters",
        at="52100, A60J, freshly dressed",
        unit="%",
        band=at_most(10.0),
        measure=burn_threshold_error,
        basis=GRID,
    ),
    Check(
        name="dress width",
        group=10,
        what="active width of a diamond of .38 mm radius, .025 mm deep",
        at="unworn",
        unit="mm",
        reference=data.number("dressing_overlap_worked_example", "pitch_for_one_overlay", "value", "quantity"),
        band=around(0.273, 0.003),
        measure=lambda rig: dress_width(0.025, 0.38),
        basis=OVERLAP,
    ),
    Check(
        name="dress overlap",
        group=10,
        what="overlap ratio of the same at 192.5 mm/min and 1410 rpm",
        at="unworn",
        reference=2.0,
        band=around(2.0, 0.05),
        measure=lambda rig: dress_width(0.025, 0.38) / (192.5 / 1410.0),
        basis=OVERLAP,
    ),
    Check(
        name="partition after boiling, steel",
        group=10,
        what="energy partition, dry, in steel by alumina",
        at=f"{USUAL}; dry; sharp",
        band=Band(0.60, 0.75),
        measure=lambda rig: rig.sharp(fluid="dry").grind(5).eps,
        basis=Basis(Evidence.REMEMBERED, "thermal_partition.csv: Malkin & Guo 2007"),
    ),
    Check(
        name="G-ratio conventional",
        group=10,
        what="G-ratio of a usual job",
        at=f"{USUAL}; sharp",
        band=Band(20.0, 80.0),
        measure=lambda rig: rig.sharp().grind(5).G,
        basis=Basis(
            Evidence.DRAWN, "page_numbers.csv: toolingu.com; Groover's 95 to 125 excludes it and was not chosen"
        ),
    ),
    Check(
        name="share of the dresser",
        group=10,
        what="share of the wheel volume that the dresser takes",
        at=f"{USUAL}; wheel 25 mm wide; 2 passes of .02 mm every 15 parts of .1 mm stock",
        unit="%",
        band=Band(70.0, 80.0),
        measure=dressed_share,
        basis=Basis(
            Evidence.DRAWN, "wheelwear_gratio_practice.csv: psiworldweb.com, a vendor on high-volume production"
        ),
    ),
    Check(
        name="smaller wheel wears faster",
        group=10,
        what="radial wear, 15 in wheel over 18 in wheel, same stock and surface speed",
        at=f"{USUAL}; steady wear over 100 mm3/mm from the dress on",
        reference=1.2,
        band=Band(1.15, 1.3),
        measure=diameter_effect,
        basis=Basis(Evidence.DRAWN, "page_numbers.csv: Badger 2009, a column: about 20 % more, how found is not said"),
    ),
    Check(
        name="fine cBN roughness",
        group=10,
        what="Ra of a finely dressed cBN wheel after full spark-out",
        at=f"{USUAL}; b126, 35 m/s, lead .04, depth .005; 10 strokes, 40 spark-out",
        unit="um",
        reference=0.1,
        band=Band(0.05, 0.2),
        measure=fine_cbn,
        basis=Basis(
            Evidence.MEASURED,
            "14 of 16 means of 320 parts of 52100 lie at .078 to .108 (Wu & Zha, cylindrical grinding); within x 2",
        ),
    ),
    Check(
        name="roughness of M2",
        group=10,
        what="Ra of high-speed steel",
        at=f"{USUAL}; aisi_m2; sharp",
        unit="um",
        band=Band(0.231, 1.25),
        measure=lambda rig: rig.sharp(material="aisi_m2").grind(5).Rg,
        basis=Basis(Evidence.DRAWN, "page_numbers.csv: W18CR4V, PMC11904558"),
    ),
    Check(
        name="force after spark-out, dull",
        group=10,
        what="normal force after ten passes over the threshold's",
        at=f"{USUAL}; A 4 %; 10 strokes before",
        band=around(1.0, 0.1),
        measure=value(after_passes("Fn"), dull(DULL), changes=NO_GROWTH),
        basis=Basis(Evidence.OWN, "the band of a sharp wheel (group 5), asked of a dull one"),
    ),
)
