"""Fit the process model to a table of settings with readings, without a log.

Each row is a freshly dressed wheel that grinds with the speeds and depths of the row. Columns have the names below, or
the table `[table]` of a map assigns them, as in `table_speed = "vw"`.
"""

import math
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grind_env.array_types import Floats
from grind_env.machine.job import Job
from grind_env.machine.job.job_entries import entries_of, with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.plants.plant_names import MODEL
from grind_env.process.catalogue import Catalogue
from grind_env.shop.calibrate.column_names import find_columns, read_map
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.fit import Fit, FitProblem, fit_and_judge, residual_and_drift
from grind_env.shop.calibrate.fitted_constants import chosen_parameters
from grind_env.shop.calibrate.least_squares import Changes, Data
from grind_env.shop.calibrate.log_calibration import override_remarks
from grind_env.shop.calibrate.result import Calibration
from grind_env.shop.measurements.measured_sheet import MICROMETRES, MILLIMETRES, WATTS, read_sheet
from grind_env.validation.rig import SHARP, Rig, SetUp

#: settings of a row; `depth` is the depth of the dress
SETTINGS = ("wheel_speed", "table_speed", "downfeed", "width", "length", "lead", "depth", "volume")
RESPONSES = ("power", "Ft", "Fn", "Ra", "wear", "G")  #: measured quantities
#: limits of both: every setting must be readable, and measured values are above 0
SET, MEASURED = {"bad_share": 0.0}, {"above": 0.0}
#: relative errors of a response that is measured once with care
ERRORS = {"power": 0.05, "Ft": 0.05, "Fn": 0.05, "Ra": 0.1, "wear": 0.15, "G": 0.2}
FORCES = ("Ft", "Fn")
#: further constants that settings determine, but a log does not
BESIDE = ("material.g_ratio_exponent", "wheel.roughness_rate", "wheel.initial_wear")
#: value of a setting (m/s, mm/s or mm) up to which it counts as missing: with it nothing would be ground
LEAST_SETTING = 1e-9
#: greatest number of strokes of a setting, far more than a wheel lasts; a fit grinds a setting some hundred times
MOST_STROKES = 100_000


class _Row(NamedTuple):
    """Row of the table that has a response."""

    setting: tuple[tuple[str, float], ...]
    volume: float  #: ground volume, mm3/mm; NaN for a sharp wheel


def calibrate_table(
    table: Path,
    job: Path,
    *,
    map_file: Path | None = None,
    names: Collection[str] | None = None,
    report_stage: Callable[[str], None] = lambda stage: None,
) -> Calibration:
    """Fit the process model to a table of settings; arguments as in `calibrate`.

    Dimensions and wheel speed that the table does not have are those of the job.
    """
    map_ = read_map(map_file)
    settings = load_job(job, plant=MODEL)
    parameters = chosen_parameters(settings, names, BESIDE)
    sheet = read_sheet(table)
    columns = find_columns(sheet, "table", map_, RESPONSES, SETTINGS)
    values = {
        name: sheet.quantity(column, _units(name, settings.part.width), **(MEASURED if name in RESPONSES else SET))
        for name, column in columns.items()
    }
    rows = [_row(settings, values, k) for k in range(len(sheet.rows))]
    distinct = list(dict.fromkeys(rows))  # a setting may be measured many times
    responses = [name for name in RESPONSES if name in columns]
    measured = [(k, name) for name in responses for k in np.flatnonzero(np.isfinite(values[name])).tolist()]
    kind = np.array([name for _, name in measured], str)
    value = np.array([values[name][k] for k, name in measured])
    error = np.array([ERRORS[name] for _, name in measured])
    setting = np.array([distinct.index(rows[k]) + 1 for k, _ in measured], np.int64)
    data = Data(value, np.where(kind == "power", error * value, error), kind, setting)

    def predict(changes: Changes) -> Floats:
        changed = with_entries(settings, changes)
        found = {row: _ground(changed, row) for row in distinct}
        return np.array([found[rows[k]][name] for k, name in measured])

    report_stage("fitting")
    fitted, judged = fit_and_judge(FitProblem(parameters, {}, data, predict, report_stage))
    return Calibration(
        source=table.name,
        program="",
        job=settings,
        data=data,
        fit=fitted,
        time=np.full(value.size, np.nan),
        judged=judged,
        residual=_residual(fitted, data),
        remarks=(*sheet.remarks, *override_remarks(job, fitted, idle=False)),
    )


