"""Group 10: single numbers of books, papers and practice."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from grind_env.validation import data
from grind_env.validation.check import Band, Check, Question, around, at_most, drawn, measured, own, remembered
from grind_env.validation.measures import MakeWheel, Measurement, Quantity, dull, over, quotient, stroke, value
from grind_env.validation.rig import NO_GROWTH, Grinder, Rig, dress_width
from grind_env.validation.roughness import sparked_out
from grind_env.validation.spark_out import after_passes

NICKEL = {"material": "inconel_718", "table_speed": 1000.0 / 6.0}
CASES: Mapping[str, tuple[str, dict[str, Any]]] = {
    "R1": ("52100/A60J, 30 m/s, 12 m/min, 10 um", {}),
    "R2": ("1020/A60J, 30 m/s, 18 m/min, 15 um", {"material": "aisi_1020", "table_speed": 300.0, "downfeed": 0.015}),
    "R3a": ("718/A60J, 25 m/s, 10 m/min, 10 um", {**NICKEL, "wheel_speed": 25.0}),
    "R3b": ("718/B126, 35 m/s, 10 m/min, 10 um", {**NICKEL, "wheel": "b126", "wheel_speed": 35.0}),
}
"""The set-ups of expected_magnitudes.csv."""
DULL = 0.04
"""Wear-flat area of a dull wheel."""

QUANTITIES: Mapping[str, Quantity] = {
    "specific energy": stroke("u_s"),
    "tangential force": stroke("Ft"),
    "normal force": stroke("Fn"),
    "power": lambda grinder: grinder.grind(5).power / grinder.setup.width,
    "temperature rise": stroke("T"),
    "roughness": stroke("Rg"),
    "G-ratio": stroke("G"),
}

KALPAKJIAN = remembered("specific_energy_ranges.csv: Kalpakjian & Schmid")
GRID = remembered("burn_threshold_grid.csv: Malkin 1978; Wen, Tay & Nee 1992")
OPTIMA = remembered("wen_optima.csv: their Ra follows from dress and speeds alone; within x 2")
OVERLAP = drawn("dressing_overlap_worked_example.csv: moderngrindingtechnology.com, worked out there and not measured")
MALKIN_COOK = remembered("malkin_energy_wearflat.csv: Malkin & Cook 1971")

ask = partial(Question, 10)


def magnitude(row: dict[str, str]) -> Check:
    """Return the check of an order of magnitude of a set-up."""
    conditions, setup = CASES[row["case"]]
    name, _, state = row["quantity"].rpartition(" ")
    make: MakeWheel = Rig.sharp if state == "sharp" else dull(DULL)
    said = "sharp" if state == "sharp" else "A 4 %"
    # the depth of cut is told, so that the part must not grow
    measure = value(QUANTITIES[name], make, **setup, changes=NO_GROWTH)
    return ask(
        f"{row['case']} {row['quantity']}", f"{name}, {row['case']}", f"{conditions}, emulsion, 20 mm wide; {said}"
    ).within(Band(float(row["low"]), float(row["high"])), measure, remembered(data.MAGNITUDES), row["unit"].strip("-"))


def energy_range(published: str, material: str) -> Check:
    """Return the check of the range of the specific energy of a material."""
    row = next(row for row in data.rows("specific_energy_ranges") if row["material"] == published)
    return ask(
        f"specific energy {material}",
        f"specific energy, {published} ({row['hardness']}) by {material}",
        f"usual; {material}; sharp",
    ).within(
        Band(float(row["u_min_J_mm3"]), float(row["u_max_J_mm3"])),
        value(stroke("u_s"), material=material),
        KALPAKJIAN,
        "J/mm3",
    )


def optimum(row: dict[str, str]) -> Check:
    """Return the check of Ra at a published optimum of the problem of Wen, Tay and Nee."""
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
    return ask(
        f"optimum {row['id']}",
        f"Ra at an optimum of Wen, Tay & Nee: {row['source']}, {row['case']}",
        "usual; grit .3 mm, 355 mm; freshly dressed; speeds, depth and dress of the optimum",
    ).within(Band(0.5 * Ra, 2.0 * Ra), value(stroke("Rg"), Rig.fresh, **setup), OPTIMA, "um", Ra)


def burn_threshold_error(rig: Rig) -> float:
    """Return the largest deviation of the model's burn threshold, u_s/Br, from the grid, %."""
    errors = []
    for row in data.rows("burn_threshold_grid"):
        speed, depth = float(row["vw_m_min"]) / 0.06, float(row["ae_um"]) / 1000.0
        done = rig.fresh(diameter=float(row["De_mm"]), table_speed=speed, constant_surface_speed=True).cut(depth)
        errors.append(abs(done.u_s / done.Br / float(row["ustar_J_mm3"]) - 1.0))
    return 100.0 * max(errors)


