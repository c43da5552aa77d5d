"""A log of the power of the spindle, as it was exported, as times and watts."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grind_env.errors import quoted
from grind_env.files import shown
from grind_env.process.entries import Machine
from grind_env.shop.calibrate.columns import Map, find_columns, names_of, not_used
from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.calibrate.sheet import LATEST, Floats, Sheet, plain, read_sheet

LEAST_ROWS = 30
SECONDS = {"s": 1.0, "sec": 1.0, "sek": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
"""Of units of time."""
WATTS = {"w": 1.0, "watt": 1.0, "kw": 1e3, "hp": 745.7, "ps": 735.5}
"""Of units of power."""
GAP, LEAST_GAP = 8.0, 0.5
"""Times the usual step, and s, from which on a step is a gap."""
COARSE = 0.7
"""Times in which more rows share one with another are those of a clock that is coarser than the log."""
EXACT, SHARE, AMPERES, GUESSED, UNKNOWN = 0.02, 0.05, 0.08, 0.3, 1.0
"""Logarithmic spread of the scale of a meter: in W, in % of a rating, of a motor with known volts, in % of a rating
that is
guessed, of a motor without volts."""


@dataclass(frozen=True, slots=True)
class Log:
    """What was logged.

    Attributes:
        time: of each row, s, rising; from any origin.
        power: of the spindle with its idling, W; if the scale of the meter is not known, in its unit.
        dressing: whether the wheel was being dressed.
        scale_spread: logarithmic spread of the factor of the meter; 0 where a map says it.
        lag: time constant of the meter, as far as it is known, s.
        scale: that factor where a map says it, else 1; `power` is without it.
        known_scale: whether `power` is in W.
        unit: of the power in the log.
        sure_of_time: whether the unit of time is stated, and not to be found out.
        remarks: what was made of the file, as sentences.
        full: power at which a meter in per cent shows 100, W; None of other meters.
    """

    time: Floats
    power: Floats
    dressing: NDArray[np.bool_]
    scale_spread: float
    known_scale: bool
    unit: str
    sure_of_time: bool
    remarks: tuple[str, ...]
    full: float | None = None
    scale: float = 1.0
    lag: float = 0.0

    @property
    def interval(self) -> float:
        """Usual time between two rows, s."""
        return float(np.median(np.diff(self.time)))


def read_log(path: Path, machine: Machine, said: Map) -> Log:
    """Read a log.

    Args:
        path: its file.
        machine: whose power limit stands for the rating, if none is said.
        said: what its columns are.

    Raises:
        CalibrationError: it has no time or power, too few rows, or a time or a power that never changes.
    """
    sheet = read_sheet(path)
    columns = find_columns(sheet, "log", said)
    for name in ("time", "power"):
        if name not in columns:
            raise CalibrationError(
                f"{shown(path)} has no column of the {name} among {names_of(sheet)}; say which it is with a map: "
                f"[log] {name} = ..."
            )
    remarks = [
        f"{name} is column {quoted(sheet.headings[columns[name]].name)}"
        for name in ("time", "power", "dress")
        if name in columns
    ] + not_used(sheet, columns.values())
    time, sure = _times(sheet, columns["time"], said)
    raw = sheet.numbers(columns["power"])
    dressing = np.zeros(time.size, np.bool_) if "dress" not in columns else _bits(sheet, columns["dress"])
    if not np.isfinite(raw).any():
        raise CalibrationError(
            f"{shown(path)}: column {quoted(sheet.headings[columns['power']].name)} holds no numbers; say which column "
            "is the power with a map: [log] power = ..."
        )
    kept = np.isfinite(time) & np.isfinite(raw)
    dropped = sheet.skipped + int((~kept).sum())
    if dropped:
        remarks.append(f"{dropped} rows without time or power were left out")
    if kept.any() and not np.ptp(time[kept]) > 0.0:
        raise CalibrationError(
            f"{shown(path)}: the time, column {quoted(sheet.headings[columns['time']].name)}, does not change; export "
            "the time of every row, or say which column it is with a map: [log] time = ..."
        )
    time, raw, dressing = _in_order(time[kept], raw[kept], dressing[kept], remarks)
    if time.size < LEAST_ROWS:
        raise CalibrationError(f"{shown(path)} has {time.size} rows of time and power; {LEAST_ROWS} are needed")
    low, high = raw.min(), raw.max()
    steady = high - low <= 1e-6 * max(abs(low), abs(high))
    if steady or np.unique(raw).size < 3:
        found = f"does not change (it is {np.median(raw):g})" if steady else f"is {low:g} or {high:g} and nothing else"
        raise CalibrationError(
            f"{shown(path)}: the power, column {quoted(sheet.headings[columns['power']].name)}, {found}; log the power "
            "of the spindle, or say which column it is with a map"
        )
    if sure:
        remarks += _gaps(time)
    power, unit, spread, known = _watts(sheet, columns["power"], raw, machine, said, remarks)
    scale = said.number("log", "scale")
    if scale is not None and not known:
        raise CalibrationError(
            f"{said.file}: log.scale is {scale:g}, but the power is in {unit}, of which volts and power_factor are not "
            "known; say them, too, or leave the scale out"
        )
    if scale is not None:
        power, spread = power / scale, 0.0
        remarks.append(f"the scale of the meter is {scale:g}, as the map says")
    rated = said.number("log", "rated_power") or machine.power_limit
    full = rated / (scale or 1.0) if unit == "%" else None
    return Log(time, power, dressing, spread, known, unit, sure, tuple(remarks), full, scale or 1.0)


def _times(sheet: Sheet, column: int, said: Map) -> tuple[Floats, bool]:
    """Times in s, and whether their unit is stated."""
    unit = said.value("log", "time_unit")
    if unit is not None and unit not in (*SECONDS, "clock"):
        raise CalibrationError(
            f"{said.file}: log.time_unit is {quoted(unit)}, but must be one of clock, {', '.join(SECONDS)}"
        )
    if unit == "clock" or (unit is None and sheet.is_clock(column)):
        return sheet.clock(column), True
    unit = plain(str(unit or sheet.headings[column].unit))
    return sheet.numbers(column, LATEST) * SECONDS.get(unit, 1.0), unit in SECONDS


def _gaps(time: Floats) -> list[str]:
    """A sentence about the gaps in times in s, if there are any."""
    steps = np.diff(time)
    gaps = steps[steps > max(GAP * float(np.median(steps)), LEAST_GAP)]
    if not gaps.size:
        return []
    return [f"{gaps.size} gap{'s' if gaps.size > 1 else ''} in the log, the longest of {gaps.max():.1f} s"]


def _bits(sheet: Sheet, column: int) -> NDArray[np.bool_]:
    """A column of a bit as truths."""
    yes = ("1", "true", "on", "ein", "ja", "yes", "x", "si", "oui", "aan", "1.0", "1,0")
    return np.array([text.lower() in yes for text in sheet.texts(column)], np.bool_)


def _in_order(
    time: Floats, raw: Floats, dressing: NDArray[np.bool_], remarks: list[str]
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Rows in the order of their times, none of which is there twice."""
    late = int((np.diff(time) < 0.0).sum())
    if late:
        remarks.append(f"{late} rows came out of order and were put in theirs")
    order = np.argsort(time, kind="stable")
    time, raw, dressing = time[order], raw[order], dressing[order]
    stamps, first, counts = np.unique(time, return_index=True, return_counts=True)
    if stamps.size < COARSE * time.size and np.median(counts) >= 2:
        step = float(np.median(np.diff(stamps)))
        within = np.arange(time.size) - np.repeat(first, counts)
        remarks.append(f"the clock has steps of {step:g} s; {np.median(counts):g} rows in each were spread over it")
        return time + step * (within + 0.5) / np.repeat(np.maximum(counts, np.median(counts)), counts), raw, dressing
    if stamps.size < time.size:
        remarks.append(f"{time.size - stamps.size} rows with the time of another one were left out")
    return stamps, raw[first], dressing[first]


