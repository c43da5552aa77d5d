"""The blocks of a run as rows of a table: what each has done and come to."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grind_env.control import Programs
from grind_env.control.source import lines_of
from grind_env.machine.record import GrindingRecord
from grind_env.render.comparison import between, blocks_named, same_words
from grind_env.render.curves import Span, spans, sparks_out

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


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockSummary:
    """All executions of a block, or of blocks of the same words.

    Attributes:
        line: of the first of them.
        cells: texts under `HEADINGS`.
        summary: the same as a remark in the program.
    """

    line: int
    cells: tuple[str, ...]
    summary: str


def block_rows(record: GrindingRecord) -> list[BlockSummary]:
    """The blocks that have ground, in the order in which they first did; those of the same words in one row."""
    every, sparks = spans(record), sparks_out(record)
    return [_row(record, words, [every[k] for k in found], sparks) for words, found in same_words(record).items()]


def program_lines(programs: Programs) -> list[str]:
    """The lines of the file of the main program."""
    return lines_of(programs.main.blocks.text)


def _row(record: GrindingRecord, text: str, found: Sequence[Span], sparks: np.ndarray) -> BlockSummary:
    strokes = record.strokes
    chosen = np.concatenate([np.arange(span.first, span.after) for span in found])
    rows, lasts = strokes[chosen], strokes[[span.after - 1 for span in found]]
    lines = strokes["line"][[span.first for span in found]].tolist()
    dresses = sum(
        int(((record.dresses["after"] > span.first) & (record.dresses["after"] <= span.after)).sum()) for span in found
    )
    runs = len(found)
    cells = (
        blocks_named(record, lines),
        text,
        str(runs),
        f"{rows.size / runs:.0f}",
        f"{sparks[chosen].sum() / runs:.0f}",
        f"{rows['seconds'].sum() / runs:.1f}",
        between(1000.0 * rows["Z"], "{:.0f}"),
        f"{1000.0 * rows['ae'].max():.1f}",
        f"{0.001 * rows['power'].max():.2f}",
        f"{100.0 * rows['torque'].max():.0f}",
        f"{rows['T'].max():.0f}",
        f"{rows['Br'].max():.2f}",
        between(lasts["Ra"], "{:.2f}"),
        between(100.0 * rows["A"], "{:.2f}"),
        str(dresses),
    )
    summary = (
        f"{cells[3]} stroke{'s' * (cells[3] != '1')}, {cells[5]} s, up to {cells[8]} kW and {cells[10]} K, "
        f"Ra {cells[12]} µm"
        f"{f', {dresses} dresses' if dresses > 1 else ', 1 dress' if dresses else ''}"
    )
    return BlockSummary(line=lines[0], cells=cells, summary=summary)
