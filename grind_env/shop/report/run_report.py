"""The report of a run, which `grind report` writes."""

import math
import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from grind_env.control.program_scanner import lines_of
from grind_env.data_table import Cell, Kind, table_of
from grind_env.machine.dress.mounted_wheel import first_diameter
from grind_env.machine.record import GrindingRecord
from grind_env.process.cost import NO_LIMIT, SCRAP_BELOW
from grind_env.render.block_comparison import HEADINGS as COMPARED
from grind_env.render.block_comparison import MEANING, SHARPENING, between, blocks_named, compared_blocks, same_words
from grind_env.render.curve_data import Span, picture, spans, sparks_out
from grind_env.render.record_tables import SCALES, STATION, faults, part_table, totals
from grind_env.shop.report import document
from grind_env.shop.report.provenance import assumptions, foundations, revisions

if TYPE_CHECKING:
    from markupsafe import Markup

MOST_ROWS = 30  #: greatest number of rows of a table; a longer table shows its first and last rows
LONGEST_LINE = 200  #: greatest number of characters of a block in a table
SAFE = 0.95  #: parts that are good with less than this probability are at risk
NARROW = 0.1  #: unused share of a limit below which it is narrow

_WARNING = re.compile(r"^(?P<file>[^\n]*?):(?P<line>\d+): (?P<text>.*)$", re.DOTALL)


class BlockSummary(NamedTuple):
    """Summary of all executions of a block, or of blocks with the same words."""

    line: int  #: line of the first block
    cells: dict[str, str]  #: texts by heading
    summary: str  #: summary as a note in the listing of the program


def run_report(record: GrindingRecord, files: Sequence[Path] = ()) -> str:
    """Return the page of a run, HTML.

    Raises:
        MissingExtra: as in `page`.
    """
    blocks, job = block_rows(record), record.job
    shown = picture(record)
    bands = " Bands go from the lowest to the highest value." if shown.banded else ""
    marks = " Orange lines are dresses, shaded strokes spark out, dotted lines set the blocks off."
    caption = f"Over every {shown.axis} of the run.{bands}{marks if shown.spans else ''}"
    sections = [
        document.Section("Verdict", [_verdict(record)]),
        document.Section("Margin to the limits", [_margins(record)]),
        document.Section("Blocks", [_blocks(blocks)]),
        document.Section(
            "Comparison",
            [document.table(table_of(COMPARED, compared_blocks(record), left=1).shortened(MOST_ROWS), MEANING)],
        ),
        document.Section("Run", [document.figure(shown, caption)]),
        document.Section("Parts", _parts(record)),
        document.Section("Dresses and wheel", _dresses(record)),
        document.Section("Cost", [_cost(record)]),
        document.Section("Warnings", [_warnings(record)]),
        document.Section("Program", _program(record, blocks)),
        document.Section("Assumptions and calibration", [document.items(assumptions(job)), *foundations(job)]),
    ]
    revised = revisions(dict(zip(("program", "job"), files, strict=False)))
    return document.page(f"{document.TITLE}{record.programs.name}", sections, revised)


def _verdict(record: GrindingRecord) -> "Markup":
    survival = record.parts["survival"]
    scrap, risky = int((survival < SCRAP_BELOW).sum()), int((survival < SAFE).sum())
    unjudged = sum(map(bool, record.unjudged))
    count = survival.size
    level: Kind = "bad" if scrap else "poor" if risky else "good"
    whole = "the part" if count == 1 else f"all {count} parts"
    headline = {
        "bad": f"{scrap} of {count} parts are more likely scrap than good." if count > 1 else "The part is scrap.",
        "poor": f"{risky} of {count} parts may be scrap." if count > 1 else "The part may be scrap.",
        "good": f"The program grinds {whole} within the limits.",
    }[level]
    if unjudged:
        headline = f"{unjudged} of {count} parts are not judged." if count > 1 else "The part is not judged."
    found = [f"{fault.sentence}{f': {fault.why}' if fault.why else ''}" for fault in faults(record)]
    warnings = len(record.warnings)
    warned = [f"{warnings} warning{'s' * (warnings > 1)}, listed below."] if warnings else []
    return document.verdict(level, headline, [totals(record), *found, *warned])


