"""Read an exported log of spindle power into times and watts."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats, Numbers
from grind_env.files import shown
from grind_env.message_text import quoted
from grind_env.process.entries import Machine
from grind_env.shop.calibrate.column_names import Map, find_columns
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.measurements.clock_times import DAY
from grind_env.shop.measurements.measured_sheet import MOST_TIME, WATTS, Sheet, plain, read_sheet

LEAST_ROWS = 30
SECONDS = {"s": 1.0, "sec": 1.0, "sek": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "days": DAY}
#: range of times since 1970 in each unit, from the year 1985 to 2128
SINCE_1970 = {unit: (5e8 / SECONDS[unit], 5e9 / SECONDS[unit]) for unit in ("ms", "us", "ns")}
#: last day number of a spreadsheet (year 2173); step between rows, days, below which a time without unit is in days
LAST_DAY, STEP_OF_DAYS = 1e5, 2e-4
OVERLAP = 3  #: number of rows after a clock was set back that earlier rows reach beyond
SMALL = 0.02  #: share of the machine's power limit that a power in W exceeds somewhere; a lower power is in kW
GAP, LEAST_GAP = 8.0, 0.5  #: multiple of the usual step, and time, s, that a step must exceed to be a gap
#: ratio of the number of different times to the number of rows, below which a clock is coarser than the log
COARSE = 0.7
#: logarithmic standard deviation of a meter's scale: W, % of a stated rating, A with known volts, % of a guess, A
EXACT, SHARE, AMPERES, GUESSED, UNKNOWN = 0.02, 0.05, 0.08, 0.3, 1.0


@dataclass(frozen=True, slots=True)
class Log:
    """Log of spindle power."""

    time: Floats  #: time of each row, s, rising, from any origin
    power: Floats  #: power of the spindle with its idling, W; in the unit of the meter if its scale is unknown
    dressing: NDArray[np.bool_]  #: whether the wheel was being dressed
    scale_spread: float  #: logarithmic standard deviation of the meter's factor; 0 if a map states the factor
    known_scale: bool  #: whether `power` is in W
    unit: str  #: unit of the power in the log
    sure_of_time: bool  #: whether the unit of time is known, so that it need not be inferred
    remarks: tuple[str, ...]  #: sentences on how the file was read
    full: float | None = None  #: power at which a meter in per cent shows 100, W; None for other meters
    scale: float = 1.0  #: factor of the meter if a map states it, else 1; `power` is divided by it
    lag: float = 0.0  #: time constant of the meter, s; 0 if unknown

    @property
    def interval(self) -> float:
        """Usual time between two rows, s."""
        return float(np.median(np.diff(self.time)))


def read_log(path: Path, machine: Machine, map_: Map) -> Log:
    """Return a log; the power limit of the machine is the rating of its meter if the map states none.

    A `CalibrationError` says why the log cannot be used.
    """
    sheet = read_sheet(path)
    columns, remarks = find_columns(sheet, "log", map_, ("time",), ("power",)), sheet.remarks
    raw, (time, sure) = sheet.numbers(columns["power"]), _times(sheet, columns["time"], map_)
    dressing = sheet.flags(columns["dress"]) if "dress" in columns else np.zeros(time.size)
    kept = np.isfinite(time) & np.isfinite(raw)
    if not kept.all():
        remarks.append(f"{int((~kept).sum())} rows without time or power were left out")
    _refuse_constant(sheet, columns["time"], "time", time[kept], least=2)
    time, raw, dressed = _in_order(sheet, np.flatnonzero(kept), time, raw, dressing == 1.0)
    if time.size < LEAST_ROWS:
        raise CalibrationError(f"{shown(path)} has {time.size} rows of time and power; {LEAST_ROWS} are needed")
    _refuse_constant(sheet, columns["power"], "power", raw, least=3)
    steps = np.diff(time)
    gaps = steps[steps > max(GAP * float(np.median(steps)), LEAST_GAP)]
    if sure and gaps.size:
        remarks.append(f"{gaps.size} gap{'s' if gaps.size > 1 else ''} in the log, the longest of {gaps.max():.1f} s")
    factor, unit, spread, known = _meter(sheet, columns["power"], raw, machine, map_)
    scale = map_.number("log", "scale")
    if scale is not None and not known:
        raise CalibrationError(
            f"{map_.file}: log.scale is {scale:g}, but the power is in {unit}, of which volts and power_factor are not "
            "known; say them, too, or leave the scale out"
        )
    if scale is not None:
        spread = 0.0
        remarks.append(f"the scale of the meter is {scale:g}, as the map says")
    full = (map_.number("log", "rated_power") or machine.power_limit) / (scale or 1.0) if unit == "%" else None
    power = factor * raw / (scale or 1.0)
    return Log(time, power, dressed, spread, known, unit, sure, tuple(remarks), full, scale or 1.0)


def averaged(log: Log, time: Floats, step: float) -> Log:
    """Return a log with times in s; rows closer together than a step are replaced by their mean."""
    _, where, count = np.unique(((time - time[0]) // step), return_inverse=True, return_counts=True)
    time, power, dressing = (np.bincount(where, values) / count for values in (time, log.power, log.dressing))
    return replace(log, time=time, power=power, dressing=dressing > 0.0)


def _refuse_constant(sheet: Sheet, column: int, name: str, values: Floats, least: int) -> None:
    """Refuse a column with fewer different values than a log needs."""
    few = np.unique(values)
    if 0 < few.size < least:
        found = (
            f"is {few[0]:g} or {few[1]:g} and nothing else" if few.size > 1 else f"does not change (it is {few[0]:g})"
        )
        where = f"{shown(sheet.path)}: the {name}, column {quoted(sheet.headings[column].name)}"
        remedy = f"log the {name} of every row, or say which column it is with a map: [log] {name} = ..."
        raise CalibrationError(f"{where}, {found}; {remedy}")


def _times(sheet: Sheet, column: int, map_: Map) -> tuple[Floats, bool]:
    """Return times in s, and whether their unit is known: stated, or told by their size."""
    unit = map_.value("log", "time_unit")
    if unit is not None and unit not in (*SECONDS, "clock"):
        raise CalibrationError(
            f"{map_.file}: log.time_unit is {quoted(unit)}, but must be one of clock, {', '.join(SECONDS)}"
        )
    if unit == "clock" or (unit is None and sheet.is_clock(column)):
        return sheet.clock(column), True
    times, unit = sheet.numbers(column, beyond=MOST_TIME), plain(str(unit or sheet.headings[column].unit))
    known = times[np.isfinite(times)]
    if unit not in SECONDS and known.size > 1:
        within = [name for name, (low, high) in SINCE_1970.items() if low <= known.min() and known.max() < high]
        if within:
            unit = within[0]
        elif known.min() >= 0.0 and known.max() < LAST_DAY and np.median(np.abs(np.diff(known))) < STEP_OF_DAYS:
            unit = "days"
        if unit in SECONDS:
            sheet.remarks.append(f"the time has no unit; by its size it is taken to be in {unit}")
    return times * SECONDS.get(unit, 1.0), unit in SECONDS


def _in_order(
    sheet: Sheet, rows: Numbers, time: Floats, raw: Floats, dressing: NDArray[np.bool_]
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return rows in the order of their times, without a second row of the same time."""
    steps, remarks = np.diff(time[rows]), sheet.remarks
    rows = rows[::-1] if (steps < 0.0).sum() > (steps > 0.0).sum() else rows  # the newest row may come first
    time, raw, dressing, lines = time[rows], raw[rows], dressing[rows], np.array(sheet.lines)[rows]
    step = float(np.median(np.diff(np.unique(time)))) if time.size > 1 else 0.0
    back = [row for row in (np.flatnonzero(np.diff(time) < 0.0) + 1).tolist() if _is_set_back(time, row, step)]
    if len(back) > 1:
        where = f"{shown(sheet.path)}: the clock was set back {len(back)} times, first in row {lines[back[0]]}"
        raise CalibrationError(f"{where}; export the rows between as one log")
    for row in back:
        by = time[:row].max() + step - time[row]
        time = np.concatenate([time[:row], time[row:] + by])
        remarks.append(f"the clock was set back by {by:.6g} s in row {lines[row]}; the rows are taken to go on there")
    late = int((np.diff(time) < 0.0).sum())
    if late:
        remarks.append(f"{late} rows came out of order and were put in theirs")
    order = np.argsort(time, kind="stable")
    time, raw, dressing = time[order], raw[order], dressing[order]
    stamps, first, counts = np.unique(time, return_index=True, return_counts=True)
    if stamps.size < COARSE * time.size and np.median(counts) >= 2:
        within = np.arange(time.size) - np.repeat(first, counts)
        remarks.append(f"the clock has steps of {step:g} s; {np.median(counts):g} rows in each were spread over it")
        return time + step * (within + 0.5) / np.repeat(np.maximum(counts, np.median(counts)), counts), raw, dressing
    if stamps.size < time.size:
        remarks.append(f"{time.size - stamps.size} rows with the time of another one were left out")
    return stamps, raw[first], dressing[first]


