"""Comparison numbers as text: a row for each block that has ground, a sentence for each dress program."""

import re
from collections.abc import Sequence

import numpy as np

from grind_env.array_types import Array
from grind_env.control.program_scanner import lines_of
from grind_env.machine.record import GrindingRecord
from grind_env.render.curve_data import block_name

_NUMBER = re.compile(r"^/?\s*[Nn]\s*\d+\s*")

HEADINGS = ("block", "Q'w\nmm²/s", "V'w\nmm³/mm", "vs/vw", "aggr.", "u_s\nJ/mm³")
MEANING = (
    "Q'w and aggressiveness are the highest of all strokes, V'w is that of one run of the block, vs/vw the mean of the "
    "strokes that cut, and u_s all energy over all volume."
)

#: format of each field of `machine.dress.dress_severity.Sharpening`
SHARPENING = {"lead": "{:.3f}", "overlap": "{:.2f}", "severity": "{:.2f}"}


def compared_blocks(record: GrindingRecord) -> list[tuple[str, ...]]:
    """Return texts under `HEADINGS`, a row for all executions of blocks with the same words, as in `same_words`."""
    rows = record.executions
    return [_compared(record, rows[chosen]) for chosen in same_words(record).values()]


def same_words(record: GrindingRecord) -> dict[str, list[int]]:
    """Return groups of block executions, from 0, with the same words, in the order of first grinding."""
    texts = lines_of(record.programs.main.blocks.text)
    found: dict[str, list[int]] = {}
    for k, line in enumerate(record.executions["line"].tolist()):
        plan = record.cycles.get(line)
        text = plan.text if plan is not None else texts[line - 1] if line <= len(texts) else ""
        found.setdefault(_NUMBER.sub("", text).strip() or block_name(record, line), []).append(k)
    return found


def blocks_named(record: GrindingRecord, lines: Sequence[int]) -> str:
    """Return text with the name of the first block in some lines, and the number of further blocks."""
    different = list(dict.fromkeys(lines))
    more = f" and {len(different) - 1} more" if len(different) > 1 else ""
    return f"{block_name(record, different[0])}{more}"


def compared_dresses(record: GrindingRecord) -> list[str]:
    """Return a sentence for each dress program that has dressed the wheel."""
    dressed = record.dresses[record.dresses["overlap"] > 0.0]
    said = []
    for number in dict.fromkeys(dressed["program"].tolist()):
        rows = dressed[dressed["program"] == number]
        lead, overlap, severity = (between(rows[name], form) for name, form in SHARPENING.items())
        said.append(f"dress O{number}: lead {lead} mm, overlap ratio {overlap}, severity {severity} of a medium dress")
    return said


def between(values: Array, form: str) -> str:
    """Return the lowest and the highest value as text, or only one if both have the same text."""
    low, high = form.format(values.min()), form.format(values.max())
    return low if low == high else f"{low} to {high}"


def _compared(record: GrindingRecord, rows: Array) -> tuple[str, ...]:
    ground, cutting = rows["ground"].sum(), rows["speed_ratio"] > 0.0
    return (
        blocks_named(record, rows["line"].tolist()),
        f"{rows['peak_Q'].max():.2f}",
        f"{rows['V'].mean():.2f}",
        f"{np.mean(rows['speed_ratio'][cutting]):.0f}" if cutting.any() else "–",
        f"{rows['aggressiveness'].max():.1f}",
        f"{rows['energy'].sum() / ground:.1f}" if ground > 0.0 else "–",
    )