def _margins(record: GrindingRecord) -> "Markup":
    parts, job = record.parts, record.job
    limits = np.array([job.of_part(number).limits for number in parts["part"].tolist()])
    rise, power, roughness, size = limits.T
    names = [f"{number} {job.station_of(number)}".rstrip() for number in parts["part"].tolist()]
    rows = [
        _margin("temperature rise, K", parts["rise"], names, rise, ".0f"),
        _margin("spindle torque, % of stalling", 100.0 * parts["peak_torque"], names, 100.0, ".0f"),
        _margin("spindle power, kW", 0.001 * parts["peak_power"], names, 0.001 * power, ".2f"),
        _margin("roughness Ra, µm", parts["Ra"], names, roughness, ".2f"),
        _margin("size error, µm", np.abs(parts["worst_error"]), names, size, ".1f"),
        _margin("burn ratio (a warning, no scrap)", parts["burn_ratio"], names, 1.0, ".2f"),
    ]
    used = first_diameter(job) - record.strokes["ds"]
    least = first_diameter(job) - job.setup.wheel.minimum_diameter
    rows.append(_margin("wheel used up, mm of diameter", used, record.strokes["part"].tolist(), least, ".3f"))
    return document.table(table_of(("limit", "worst", "limit is", "left, %", "in part"), rows, left=1))


def _margin(
    name: str, values: np.ndarray, parts: Sequence[object], limits: np.ndarray | float, form: str
) -> Sequence[str | Cell]:
    """Return the row of a limit, for the part with the smallest unused share; `limits` may differ from part to part."""
    every = np.broadcast_to(limits, values.shape)
    shares = np.divide(values, every, out=np.full(values.shape, -math.inf), where=every > NO_LIMIT)
    worst = int(np.argmax(shares)) if np.isfinite(shares).any() else int(np.argmax(values))
    value, limit = float(values[worst]), float(every[worst])
    if limit <= NO_LIMIT:
        return [name, f"{value:{form}}", "none", "–", str(parts[worst])]
    left = 1.0 - value / limit
    kind: Kind = "bad" if left < 0.0 else "poor" if left < NARROW else "good"
    return [name, f"{value:{form}}", f"{limit:{form}}", Cell(f"{100.0 * left:.0f}", kind), str(parts[worst])]


def block_rows(record: GrindingRecord) -> list[BlockSummary]:
    """Return the blocks that have ground, in order of first execution; equal blocks share a row."""
    every, sparks = spans(record), sparks_out(record)
    return [_block(record, words, [every[k] for k in found], sparks) for words, found in same_words(record).items()]


def _block(record: GrindingRecord, text: str, found: Sequence[Span], sparks: np.ndarray) -> BlockSummary:
    strokes = record.strokes
    chosen = np.concatenate([np.arange(span.first, span.after) for span in found])
    rows, lasts = strokes[chosen], strokes[[span.after - 1 for span in found]]
    lines = strokes["line"][[span.first for span in found]].tolist()
    dresses = sum(
        int(((record.dresses["after"] > span.first) & (record.dresses["after"] <= span.after)).sum()) for span in found
    )
    runs = len(found)
    cells = {
        "block": blocks_named(record, lines),
        "words": text,
        "runs": str(runs),
        "strokes": f"{rows.size / runs:.0f}",
        "spark-out": f"{sparks[chosen].sum() / runs:.0f}",
        "time, s": f"{rows['seconds'].sum() / runs:.1f}",
        "depth, µm": between(1000.0 * rows["Z"], "{:.0f}"),
        "deepest cut, µm": f"{1000.0 * rows['ae'].max():.1f}",
        "power, kW": f"{0.001 * rows['load'].max():.2f}",
        "torque, %": f"{100.0 * rows['torque'].max():.0f}",
        "rise, K": f"{rows['T'].max():.0f}",
        "burn ratio": f"{rows['burn_ratio'].max():.2f}",
        "Ra left, µm": between(lasts["Ra"], "{:.2f}"),
        "wear flats, %": between(100.0 * rows["A"], "{:.2f}"),
        "dresses": str(dresses),
    }
    summary = (
        f"{cells['strokes']} stroke{'s' * (cells['strokes'] != '1')}, {cells['time, s']} s, up to "
        f"{cells['power, kW']} kW and {cells['rise, K']} K, Ra {cells['Ra left, µm']} µm"
        f"{f', {dresses} dresses' if dresses > 1 else ', 1 dress' if dresses else ''}"
    )
    return BlockSummary(lines[0], cells, summary)


def _blocks(blocks: Sequence[BlockSummary]) -> "Markup":
    rows = [[*(row.cells | {"words": Cell(row.cells["words"][:LONGEST_LINE], "code")}).values()] for row in blocks]
    caption = "Strokes, spark-out and time are those of one run of the block; the rest is the extreme of all of them."
    return document.table(table_of([*blocks[0].cells], rows, left=2).shortened(MOST_ROWS), caption)


def _parts(record: GrindingRecord) -> "list[Markup]":
    found = part_table(record)
    every = table_of(found.headings, found.rows, left=1)
    whole = document.table(every.shortened(MOST_ROWS), "Successive parts that are alike share a row.")
    if len(every.rows) <= MOST_ROWS:
        return [whole]
    shown = [name for name in found.fields[1:] if name != STATION]
    values = {name: record.parts[name] * SCALES.get(name, 1) for name in shown}
    ways = {"lowest": "min", "mean": "mean", "highest": "max"}
    bands = [[name, *(_number(getattr(value, way)()) for value in values.values())] for name, way in ways.items()]
    headings = [heading for heading in every.headings[1:] if heading != STATION]
    return [document.table(table_of(["of all parts", *headings], bands, left=1)), whole]


