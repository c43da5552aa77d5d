"""What was measured of the parts: size, roughness, burn, diameter of the wheel; many cells are empty."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grind_env.arrays import Numbers
from grind_env.files import shown
from grind_env.shop.calibrate.columns import Map, find_columns
from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.calibrate.sheet import MICROMETRES, MILLIMETRES, Floats, Sheet, read_sheet

MOST_DIGITS = 18
"""Of the number of a part; one with more of them is none."""
MOST_DEVIATION = 1.0
"""mm; a size above that is one of the part and not its deviation."""


@dataclass(frozen=True, slots=True)
class GaugedParts:
    """What was measured of parts, a value for each row, NaN where nothing was measured.

    Parts count from 1 in the order of grinding; size (stock left) and Ra in um, the wheel's diameter after the part in
    mm, burn 1 or 0; remarks are sentences about the file.
    """

    part: Numbers
    size: Floats
    Ra: Floats
    burn: Floats
    diameter: Floats
    remarks: tuple[str, ...]


def read_gauge(path: Path, said: Map) -> GaugedParts:
    """Read what was measured of parts; a `CalibrationError` says why it cannot be used."""
    sheet = read_sheet(path)
    columns = find_columns(sheet, "gauge", said, ("size", "Ra", "burn", "diameter"))
    empty = np.full(len(sheet.rows), np.nan)
    size = _size(sheet, columns["size"], said) if "size" in columns else empty
    Ra = sheet.quantity(columns["Ra"], MICROMETRES, above=0.0) if "Ra" in columns else empty
    burn = sheet.flags(columns["burn"]) if "burn" in columns else empty
    diameter = sheet.quantity(columns["diameter"], MILLIMETRES, above=0.0) if "diameter" in columns else empty
    if np.isfinite(diameter).sum() == 1:
        sheet.remarks.append("one diameter of the wheel alone tells nothing: of diameters their differences count")
    return GaugedParts(_parts(sheet, columns.get("part")), size, Ra, burn, diameter, tuple(sheet.remarks))


def _parts(sheet: Sheet, column: int | None) -> Numbers:
    """Return numbers of the parts from 1 on: those of the column if they are such, else in the order of the rows."""
    in_order = np.arange(1, len(sheet.rows) + 1)
    if column is None:
        return in_order
    numbers = [re.search(r"(\d+)\D*$", text) for text in sheet.texts(column)]
    digits = [match[1].lstrip("0") if match else "" for match in numbers]
    for row, each in enumerate(digits):
        if len(each) > MOST_DIGITS:
            raise sheet.not_measured(column, row)
    if any(numbers):
        sheet.checked(column, np.array([1.0 if match else np.nan for match in numbers]), "a part")
    found = np.array([int(each or "0") for each in digits], np.int64)
    if np.any(found == 0) or np.any(np.diff(found) <= 0):
        return in_order
    return found if found[0] < 1000 and found[-1] <= 10 * in_order.size else found - found[0] + 1


def _size(sheet: Sheet, column: int, said: Map) -> Floats:
    """Return the stock left, um: a deviation as such, a size less the nominal one."""
    values, unit = sheet.numbers(column), said.value("gauge", "size_unit")
    if not (unit or sheet.headings[column].unit):
        largest = np.nanmax(np.abs(values), initial=0.0)
        if 0.2 < largest < 500.0 and np.all(np.nan_to_num(values * 10.0) % 1.0 == 0.0):
            unit = "um"
        sheet.remarks.append(f"the size has no unit; by its numbers it is taken to be in {unit or 'mm'}")
    mm, nominal = values * sheet.factor(column, MILLIMETRES, unit), said.number("gauge", "nominal_size")
    if nominal is not None:
        return 1e3 * (mm - nominal)
    if np.isfinite(mm).any() and np.nanmedian(np.abs(mm)) > MOST_DEVIATION:
        raise CalibrationError(
            f"{shown(sheet.path)}: the sizes, such as {np.nanmedian(mm):g} mm, are no deviations; say the nominal one "
            "with a map: [gauge] nominal_size = ..."
        )
    return 1e3 * mm
