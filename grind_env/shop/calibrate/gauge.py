"""What was measured of the parts: size, roughness, burn, diameter of the wheel; many cells are empty."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grind_env.arrays import Numbers
from grind_env.errors import quoted
from grind_env.files import shown
from grind_env.shop.calibrate.columns import Map, find_columns, names_of, not_used
from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.calibrate.sheet import Floats, Sheet, plain, read_sheet

INCH = 25.4
LENGTHS = {"mm": 1.0, "um": 1e-3, "nm": 1e-6, "in": INCH, "inch": INCH, "uin": 1e-6 * INCH}
"""mm of units of length."""
MOST_DIGITS = 18
"""Of the number of a part; one with more of them is none."""
MOST_DEVIATION = 1.0
"""mm; a size above that is one of the part and not its deviation."""
YES = ("1", "true", "yes", "y", "ja", "j", "x", "si", "oui", "o", "s", "burn", "burnt", "brand", "nok", "nio")
NO = ("0", "false", "no", "n", "nein", "-", "non", "nee", "ok", "io", "none", "kein", "keiner")


@dataclass(frozen=True, slots=True)
class Gauge:
    """What was measured; arrays have a value for each row, NaN where nothing was measured.

    Attributes:
        part: number of each, from 1 in the order in which they were ground.
        size: stock left on it, um.
        Ra: um.
        burn: 1 if it is burnt, else 0.
        diameter: of the wheel after it, mm.
        remarks: what was made of the file, as sentences.
    """

    part: Numbers
    size: Floats
    Ra: Floats
    burn: Floats
    diameter: Floats
    remarks: tuple[str, ...]


def read_gauge(path: Path, said: Map) -> Gauge:
    """Read what was measured of parts.

    Raises:
        CalibrationError: it has none of these columns, or a size that is no deviation without its nominal one.
    """
    sheet = read_sheet(path)
    columns = find_columns(sheet, "gauge", said)
    measured = [name for name in ("size", "Ra", "burn", "diameter") if name in columns]
    if not measured:
        raise CalibrationError(
            f"{shown(path)} has no column of size, Ra, burn or wheel diameter among {names_of(sheet)}; say which they "
            'are with a map: [gauge] Ra = "..."'
        )
    rows = len(sheet.cells)
    remarks = [f"{name} is column {quoted(sheet.headings[columns[name]].name)}" for name in measured]
    remarks += not_used(sheet, columns.values())
    empty = np.full(rows, np.nan)
    size = _size(sheet, columns["size"], said, remarks) if "size" in columns else empty
    Ra = 1e3 * _length(sheet, columns["Ra"], "um", remarks) if "Ra" in columns else empty
    burn = _burnt(sheet, columns["burn"]) if "burn" in columns else empty
    diameter = _length(sheet, columns["diameter"], "mm", remarks) if "diameter" in columns else empty
    Ra = np.where(Ra > 0.0, Ra, np.nan)
    if np.isfinite(diameter).sum() == 1:
        remarks.append("one diameter of the wheel alone tells nothing: of diameters their differences count")
    part = _parts(sheet, columns.get("part"), rows)
    return Gauge(part, size, Ra, burn, np.where(diameter > 0.0, diameter, np.nan), tuple(remarks))


def _parts(sheet: Sheet, column: int | None, rows: int) -> Numbers:
    """Numbers of the parts from 1 on: those of the column if they are such, else in the order of the rows."""
    in_order = np.arange(1, rows + 1)
    if column is None:
        return in_order
    numbers = [re.search(r"(\d+)\D*$", text) for text in sheet.texts(column)]
    digits = [match[1].lstrip("0") if match else "" for match in numbers]
    for row, each in enumerate(digits):
        if len(each) > MOST_DIGITS:
            raise sheet.not_measured(column, row)
    found = np.array([int(each or "0") for each in digits], np.int64)
    if np.any(found == 0) or np.any(np.diff(found) <= 0):
        return in_order
    return found if found[0] < 1000 and found[-1] <= 10 * rows else found - found[0] + 1


def _length(sheet: Sheet, column: int, usual: str, remarks: list[str]) -> Floats:
    """A column of lengths, mm."""
    heading = sheet.headings[column]
    unit = plain(heading.unit)
    if unit and unit not in LENGTHS:
        remarks.append(f"{quoted(heading.unit)} at {quoted(heading.name)} is no unit that is known; {usual} is taken")
    return sheet.numbers(column) * LENGTHS.get(unit, LENGTHS[usual])


def _size(sheet: Sheet, column: int, said: Map, remarks: list[str]) -> Floats:
    """Stock left, um: a deviation as such, a size less the nominal one."""
    values, said_unit = sheet.numbers(column), said.value("gauge", "size_unit")
    unit = plain(str(said_unit or sheet.headings[column].unit))
    if said_unit is not None and unit not in LENGTHS:
        raise CalibrationError(
            f"{said.file}: gauge.size_unit is {quoted(said_unit)}, but must be one of {', '.join(LENGTHS)}"
        )
    if unit not in LENGTHS:
        largest = float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else 0.0
        unit = "um" if largest > 0.2 and np.all(np.nan_to_num(values * 10.0) % 1.0 == 0.0) and largest < 500.0 else "mm"
        remarks.append(f"the size has no unit; by its numbers it is taken to be in {unit}")
    mm, nominal = values * LENGTHS[unit], said.number("gauge", "nominal_size")
    if nominal is not None:
        return 1e3 * (mm - nominal)
    if np.isfinite(mm).any() and np.nanmedian(np.abs(mm)) > MOST_DEVIATION:
        raise CalibrationError(
            f"{shown(sheet.path)}: the sizes, such as {np.nanmedian(mm):g} mm, are no deviations; say the nominal one "
            "with a map: [gauge] nominal_size = ..."
        )
    return 1e3 * mm


def _burnt(sheet: Sheet, column: int) -> Floats:
    """1 for yes, 0 for no, NaN for what is neither."""
    words = [plain(text).strip(".") for text in sheet.texts(column)]
    return np.array([1.0 if word in YES else 0.0 if word in NO else np.nan for word in words])
