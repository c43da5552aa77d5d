"""A calibration as terminal output and as plain data."""

import math
from dataclasses import asdict
from typing import Any

from rich.console import Console

from grind_env.data_table import Column, Table, table_of
from grind_env.shop.calibrate.least_squares import ABSOLUTE
from grind_env.shop.calibrate.result import Calibration, grinding_power

#: columns of a `FittedConstant`
COLUMNS = (
    Column("constant", lambda each: f"{each.parameter.entry} {each.parameter.key}"),
    Column("was", "parameter.prior", ".4g", right=True),
    Column("is", "value", ".4g", right=True),
    Column("90 %", lambda each: f"{each.low:.3g} to {each.high:.3g}", right=True),
    Column("unit", "parameter.unit"),
    Column("spread\nleft", "share", ".0f", "%", right=True, factor=100.0),
)


def constants_table(found: Calibration) -> Table:
    """Return a table with a row for each constant that the measurements determine."""
    return table_of(COLUMNS, [each for each in found.estimates if each.determined], f"Calibrated from {found.source}")


def all_sentences(found: Calibration) -> list[str]:
    """Return the sentences below the table."""
    return [*meter_sentences(found), *kept_sentences(found), *error_sentences(found)]


def show(found: Calibration, console: Console) -> None:
    """Print the verdict, the constants, the prediction errors, and remarks on the files."""
    console.print(found.verdict.headline, style="bold")
    constants = constants_table(found)
    if constants.rows:
        constants.print(console)
    for sentence in all_sentences(found):
        console.print(sentence)
    for remark in found.remarks:
        console.print(f"- {remark}", style="dim")


def meter_sentences(found: Calibration) -> list[str]:
    """Return sentences on the meters: idle power, and uncertain scales."""
    idle = found.idle
    said = [] if idle is None else [f"Idle power {idle.mean:.0f} W ({idle.low:.0f} to {idle.high:.0f} W)."]
    if idle is not None and idle.written and idle.full is None:
        left = grinding_power(found.job, idle)
        total = f"power_limit is written as {left + idle.mean:.0f} W: {left:.0f} W for grinding and the idle power"
        said.append(f"{total}. If {left:.0f} W is the rating of the motor, write {left:.0f} into the file.")
    return said + [
        f"Scale of the {kind} meter: {value:.3f} ({low:.3f} to {high:.3f})."
        for kind, (value, low, high) in found.scales.items()
    ]


def kept_sentences(found: Calibration) -> list[str]:
    """Return sentences on unchanged constants."""
    names = ", ".join(found.undetermined)
    return [f"Unchanged, because the measurements do not determine them: {names}."] if names else []


def error_sentences(found: Calibration) -> list[str]:
    """Return a sentence on the prediction errors of each kind of measurement."""
    held_out, whole = found.judged.held_out or {}, "part" if found.program else "setting"
    said = []
    for kind, (count, before, after) in found.judged.errors.items():
        tested, old = held_out.get(kind, (count, before, after))[2], _error(kind, before)
        test = _error(kind, tested)
        without = f", {test} on left-out {whole}s" if kind in held_out else ""
        unclear = tested > before and test != old and kind not in found.judged.worse
        doubt = ", a difference within the scatter" if unclear else ""
        measured = f"{count} measurement{'s' if count > 1 else ''} of {kind}"
        said.append(f"Error of {measured}: {_error(kind, after)}{without}; with the catalogue {old}{doubt}.")
    return said


def as_data(found: Calibration) -> dict[str, Any]:
    """Return the calibration in JSON types, for `--json`."""
    judged, idle = found.judged, found.idle
    same = "source", "program", "residual", "drift", "meter_scale", "by_stroke"
    return {
        "verdict": asdict(found.verdict) | {"worse": judged.worse, "kept": judged.kept},
        **{name: getattr(found, name) for name in same},
        "constants": [
            {"name": each.parameter.name, "entry": each.parameter.entry, "unit": each.parameter.unit}
            | {"was": each.parameter.prior, "value": each.value, "low": each.low, "high": each.high}
            | {"told": each.determined}
            for each in found.estimates
        ],
        "scales": {kind: dict(zip(("value", "low", "high"), each, strict=True)) for kind, each in found.scales.items()},
        "idle": None if idle is None else {"mean": idle.mean, "low": idle.low, "high": idle.high},
        "errors": _errors(judged.errors),
        "held_out": None if judged.held_out is None else {"errors": _errors(judged.held_out)},
        "width": found.fit.width,
        "correlation": None if math.isnan(found.quality) else found.quality,
        "remarks": list(found.remarks),
    }


def _error(kind: str, error: float) -> str:
    units = {"size": "um", "diameter": "mm"}
    return f"{error:.3g} {units[kind]}" if kind in ABSOLUTE else f"{100.0 * error:.1f} %"


def _errors(errors: Any) -> dict[str, dict[str, float]]:
    return {
        kind: {"count": count, "catalogue": before, "fitted": after} for kind, (count, before, after) in errors.items()
    }
