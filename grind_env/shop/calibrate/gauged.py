"""What was gauged of the parts of a log, as measurements, and what gauges would show of a run."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Numbers
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord
from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.calibrate.gauge import GaugedParts
from grind_env.shop.calibrate.sheet import Floats
from grind_env.shop.calibrate.solver import YES_OR_NO

SIZE_ERROR, ROUGHNESS_ERROR, DIAMETER_ERROR = 2.0, 0.05, 0.02
"""Of touching off and gauging, um; of a roughness gauge, relative; of measuring a wheel, mm."""
LEAST_WHEEL = 0.5
"""Of the diameter of a new wheel, below which it is none of that wheel."""
BURN_WIDTH = 0.05
"""Of the step in temperature rise at which burn is seen, of the rise that tempers."""
UNSEEN = 0.1
"""Share of burnt parts that pass for good ones where nobody has looked for burn."""


@dataclass(frozen=True, slots=True)
class Gauged:
    """What was gauged, one value after the other: value, error and kind as of `solver.Data`, and the part from 1.

    `origin` is the part from whose wheel diameter the value is the difference; 0 of other kinds.
    """

    value: Floats
    error: Floats
    kind: NDArray[np.str_]
    part: Numbers
    origin: Numbers


def measured_of(gauge: GaugedParts | None, parts: int, job: Job) -> Gauged:
    """What was gauged of the parts that are in the log."""
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


def refuse_impossible(gauge: GaugedParts, job: Job) -> None:
    """Refuse what cannot have been measured of a job; a `CalibrationError` says of which part."""
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
    """What the gauges would show."""
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