def _residual(fitted: Fit, data: Data) -> float:
    """Return the logarithmic standard deviation of the forces of a setting around the model; 0 without forces."""
    if (data.kind == "power").any():
        return residual_and_drift(fitted, data, np.where(data.kind == "power", data.part, 0))[0]
    forces = fitted.used & np.isin(data.kind, FORCES)
    off = np.log(data.value[forces] / fitted.predicted[forces])
    return float(np.sqrt(np.mean(np.square(off)))) if off.size else 0.0


def _units(name: str, width: float) -> Mapping[str, float]:
    """Return the legal units of a column with factors to m/s, mm/s, W, um, N/mm and mm3/mm; the default comes first."""
    return {
        "wheel_speed": {"m/s": 1.0, "m/min": 1.0 / 60.0},
        "table_speed": {"mm/min": 1.0 / 60.0, "m/min": 1000.0 / 60.0, "mm/s": 1.0, "m/s": 1000.0},
        "power": WATTS,
        "Ft": {"n/mm": 1.0, "n": 1.0 / width},
        "Fn": {"n/mm": 1.0, "n": 1.0 / width},
        "Ra": MICROMETRES,
        "wear": MICROMETRES,
        "volume": {"mm3/mm": 1.0, "mm2": 1.0, "mm3": 1.0 / width},
        "G": {"-": 1.0, "mm3/mm3": 1.0},
    }.get(name, MILLIMETRES)


def _row(job: Job, values: Mapping[str, Floats], k: int) -> _Row:
    usual = {
        "width": min(job.part.width, job.setup.wheel.width),
        "length": job.part.length,
        "wheel_speed": job.setup.wheel_speed,
        "downfeed": SetUp().downfeed,
    }
    given = {name: float(values[name][k]) for name in SETTINGS if name in values and name != "volume"}
    for name, value in given.items():
        if not value > LEAST_SETTING:
            raise CalibrationError(f"setting {k + 1} has no {name}; every row needs all of its settings, above 0")
    setting = {**usual, **given}
    volume = float(values["volume"][k]) if "volume" in values else math.nan
    a_stroke = setting["downfeed"] * setting["length"]
    if volume > MOST_STROKES * a_stroke:
        raise CalibrationError(
            f"setting {k + 1} grinds {volume:.6g} mm3 per mm of width, {a_stroke:.3g} in a stroke: more than"
            f" {MOST_STROKES:,} strokes; check volume, downfeed and length, and their units"
        )
    return _Row(tuple(setting.items()), volume)


def _ground(job: Job, row: _Row) -> Mapping[str, float]:
    names = {kind: "default" if kind == "machine" else entry.name for kind, entry in entries_of(job).items()}
    only: dict[str, Any] = {f"{kind}s": {names[kind]: entry} for kind, entry in entries_of(job).items()}
    del names["machine"]  # the rig takes the default one
    grinder = Rig(Catalogue(**only)).fresh(
        **names,
        **dict(row.setting),
        constant_surface_speed=job.setup.constant_surface_speed,
        diameter=job.wheel.diameter or job.setup.wheel.diameter,
        diamond_flat=job.wheel.diamond_flat,
    )
    done = grinder.grind(SHARP) if math.isnan(row.volume) else grinder.grind_volume(row.volume)
    return {
        "power": done.power,
        "Ft": done.Ft,
        "Fn": done.Fn,
        "Ra": done.Ra,
        "wear": 1000.0 * grinder.wheel.W,
        "G": grinder.g_ratio(),
    }
