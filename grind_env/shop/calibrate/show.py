"""A calibration on the screen, and as plain data."""

import itertools
import math
from typing import Any

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Column, Table

from grind_env.shop.calibrate.result import Calibration, Estimate
from grind_env.shop.calibrate.solver import ABSOLUTE

HEADINGS = ("constant", "was", "is", "90 %", "unit", "spread left %")


def told_rows(found: Calibration) -> list[tuple[str, ...]]:
    """A row below `HEADINGS` for each constant that the measurements tell."""
    return [_row(each) for each in found.estimates if each.told]


def said_sentences(found: Calibration) -> list[str]:
    """What is to be said below the table."""
    next_cut = [] if found.next_cut is None else [found.next_cut]
    return [*meter_sentences(found), *kept_sentences(found), *error_sentences(found), *next_cut]


def show(found: Calibration, console: Console) -> None:
    """Print what was found, how well it predicts, and what was made of the files."""
    table = Table(
        *(
            Column(each.replace("spread ", "spread\n"), justify="right" if number else "left", no_wrap=True)
            for number, each in enumerate(HEADINGS)
        ),
        box=SIMPLE,
        pad_edge=False,
        padding=(0, 1, 0, 0),
        title=f"Calibrated from {found.source}",
    )
    told = [each for each in found.estimates if each.told]
    for entry, constants in itertools.groupby(told, lambda each: f"{each.parameter.kind} {each.parameter.entry}"):
        table.add_row(entry, style="dim")
        for each in constants:
            table.add_row(f" {each.parameter.key}", *_row(each)[1:])
    console.print(found.verdict.headline, style="bold")
    if table.row_count:
        console.print(table)
    for sentence in said_sentences(found):
        console.print(sentence)
    for remark in found.remarks:
        console.print(f"- {remark}", style="dim")


def meter_sentences(found: Calibration) -> list[str]:
    """What the meters show: idle power, and scales that are uncertain."""
    idle = found.idle
    said = [] if idle is None else [f"Idle power {idle.mean:.0f} W ({idle.low:.0f} to {idle.high:.0f} W)."]
    return said + [
        f"Scale of the meter of {kind}: {value:.3f} ({low:.3f} to {high:.3f})."
        for kind, (value, low, high) in found.scales.items()
    ]


def kept_sentences(found: Calibration) -> list[str]:
    """Which constants are as they were."""
    names = ", ".join(found.not_told)
    return [f"Kept as they were, because the measurements do not tell them: {names}."] if names else []


def error_sentences(found: Calibration) -> list[str]:
    """How well the measurements are predicted, then those that took no part."""
    held_out, whole = found.judged.held_out or {}, "part" if found.program else "setting"
    said = []
    for kind, (count, before, after) in found.judged.errors.items():
        without = (
            f", {_error(kind, held_out[kind][2])} on {whole}s that are left out in turn" if kind in held_out else ""
        )
        said.append(
            f"Error of {count} measurement{'s' if count > 1 else ''} of {kind}: {_error(kind, after)}{without}; with "
            f"the catalogue {_error(kind, before)}."
        )
    return said


def as_data(found: Calibration) -> dict[str, Any]:
    """The same for `--json`."""
    return {
        "verdict": {
            "level": found.verdict.level,
            "headline": found.verdict.headline,
            "uses": list(found.verdict.uses),
            "worse": list(found.judged.worse),
            "kept": list(found.judged.kept),
        },
        "source": found.source,
        "program": found.program,
        "constants": [
            {
                "name": each.parameter.name,
                "entry": each.parameter.entry,
                "unit": each.parameter.unit,
                "was": each.parameter.prior,
                "value": each.value,
                "low": each.low,
                "high": each.high,
                "told": each.told,
            }
            for each in found.estimates
        ],
        "scales": {
            kind: {"value": value, "low": low, "high": high} for kind, (value, low, high) in found.scales.items()
        },
        "idle": None
        if found.idle is None
        else {"mean": found.idle.mean, "low": found.idle.low, "high": found.idle.high},
        "errors": _errors(found.judged.errors),
        "held_out": None if found.judged.held_out is None else {"errors": _errors(found.judged.held_out)},
        "width": found.fit.width,
        "residual": found.residual,
        "drift": found.drift,
        "meter_scale": found.meter_scale,
        "next_cut": found.next_cut,
        "correlation": None if math.isnan(found.quality) else found.quality,
        "by_stroke": found.by_stroke,
        "remarks": list(found.remarks),
    }


def _row(each: Estimate) -> tuple[str, ...]:
    parameter = each.parameter
    return (
        f"{parameter.entry} {parameter.key}",
        f"{parameter.prior:.4g}",
        f"{each.value:.4g}",
        f"{each.low:.3g} to {each.high:.3g}",
        parameter.unit,
        f"{100.0 * each.share:.0f}",
    )


def _error(kind: str, error: float) -> str:
    units = {"size": "um", "diameter": "mm"}
    return f"{error:.3g} {units[kind]}" if kind in ABSOLUTE else f"{100.0 * error:.1f} %"


def _errors(errors: Any) -> dict[str, dict[str, float]]:
    return {
        kind: {"count": count, "catalogue": before, "fitted": after} for kind, (count, before, after) in errors.items()
    }