def _number(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def _dresses(record: GrindingRecord) -> "list[Markup]":
    dresses, wheel = record.dresses, record.job.setup.wheel
    last = float(record.strokes["ds"][-1])
    if not dresses.size:
        return [document.paragraph(f"The wheel is not dressed. It ends with {last:.3f} mm of diameter.")]
    keys = [
        (
            *(row["cause"], row["program"], f"{row['seconds']:.1f}", f"{row['removed']:.0f}"),
            *(form.format(row[name]) for name, form in SHARPENING.items()),
        )
        for row in dresses
    ]
    rows = list[dict[str, str]]()
    for (cause, program, seconds, removed, lead, overlap, severity), numbered in groupby(
        range(len(keys)), key=keys.__getitem__
    ):
        first, *_ = numbers = [*numbered]
        final = dresses[numbers[-1]]
        rows.append(
            {
                "dress": _range(first + 1, numbers[-1] + 1),
                "cause": str(cause),
                "program": f"O{program}",
                "part": _range(int(dresses[first]["part"]), int(final["part"])),
                "after stroke": _range(int(dresses[first]["after"]), int(final["after"])),
                "time, s": seconds,
                "wheel taken off, mm³": removed,
                "lead, mm/rev": lead,
                "overlap ratio": overlap,
                "severity": severity,
                "diameter after it, mm": f"{final['ds']:.3f}",
            }
        )
    per_dress = 2.0 * float(dresses["removed"].mean()) / (math.pi * float(dresses["ds"].mean()) * wheel.width)
    left = max((last - wheel.minimum_diameter) / per_dress, 0.0) if per_dress > 0.0 else math.inf
    lasting = f"{left:.0f} dresses are left." if math.isfinite(left) else "none is used up."
    text = (
        f"The wheel ends with {last:.3f} mm of diameter and is changed below {wheel.minimum_diameter:g} mm. "
        f"A dress takes {per_dress:.3f} mm of it: {lasting}"
    )
    every = table_of([*rows[0]], [[*row.values()] for row in rows], left=3)
    return [document.paragraph(text), document.table(every.shortened(MOST_ROWS))]


def _cost(record: GrindingRecord) -> "Markup":
    parts = record.parts
    names = {"time": "time_cost", "wheel": "wheel_cost", "dresser": "dress_cost", "expected scrap": "scrap_cost"}
    whole = float(parts["total_cost"].sum())
    costs = {name: float(parts[field].sum()) for name, field in {**names, "all": "total_cost"}.items()}
    rows = [
        (name, f"{cost:.2f}", f"{cost / parts.size:.3f}", f"{100.0 * cost / whole:.0f}" if whole > 0.0 else "–")
        for name, cost in costs.items()
    ]
    good = float(parts["survival"].sum())
    caption = f"{record.cost_per_good_part:.2f} $ per good part." if good > 0.0 else "No good part is expected."
    return document.table(table_of(("cost", "of the run, $", "a part, $", "share, %"), rows, left=1), caption)


def _warnings(record: GrindingRecord) -> "Markup":
    if not record.warnings:
        return document.paragraph("None.")
    texts, found = lines_of(record.programs.main.blocks.text), dict[str, list[int]]()
    for warning in record.warnings:
        match = _WARNING.match(warning)
        line = int(match["line"]) if match and match["file"] == record.programs.name else 0
        found.setdefault(match["text"] if match and line else warning, []).append(line)
    rows = []
    for text, lines in found.items():
        line = lines[0]
        more = f" and {len(lines) - 1} more" if len(lines) > 1 else ""
        block = texts[line - 1].strip()[:LONGEST_LINE] if 0 < line <= len(texts) else ""
        rows.append((f"{line}{more}" if line else "–", Cell(block, "code"), text))
    return document.table(table_of(("line", "block", "warning"), rows).shortened(MOST_ROWS))


def _program(record: GrindingRecord, blocks: Sequence[BlockSummary]) -> "list[Markup]":
    notes: dict[int, list[document.Note]] = {}
    for row in blocks:
        notes.setdefault(row.line, []).append(document.Note(row.summary))
    for warning in record.warnings:
        if (match := _WARNING.match(warning)) and match["file"] == record.programs.name:
            notes.setdefault(int(match["line"]), []).append(document.Note(match["text"], "poor"))
    return document.listing(lines_of(record.programs.main.blocks.text), notes)


def _range(first: int, last: int) -> str:
    return str(first) if first == last else f"{first} to {last}"