def dull_to_burn(rig: Rig) -> Grinder:
    """Make a wheel with the wear-flat area at which the burn ratio of its steady stroke is 1; found by bisection."""
    low, high = 0.005, 0.14
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rig.dulled(middle).grind(5).Br < 1.0 else (low, middle)
    return rig.dulled(high)


def linearity(rig: Rig) -> float:
    """Return the specific energy at A 4 % over the mean of those at 2 and 6 %, at one depth of cut."""
    low, middle, high = (rig.dulled(flats).cut(0.010).u_s for flats in (0.02, 0.04, 0.06))
    return 2.0 * middle / (low + high)


def least_energy(grinder: Grinder) -> float:
    """Return the specific energy of a cut so deep that only chips count, J/mm3.

    What flats and ploughing add falls with the square root of the depth; cuts of 20 and 80 um give what is left.
    """
    return 2.0 * grinder.cut(0.080).u_s - grinder.cut(0.020).u_s


def dressed_share(grinder: Grinder) -> float:
    """Return the share of the wheel that the dresser takes: a dress every 15 parts of 0.1 mm stock, %."""
    removed = grinder.dress()
    worn = 0.0
    for _ in range(15):
        grinder.new_part()
        grinder.grind(10)
        grinder.grind(2, 0.0)
        worn += grinder.worn
    return 100.0 * removed / (removed + worn)


def wear_depth(grinder: Grinder) -> float:
    """Return the radial wear after some stock, mm."""
    grinder.grind_volume(100.0)
    return grinder.wheel.W


