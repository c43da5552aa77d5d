"""Checks against published tables: orders of magnitude, ranges of specific energy, and optima of a known problem."""

from collections.abc import Mapping

from grind_env.evidence import Basis, Evidence
from grind_env.validation import measured_data
from grind_env.validation.check import Band, Check
from grind_env.validation.declared_checks import Measurement

#: the set-ups of expected_magnitudes.csv
CASES: Mapping[str, tuple[str, str]] = {
    "R1": ("52100/A60J, 30 m/s, 12 m/min, 10 um", ""),
    "R2": ("1020/A60J, 30 m/s, 18 m/min, 15 um", "material: aisi_1020; table_speed: 300; downfeed: 0.015; "),
    "R3a": ("718/A60J, 25 m/s, 10 m/min, 10 um", f"material: inconel_718; table_speed: {1000 / 6}; wheel_speed: 25; "),
    "R3b": (
        "718/B126, 35 m/s, 10 m/min, 10 um",
        f"material: inconel_718; table_speed: {1000 / 6}; wheel: b126; wheel_speed: 35; ",
    ),
}
#: set-up of a part that does not grow, because the published depth of cut is given
NO_GROWTH = "material.thermal_expansion: 0"
STATES = {"sharp": ("sharp", "sharp"), "dull": ("A 4 %", "dulled 0.04")}
QUANTITIES = {
    "specific energy": "u_s",
    "tangential force": "Ft",
    "normal force": "Fn",
    "power": "power_per_width",
    "temperature rise": "T",
    "roughness": "Rg",
    "G-ratio": "G",
}
ENERGIES = {"Cast iron (class 40)": "grey_cast_iron", "Tool steel T15": "aisi_m2"}
MAGNITUDES, KALPAKJIAN, OPTIMA = (
    Basis(Evidence.REMEMBERED, text)
    for text in (
        "expected_magnitudes.csv: a reading of Malkin and Rowe",
        "specific_energy_ranges.csv: Kalpakjian & Schmid",
        "wen_optima.csv: their Ra follows from dress and speeds alone; within x 2",
    )
)


def magnitude(row: dict[str, str]) -> Check:
    """Return the check of an order of magnitude of a set-up."""
    conditions, setup = CASES[row["case"]]
    name, _, state = row["quantity"].rpartition(" ")
    said, wheel = STATES[state]
    return Check(
        name=f"{row['case']} {row['quantity']}",
        group=10,
        what=f"{name}, {row['case']}",
        at=f"{conditions}, emulsion, 20 mm wide; {said}",
        band=Band(float(row["low"]), float(row["high"])),
        measure=Measurement(QUANTITIES[name], wheel, setup + NO_GROWTH),
        unit=row["unit"].strip("-"),
        basis=MAGNITUDES,
    )


def energy_range(row: dict[str, str]) -> Check:
    """Return the check of the range of the specific energy of a material."""
    material = ENERGIES[row["material"]]
    return Check(
        name=f"specific energy {material}",
        group=10,
        what=f"specific energy, {row['material']} ({row['hardness']}) by {material}",
        at=f"usual; {material}; sharp",
        band=Band(float(row["u_min_J_mm3"]), float(row["u_max_J_mm3"])),
        measure=Measurement("u_s", "sharp", f"material: {material}"),
        unit="J/mm3",
        basis=KALPAKJIAN,
    )


def optimum(row: dict[str, str]) -> Check:
    """Return the check of Ra at a published optimum of the problem of Wen, Tay and Nee."""
    speeds = f"wheel_speed: {float(row['Vs_m_min']) / 60.0}; table_speed: {float(row['Vw_m_min']) / 0.06}"
    cut = f"downfeed: {row['ap_mm']}; depth: {row['doc_mm']}; lead: {row['L_mm']}"
    Ra = float(row["Ra_um"])
    return Check(
        name=f"optimum {row['id']}",
        group=10,
        what=f"Ra at an optimum of Wen, Tay & Nee: {row['source']}, {row['case']}",
        at="usual; grit .3 mm, 355 mm; freshly dressed; speeds, depth and dress of the optimum",
        band=Band(0.5 * Ra, 2.0 * Ra),
        measure=Measurement("Rg", "fresh", f"{speeds}; {cut}; diameter: 355; wheel.grit_size: 0.3"),
        unit="um",
        reference=Ra,
        basis=OPTIMA,
    )


CHECKS = (
    *map(magnitude, measured_data.rows("expected_magnitudes")),
    *(energy_range(row) for row in measured_data.rows("specific_energy_ranges") if row["material"] in ENERGIES),
    *map(optimum, measured_data.rows("wen_optima")),
)
