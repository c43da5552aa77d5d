"""Gauged parts: size, roughness, burn, wheel diameter; and simulated gauge readings of a run."""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats, Numbers
from grind_env.files import shown
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord
from grind_env.shop.calibrate.column_names import Map, find_columns
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.least_squares import YES_OR_NO
from grind_env.shop.measurements.measured_sheet import MICROMETRES, MILLIMETRES, Sheet, read_sheet

MOST_DIGITS = 18  #: greatest number of digits of a part number
MOST_DEVIATION = 1.0  #: greatest size deviation, mm; a larger number is a size of the part

#: errors of touching off and gauging, um; of a roughness gauge, relative; of measuring a wheel diameter, mm
SIZE_ERROR, ROUGHNESS_ERROR, DIAMETER_ERROR = 2.0, 0.05, 0.02
LEAST_WHEEL = 0.5  #: least share of a new wheel's diameter that belongs to the same wheel
BURN_WIDTH = 0.05  #: width of the step in temperature rise at which burn is seen, as a share of the tempering rise
UNSEEN = 0.1  #: share of burnt parts that pass as good if nobody looks for burn


class GaugedParts(NamedTuple):
    """Measurements of parts, a value for each row, NaN if not measured.

    Parts count from 1 in the order of grinding; size (stock left) and Ra in um, the wheel's diameter after the part in
    mm, burn 1 or 0; remarks are sentences about the file.
    """

    part: Numbers
    size: Floats
    Ra: Floats
    burn: Floats
    diameter: Floats
    remarks: tuple[str, ...]


def read_gauge(path: Path, map_: Map) -> GaugedParts:
    """Return the measurements of parts in a file; a `CalibrationError` says why it cannot be used."""
    sheet = read_sheet(path)
    columns = find_columns(sheet, "gauge", map_, ("size", "Ra", "burn", "diameter"))
    empty = np.full(len(sheet.rows), np.nan)
    size = _size(sheet, columns["size"], map_) if "size" in columns else empty
    Ra = sheet.quantity(columns["Ra"], MICROMETRES, above=0.0) if "Ra" in columns else empty
    burn = sheet.flags(columns["burn"]) if "burn" in columns else empty
    diameter = sheet.quantity(columns["diameter"], MILLIMETRES, above=0.0) if "diameter" in columns else empty
    if np.isfinite(diameter).sum() == 1:
        sheet.remarks.append("one diameter of the wheel alone tells nothing: of diameters their differences count")
    return GaugedParts(_parts(sheet, columns.get("part")), size, Ra, burn, diameter, tuple(sheet.remarks))


def _parts(sheet: Sheet, column: int | None) -> Numbers:
    """Return part numbers from 1 on: from the column if its numbers rise, else in the order of the rows."""
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


def _size(sheet: Sheet, column: int, map_: Map) -> Floats:
    """Return the stock left, um: a deviation unchanged, a size minus the nominal size."""
    values, unit = sheet.numbers(column), map_.value("gauge", "size_unit")
    if not (unit or sheet.headings[column].unit):
        largest = np.nanmax(np.abs(values), initial=0.0)
        if 0.2 < largest < 500.0 and np.all(np.nan_to_num(values * 10.0) % 1.0 == 0.0):
            unit = "um"
        sheet.remarks.append(f"the size has no unit; by its numbers it is taken to be in {unit or 'mm'}")
    mm, nominal = values * sheet.factor(column, MILLIMETRES, unit), map_.number("gauge", "nominal_size")
    if nominal is not None:
        return 1e3 * (mm - nominal)
    if np.isfinite(mm).any() and np.nanmedian(np.abs(mm)) > MOST_DEVIATION:
        raise CalibrationError(
            f"{shown(sheet.path)}: the sizes, such as {np.nanmedian(mm):g} mm, are no deviations; say the nominal one "
            "with a map: [gauge] nominal_size = ..."
        )
    return 1e3 * mm


class Gauged(NamedTuple):
    """Gauged values in sequence: value, error and kind as in `solver.Data`, and the part from 1.

    `origin` is the part whose wheel diameter is subtracted from the value; 0 for other kinds.
    """

    value: Floats
    error: Floats
    kind: NDArray[np.str_]
    part: Numbers
    origin: Numbers


def measured_of(gauge: GaugedParts | None, parts: int, job: Job) -> Gauged:
    """Return the gauged values of the parts in the log."""
    rows: list[tuple[float, float, str, int, int]] = []
    if gauge is not None:
        errors = {"size": SIZE_ERROR, "Ra": math.hypot(job.lots.roughness, ROUGHNESS_ERROR), YES_OR_NO: 0.0}
        inside = gauge.part <= parts
        for kind, error in errors.items():
            values = getattr(gauge, kind)
            rows += [(values[k], error, kind, gauge.part[k], 0) for k in np.flatnonzero(np.isfinite(values) & inside)]
        if not np.isfinite(gauge.burn).any():
            looked_at = (np.isfinite(gauge.size) | np.isfinite(gauge.Ra)) & inside
            rows += [(0.0, UNSEEN, YES_OR_NO, gauge.part[k], 0) for k in np.flatnonzero(looked_at)]
        wheels = np.flatnonzero(np.isfinite(gauge.diameter) & inside)
        for k in wheels[1:]:
            less = gauge.diameter[k] - gauge.diameter[wheels[0]]
            rows.append((less, DIAMETER_ERROR * math.sqrt(2.0), "diameter", gauge.part[k], gauge.part[wheels[0]]))
    types: tuple[Any, ...] = (np.float64, np.float64, "U10", np.int64, np.int64)
    return Gauged(*(np.array([row[k] for row in rows], each) for k, each in enumerate(types)))


def check_gauges(gauge: GaugedParts, job: Job) -> None:
    """Refuse measurements that are impossible for a job; a `CalibrationError` names the part."""
    most = max(part.stock for part in (job.part, *(each.part for each in job.stations)))
    stock, wheel = 1e3 * most, job.setup.wheel.diameter
    for part, size, diameter in zip(gauge.part.tolist(), gauge.size.tolist(), gauge.diameter.tolist(), strict=True):
        if abs(size) > stock:
            raise CalibrationError(
                f"the size of part {part} is {size:g} um off, more than the stock of {stock:g} um that the job has; "
                "check the unit of the sizes and the nominal one"
            )
        if diameter < LEAST_WHEEL * wheel or diameter > wheel / LEAST_WHEEL:
            raise CalibrationError(
                f"the wheel is {diameter:g} mm after part {part}, and {wheel:g} mm new in the job; check the unit of "
                "its diameter, mm if none is said"
            )


def gauges_of(record: GrindingRecord, job: Job, extra: Gauged) -> Floats:
    """Return the simulated gauge readings for the gauged values of a run."""
    parts, at = record.parts, extra.part - 1
    if not extra.part.size:
        return np.empty(0)
    last = np.searchsorted(record.strokes["part"], np.arange(1, len(parts) + 1), side="right") - 1
    diameter = record.strokes["ds"][last]
    limit = job.limits.rise
    values: Mapping[str, Floats] = {
        "size": parts["size_error"][at],
        "Ra": parts["Ra"][at],
        YES_OR_NO: (parts["rise"][at] - limit) / (BURN_WIDTH * limit),
        "diameter": diameter[at] - diameter[np.maximum(extra.origin - 1, 0)],
    }
    return np.select([extra.kind == kind for kind in values], list(values.values()))