CHECKS = (
    *map(magnitude, data.rows("expected_magnitudes")),
    energy_range("Cast iron (class 40)", "grey_cast_iron"),
    energy_range("Tool steel T15", "aisi_m2"),
    *map(optimum, data.rows("wen_optima")),
    ask(
        "specific energy 1045 by handbook",
        "specific energy, Ck45 by the handbook method k_c1.1",
        "usual; aisi_1045; 20 um, 15 m/min; sharp",
    ).within(
        Band(21.6, 25.5),
        value(stroke("u_s"), material="aisi_1045", downfeed=0.020, table_speed=250.0),
        drawn("page_numbers.csv: Dietrich & Tschaetsch as coded by others"),
        "J/mm3",
    ),
    ask(
        "least specific energy",
        "specific energy of a cut so deep that only chips count",
        "usual; 5 mm wide; from cuts of 20 and 80 um; sharp",
    ).within(
        around(13.8, 0.7),
        value(least_energy, width=5.0),
        remembered("malkin_energy_wearflat.csv: Malkin"),
        "J/mm3",
        data.number("malkin_energy_wearflat", "u_ch", "value_or_min"),
    ),
    ask("energy linear in flats", "specific energy at A 4 % over the mean of 2 and 6 %", "usual; 10 um cut").within(
        around(1.0, 0.01), linearity, remembered("Malkin & Cook 1971")
    ),
    ask("flats at burn", "wear-flat area at which the burn ratio is 1").within(
        Band(2.0, 6.0),
        lambda rig: 100.0 * dull_to_burn(rig).wheel.A,
        MALKIN_COOK,
        "%",
        data.number("malkin_energy_wearflat", "A_burn", "value_or_min"),
    ),
    ask("temperature at burn", "temperature rise at which the burn ratio is 1").within(
        Band(230.0, 980.0),
        lambda rig: dull_to_burn(rig).grind(5).T,
        drawn("page_numbers.csv: temper colours from 250, damage up to 1000 degC (Badger 2012, Tarasov 1951)"),
        "K",
    ),
    ask(
        "burn threshold grid",
        "burn threshold, largest deviation over 32 depths, speeds and diameters",
        "52100, A60J, freshly dressed",
    ).within(at_most(10.0), burn_threshold_error, GRID, "%"),
    ask("dress width", "active width of a diamond of .38 mm radius, .025 mm deep", "unworn").within(
        around(0.273, 0.003),
        lambda rig: dress_width(0.025, 0.38),
        OVERLAP,
        "mm",
        data.number("dressing_overlap_worked_example", "pitch_for_one_overlay", "value", "quantity"),
    ),
    ask("dress overlap", "overlap ratio of the same at 192.5 mm/min and 1410 rpm", "unworn").within(
        around(2.0, 0.05), lambda rig: dress_width(0.025, 0.38) / (192.5 / 1410.0), OVERLAP, reference=2.0
    ),
    ask("partition after boiling, steel", "energy partition, dry, in steel by alumina", "usual; dry; sharp").within(
        Band(0.60, 0.75), value(stroke("eps"), fluid="dry"), remembered("thermal_partition.csv: Malkin & Guo 2007")
    ),
    ask("G-ratio conventional", "G-ratio of a usual job", "usual; sharp").within(
        Band(20.0, 80.0),
        value(stroke("G")),
        drawn("page_numbers.csv: toolingu.com; Groover's 95 to 125 excludes it and was not chosen"),
    ),
    ask(
        "share of the dresser",
        "share of the wheel volume that the dresser takes",
        "usual; wheel 25 mm wide; 2 passes of .02 mm every 15 parts of .1 mm stock",
    ).within(
        Band(70.0, 80.0),
        value(dressed_share),
        drawn("wheelwear_gratio_practice.csv: psiworldweb.com, a vendor on high-volume production"),
        "%",
    ),
    ask(
        "smaller wheel wears faster",
        "radial wear, 15 in wheel over 18 in wheel, same stock and surface speed",
        "usual; steady wear over 100 mm3/mm from the dress on",
    ).within(
        Band(1.15, 1.3),
        Measurement(
            wear_depth, over("diameter", (25.4 * 15.0, 25.4 * 18.0), constant_surface_speed=True), quotient, Rig.steady
        ),
        drawn("page_numbers.csv: Badger 2009, a column: about 20 % more, how found is not said"),
        reference=1.2,
    ),
    ask(
        "fine cBN roughness",
        "Ra of a finely dressed cBN wheel after full spark-out",
        "usual; b126, 35 m/s, lead .04, depth .005; 10 strokes, 40 spark-out",
    ).within(
        Band(0.05, 0.2),
        value(sparked_out, wheel="b126", wheel_speed=35.0, lead=0.04, depth=0.005),
        measured(
            "14 of 16 means of 320 parts of 52100 lie at .078 to .108 (Wu & Zha, cylindrical grinding); within x 2"
        ),
        "um",
        0.1,
    ),
    ask("roughness of M2", "Ra of high-speed steel", "usual; aisi_m2; sharp").within(
        Band(0.231, 1.25),
        value(stroke("Rg"), material="aisi_m2"),
        drawn("page_numbers.csv: W18CR4V, PMC11904558"),
        "um",
    ),
    ask(
        "force after spark-out, dull",
        "normal force after ten passes over the threshold's",
        "usual; A 4 %; 10 strokes before",
    ).within(
        around(1.0, 0.1),
        value(after_passes("Fn"), dull(DULL), changes=NO_GROWTH),
        own("the band of a sharp wheel (group 5), asked of a dull one"),
    ),
)