def _watts(
    sheet: Sheet, column: int, raw: Floats, machine: Machine, said: Map, remarks: list[str]
) -> tuple[Floats, str, float, bool]:
    """The power in W as far as its scale is known, its unit, the spread of that scale, and whether it is known."""
    unit = plain(str(said.value("log", "power_unit") or sheet.headings[column].unit or ""))
    name = plain(sheet.headings[column].name)
    if not unit and any(word in name for word in ("strom", "current", "courant", "corr", "prad")):
        unit = "a"
    if not unit and any(word in name for word in ("last", "load", "charge", "carga", "carico", "%")):
        unit = "%"
    needed = {"%": ("rated_power",), "a": ("volts", "power_factor")}.get(unit[:1], ())
    idle = [key for key in ("rated_power", "volts", "power_factor") if key not in needed and said.value("log", key)]
    if idle:
        stated = sheet.headings[column].unit or unit or "W"
        remarks.append(f"{', '.join(idle)} of the map had no effect on a power in {stated}")
    if unit in WATTS:
        return WATTS[unit] * raw, unit, EXACT, True
    if unit == "%":
        rated = said.number("log", "rated_power")
        if rated is None:
            remarks.append(
                f"100 % is taken for the power limit of the machine, {machine.power_limit:g} W; a map says "
                "it by rated_power"
            )
        return 0.01 * (rated or machine.power_limit) * raw, unit, SHARE if rated else GUESSED, True
    if unit in ("a", "amp", "ampere"):
        volts, factor = said.number("log", "volts"), said.number("log", "power_factor")
        if volts is not None and factor is not None:
            return np.sqrt(3.0) * volts * factor * raw, "A", AMPERES, True
        remarks.append(
            "volts and power_factor of the motor are not said, so that the scale of its amperes is fitted; those of an "
            "asynchronous motor hardly change near idle, and tell little there"
        )
        return raw, "A", UNKNOWN, False
    if unit:
        raise CalibrationError(
            f"{shown(sheet.path)}: the unit of the power, {quoted(unit)}, is none of W, kW, hp, % and A; say it with a "
            'map: [log] power_unit = "kW"'
        )
    high = float(np.quantile(raw, 0.99))
    if high < 0.02 * machine.power_limit:
        remarks.append("the power has no unit; by its size it is taken to be in kW")
        return 1e3 * raw, "kW", EXACT, True
    remarks.append("the power has no unit; by its size it is taken to be in W")
    return raw, "W", EXACT, True
