"""Causes of exceeded limits: the block and stroke, the amount, and the word to change."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from grind_env.machine.record import GrindingRecord
from grind_env.render.curve_data import block_name

DEEP = 1e-6  #: mm; a depth that is short of the stock by less than this reaches it


def explain(cause: str, parts: Sequence[int], record: GrindingRecord) -> str:
    """Return where parts have exceeded a limit most, and what to do; empty if nothing more is known.

    Only parts with the same limits as the first one are considered. `cause` is a field of `Limits`.
    """
    limits = record.job.of_part(parts[0]).limits
    parts = [number for number in parts if record.job.of_part(number).limits == limits]
    rows = record.parts[np.isin(record.parts["part"], parts)]
    if cause == "power":
        unit = "% of the torque at which the spindle stalls"
        return _of_stroke(record, parts, "torque", rows["peak_torque"].max(), 1.0, 100.0, unit)
    if cause == "rise":
        return f"{_of_stroke(record, parts, 'T', rows['rise'].max(), limits.rise, 1.0, 'K')}, or dress before"
    if cause == "roughness":
        finer = "lower F, or add strokes at full depth" if _by_feeds(record, parts) else "lower E, or raise L"
        return f"{rows['Ra'].max():.2f} of {limits.roughness:.2f} µm; dress finer, {finer}"
    if cause == "size":
        worst = rows[np.argmax(np.abs(rows["worst_error"]))]
        return (
            f"{worst['worst_error']:.1f} of {limits.size:g} µm, in the mean {shares(worst)}; {_for_size(worst, record)}"
        )
    return ""


def shares(part: Any) -> str:
    """Return the shares of the mean size error of a part, a row of `record.PART_ROW`."""
    names = {"wheel wear": "wear", "growth": "growth", "deflection": "deflection", "rest": "rest"}
    split = ", ".join(f"{name} {round(float(part[f'size_{field}']), 1) + 0.0:.1f}" for name, field in names.items())
    return f"{part['size_error']:.1f} µm: {split}"


def _of_stroke(
    record: GrindingRecord, parts: Sequence[int], field: str, most: float, limit: float, scale: float, unit: str
) -> str:
    """Return the stroke of some parts at which a field is nearest to `most`, and how to lower it."""
    strokes = record.strokes[np.isin(record.strokes["part"], parts)]
    stroke = strokes[np.argmin(np.abs(strokes[field] - most))]
    line = int(stroke["line"])
    if stroke["groove"]:
        made, remedy = f" groove {stroke['groove']}", "take smaller steps or a lower F"
    elif line not in record.cycles:
        made, remedy = "", "go less deep or lower F"
    else:
        made, remedy = (
            f" stroke {stroke['number']}" if stroke["number"] else " a stroke after the cycle",
            "lower J or E",
        )
    return f"{block_name(record, line)}{made}: {scale * most:.0f} of {scale * limit:.0f} {unit}; {remedy}"


def _by_feeds(record: GrindingRecord, parts: Sequence[int]) -> bool:
    """Return whether all strokes of some parts are feed moves."""
    strokes = record.strokes[np.isin(record.strokes["part"], parts)]
    return not strokes["groove"].any() and not set(strokes["line"].tolist()) & record.cycles.keys()


def _for_size(part: Any, record: GrindingRecord) -> str:
    """Return the remedy for the largest share of the size error, or for the taper if larger."""
    job, strokes = record.job, record.strokes
    own = job.of_part(int(part["part"])).part
    lines = set(strokes["line"][strokes["part"] == part["part"]].tolist()) if job.stations else None
    cycles = (cycle for line, cycle in record.cycles.items() if lines is None or line in lines)
    depths = [own.surface - cycle.depth_target for cycle in cycles if cycle.plunges]
    late = "let every pick end before the wheel is back on the part, by a higher F or more overtravel"
    uneven = f"it differs by {part['taper']:.1f} µm across the width"
    remedies = {
        "taper": f"{uneven}: take the last cycle over all of it, or {late}",
        "size_wear": "gauge it with M01 before the last cycle",
        "size_growth": "let it cool before the last cycle, lower its E, or dress before",
        "size_deflection": (
            "add strokes at full depth, or end with less deep ones"
            if _by_feeds(record, [int(part["part"])])
            else "raise L, or end with finer picks J"
        ),
        "size_rest": late if max(depths, default=0.0) >= own.stock - DEEP else "program the depth of its stock",
    }
    return remedies[max(remedies, key=lambda field: abs(part[field]))]
