"""The blocks of a run as rows of a table: what each has done and come to."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grind_env.control import Programs
from grind_env.control.source import lines_of
from grind_env.machine.record import GrindingRecord
from grind_env.render.curves import Span, block_name, spans, sparks_out

HEADINGS = (
    "block",
    "words",
    "runs",
    "strokes",
    "spark-out",
    "time, s",
    "depth, µm",
    "deepest cut, µm",
    "power, kW",
    "torque, %",
    "temp., K",
    "burn ratio",
    "Ra left, µm",
    "wear flats, %",
    "dresses",
)

_NUMBER = re.compile(r"^/?\s*[Nn]\s*\d+\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockRow:
    """All executions of a block, or of blocks of the same words.

    Attributes:
            line: of the first of them.
        cells: texts under `HEADINGS`.
        summary: the same as a remark in the program.
    """

    line: int
    cells: tuple[str, ...]
    summary: str


def block_rows(record: GrindingRecord, programs: Programs) -> list[BlockRow]:
    """The blocks that have ground, in the order in which they first did; those of the same words in one row."""
    texts = program_lines(programs)
    grouped: dict[str, list[Span]] = {}
    for span in spans(record):
        line = int(record.strokes["line"][span.first])
        plan = record.cycles.get(line)
        text = plan.text if plan is not None else texts[line - 1] if line <= len(texts) else ""
        grouped.setdefault(_NUMBER.sub("", text).strip() or span.label, []).append(span)
    sparks = sparks_out(record)
    return [_row(record, text, found, sparks) for text, found in grouped.items()]


def program_lines(programs: Programs) -> list[str]:
    """The lines of the file of the main program."""
    return lines_of(programs.main.blocks.text)


def _row(record: GrindingRecord, text: str, found: Sequence[Span], sparks: np.ndarray) -> BlockRow:
    strokes = record.strokes
    chosen = np.concatenate([np.arange(span.first, span.after) for span in found])
    rows, lasts = strokes[chosen], strokes[[span.after - 1 for span in found]]
    lines = list(dict.fromkeys(strokes["line"][[span.first for span in found]].tolist()))
    name = block_name(record, lines[0])
    dresses = sum(
        int(((record.dresses["after"] > span.first) & (record.dresses["after"] <= span.after)).sum()) for span in found
    )
    runs = len(found)
    cells = (
        name if len(lines) == 1 else f"{name} and {len(lines) - 1} more",
        text,
        str(runs),
        f"{rows.size / runs:.0f}",
        f"{sparks[chosen].sum() / runs:.0f}",
        f"{rows['seconds'].sum() / runs:.1f}",
        _span(1000.0 * rows["Z"], "{:.0f}"),
        f"{1000.0 * rows['ae'].max():.1f}",
        f"{0.001 * rows['power'].max():.2f}",
        f"{100.0 * rows['torque'].max():.0f}",
        f"{rows['T'].max():.0f}",
        f"{rows['Br'].max():.2f}",
        _span(lasts["Ra"], "{:.2f}"),
        _span(100.0 * rows["A"], "{:.2f}"),
        str(dresses),
    )
    summary = (
        f"{cells[3]} stroke{'s' * (cells[3] != '1')}, {cells[5]} s, up to {cells[8]} kW and {cells[10]} K, "
        f"Ra {cells[12]} µm"
        f"{f', {dresses} dresses' if dresses > 1 else ', 1 dress' if dresses else ''}"
    )
    return BlockRow(line=lines[0], cells=cells, summary=summary)


def _span(values: np.ndarray, form: str) -> str:
    """The lowest and the highest value, or the one that all of them are as they are shown."""
    low, high = form.format(values.min()), form.format(values.max())
    return low if low == high else f"{low} to {high}"