def _is_set_back(time: Floats, row: int, step: float) -> bool:
    """Return whether a clock was set back before a row, and the rows are not only in the wrong order."""
    before, after, some = time[:row], time[row:], OVERLAP * step
    if np.any(after[:OVERLAP] >= before.max() - some):
        return False
    taken = np.count_nonzero((before >= after[0]) & (before <= after[0] + some))
    return bool(taken >= OVERLAP - 1 or after.max() < before.min() - some)


def _meter(sheet: Sheet, column: int, raw: Floats, machine: Machine, map_: Map) -> tuple[float, str, float, bool]:
    """Return the factor from a power to W, its unit, the spread of the factor, and whether the factor is known."""
    unit = plain(str(map_.value("log", "power_unit") or sheet.headings[column].unit or ""))
    name, remarks = plain(sheet.headings[column].name), sheet.remarks
    if not unit and any(word in name for word in ("strom", "current", "courant", "corr", "prad")):
        unit = "a"
    if not unit and any(word in name for word in ("last", "load", "charge", "carga", "carico", "%")):
        unit = "%"
    needed = {"%": ("rated_power",), "a": ("volts", "power_factor")}.get(unit[:1], ())
    idle = [key for key in ("rated_power", "volts", "power_factor") if key not in needed and map_.value("log", key)]
    if idle:
        stated = sheet.headings[column].unit or unit or "W"
        remarks.append(f"{', '.join(idle)} of the map had no effect on a power in {stated}")
    if not unit:
        unit = "kw" if float(np.quantile(raw, 0.99)) < SMALL * machine.power_limit else "w"
        remarks.append(f"the power has no unit; by its size it is taken to be in {unit.replace('w', 'W')}")
    if unit in WATTS:
        return WATTS[unit], unit, EXACT, True
    if unit == "%":
        rated = map_.number("log", "rated_power")
        if rated is None:
            remarks.append(f"100 % is taken for the machine's {machine.power_limit:g} W; a map says it by rated_power")
        return 0.01 * (rated or machine.power_limit), unit, SHARE if rated else GUESSED, True
    if unit in ("a", "amp", "ampere"):
        volts, factor = map_.number("log", "volts"), map_.number("log", "power_factor")
        if volts is not None and factor is not None:
            return math.sqrt(3.0) * volts * factor, "A", AMPERES, True
        remarks.append("the scale of the amperes is fitted, for no map says volts and power_factor of the motor")
        return 1.0, "A", UNKNOWN, False
    raise CalibrationError(
        f"{shown(sheet.path)}: the unit of the power, {quoted(unit)}, is none of W, kW, hp, % and A; say it with a "
        'map: [log] power_unit = "kW"'
    )
