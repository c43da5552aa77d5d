"""A grinding record as a table for the terminal, and as plain data for JSON."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.data_table import Cell, table_of
from grind_env.machine.job import Job
from grind_env.machine.part.unsimulated_cuts import Unjudged, list_lines, runs
from grind_env.machine.record import GrindingRecord
from grind_env.message_text import printable
from grind_env.process.cost import SCRAP_BELOW, passed_limits
from grind_env.render.block_comparison import HEADINGS, compared_blocks, compared_dresses
from grind_env.render.limit_causes import explain, shares

if TYPE_CHECKING:
    from rich.console import Console

#: heading and format of each column, by the field of `record.PART_ROW`
COLUMNS = {
    "part": ("part", "{:d}"),
    "seconds": ("time\ns", "{:.1f}"),
    "strokes": ("strokes", "{:d}"),
    "dresses": ("dresses", "{:d}"),
    "worst_error": ("size\nerr.µm", "{:.1f}"),
    "taper": ("taper\nµm", "{:.1f}"),
    "Ra": ("Ra\nµm", "{:.2f}"),
    "peak_power": ("power\nkW", "{:.2f}"),
    "rise": ("rise\nK", "{:.0f}"),
    "highest_rise": ("highest\nrise K", "{:.0f}"),
    "survival": ("good\n%", "{:.1f}"),
    "total_cost": ("cost\n$", "{:.2f}"),
}

STATION = "station"  #: column behind the number of a part, for jobs with stations

WHERE_IT_OCCURS = ("dresses", "taper")  #: columns that are left out if they hold zeros only

#: heading of the rise of the last stage, if it differs from the highest rise, which then has its own column
LAST_STAGE = "last st.\nrise K"

#: word and column of each cause why a part is not good, by the name that `causes_of` returns
CAUSES = {
    "rise": ("temperature", "rise"),
    "power": ("stall", "peak_power"),
    "roughness": ("Ra", "Ra"),
    "size": ("size", "worst_error"),
    "unground": ("unground", "survival"),
    "earlier": ("earlier stage", "survival"),
}

#: printed sentence for causes that are not the limit of a quantity, by their word
SENTENCES = {
    "stall": "the spindle stalled",
    "unground": "not ground everywhere",
    "earlier stage": "not good in an earlier stage",
}

UNKNOWN = "–"  #: text in place of the probability that a part is good, if the part is not judged

NONE_GOOD = 0.005  #: expected number of good parts below which there are none

SCALES = {"peak_power": 0.001, "survival": 100.0}  #: factor from a field to the unit of its heading


MOST_ROWS = 60  #: most rows of a table; of a longer one the first and the last rows are printed


class PartTable(NamedTuple):
    """A table with a row for each part, or for successive equal parts."""

    fields: tuple[str, ...]  #: fields of `record.PART_ROW`, a column each, or `STATION`; the first is the number
    headings: tuple[str, ...]
    rows: list[list[Cell]]


class Fault(NamedTuple):
    """A limit that parts exceed, or another cause why they are not good."""

    words: str  #: the cause, as `cause_words` names it
    sentence: str  #: sentence with the limit and the parts
    why: str  #: place, amount and the word to change; empty if nothing more is known


def part_table(record: GrindingRecord) -> PartTable:
    """Return the table of the parts; successive equal rows are one row."""
    columns = {
        name: column
        for name, column in COLUMNS.items()
        if name not in WHERE_IT_OCCURS
        or any(column[1].format(value) != column[1].format(0) for value in record.parts[name])
    }
    cells = {
        name: [form.format(value * SCALES.get(name, 1)) for value in record.parts[name].tolist()]
        for name, (_, form) in columns.items()
    }
    goods = zip(cells["survival"], record.unjudged, strict=True)
    cells["survival"] = [UNKNOWN if unjudged else text for text, unjudged in goods]
    headings = {name: heading for name, (heading, _) in columns.items()}
    if cells["highest_rise"] == cells["rise"]:
        del cells["highest_rise"], headings["highest_rise"]
    else:
        headings["rise"] = LAST_STAGE
    if record.job.stations:
        names = [printable(record.job.station_of(number)) for number in record.parts["part"].tolist()]
        cells = {"part": cells["part"], STATION: names, **cells}
        headings = {"part": headings["part"], STATION: STATION, **headings}
    return PartTable(tuple(headings), tuple(headings.values()), _joined(record, cells))


def faults(record: GrindingRecord) -> list[Fault]:
    """Return the limits that parts exceed, and other causes why parts are not good."""
    bad: dict[str, list[int]] = {}
    for part, stages, unjudged_part in zip(record.parts, record.stages, record.unjudged, strict=True):
        for words in cause_words(causes_of(part, record.job), stages, unjudged_part):
            bad.setdefault(words, []).append(int(part["part"]))
    unjudged = {not_judged(found): "; ".join(each.why for each in found) for found in record.unjudged if found}
    found = []
    for words, numbers in bad.items():
        limit = words if words in unjudged else SENTENCES.get(words, f"beyond the limit of {words}")
        cause = next((cause for cause, (word, _) in CAUSES.items() if word == words), "")
        sentence = f"{limit}: {parts_text(numbers, record.job)}"
        found.append(Fault(words, sentence, unjudged.get(words) or explain(cause, numbers, record)))
    return found


def parts_text(numbers: Sequence[int], job: Job) -> str:
    """Return text that names parts by their ascending numbers and, for a job with stations, the stations."""
    text = f"part{'s' * (len(numbers) > 1)} {runs(numbers)}"
    names = dict.fromkeys(job.station_of(number) for number in numbers)
    return f"{text} (station{'s' * (len(names) > 1)} {', '.join(names)})" if job.stations else text


def print_record(record: GrindingRecord, title: str, console: "Console") -> None:
    """Print a row per part or group of equal parts, exceeded limits in red; then all sentences."""
    from rich.text import Text

    parts, job = part_table(record), record.job
    where = ("" if job.uncertainty else ", not calibrated") + (f", on {job.plant}" if job.plant else "")
    console.print(Text(printable(f"{title}{where}"), "italic"), soft_wrap=True)
    table_of(parts.headings, parts.rows, left=0).shortened(MOST_ROWS, "...").print(console)
    if len(parts.rows) > MOST_ROWS:
        console.print(f"... {len(parts.rows) - MOST_ROWS} more rows, which --json has")
    console.print()
    table_of(HEADINGS, compared_blocks(record), left=0).shortened(MOST_ROWS, "...").print(console)
    for sentence in compared_dresses(record):
        console.print(Text(sentence), soft_wrap=True)
    console.print()
    console.print(totals(record), highlight=False)
    console.print(Text(_size(record)), soft_wrap=True)
    for fault in faults(record):
        console.print(Text(printable(fault.sentence), "red"), soft_wrap=True)
        if fault.why:
            console.print(Text(printable(f"  {fault.why}"), "red"), soft_wrap=True)
    for warning in record.warnings:
        console.print(Text(printable(f"warning: {warning}"), "yellow"), soft_wrap=True)


def _joined(record: GrindingRecord, cells: Mapping[str, Sequence[str]]) -> list[list[Cell]]:
    """Return the rows; successive parts with the same texts share one."""
    every, rows = list[tuple[tuple[list[str], set[str]], str]](), list[list[Cell]]()
    for part, number, *texts in zip(record.parts, *cells.values(), strict=True):
        red = {CAUSES[cause][1] for cause in causes_of(part, record.job)}
        if part["survival"] < SCRAP_BELOW:
            red.add("survival")
        every.append(((texts, red), number))
    for (texts, red), alike in groupby(every, itemgetter(0)):
        numbers = [number for _, number in alike]
        number = numbers[0] if len(numbers) == 1 else f"{numbers[0]} to {numbers[-1]}"
        shown = zip(cells, (number, *texts), strict=True)
        rows.append([Cell(text, "bad" if field in red else "") for field, text in shown])
    return rows


def _size(record: GrindingRecord) -> str:
    part = record.parts[np.argmax(np.abs(record.parts["size_error"]))]
    whose = f" of {parts_text([int(part['part'])], record.job)}" if len(record.parts) > 1 else ""
    return f"mean size error{whose} {shares(part)}"


def totals(record: GrindingRecord) -> str:
    """Return parts, time and cost of a run in one line."""
    parts, cost, good = len(record.parts), record.parts["total_cost"].sum(), float(record.parts["survival"].sum())
    infeeds = record.parts["infeeds"].sum()
    unjudged = sum(map(bool, record.unjudged))
    if parts == 1:
        share = "1 part, not judged" if unjudged else f"1 part, good with {100.0 * good:.1f} %"
    else:
        share = f"{parts} parts, {good:.2f} good ones expected{f', {unjudged} not judged' if unjudged else ''}"
    price = f"{record.cost_per_good_part:.2f} $ per good part" if good >= NONE_GOOD else "no good part"
    grooves = f"; {infeeds} infeeds of grooves" if infeeds else ""
    return f"{share}; {record.seconds:.1f} s, {cost:.2f} $, {price}{grooves}"


def causes_of(part: Any, job: Job) -> tuple[str, ...]:
    """Return the exceeded limits of the job for a part, a row of `record.PART_ROW`.

    Returns:
        Fields of `process.cost.Limits`, then `unground` if no stroke has reached some place of the part, and `earlier`
        if the part was not good at a gauging stop.
    """
    limits = job.of_part(int(part["part"])).limits
    passed = passed_limits(part["rise"], part["peak_torque"], part["Ra"], part["worst_error"], limits)
    others = {"unground": part["unground"] > 0.0, "earlier": part["earlier"] < SCRAP_BELOW}
    return (*passed, *(name for name, is_so in others.items() if is_so))


def cause_words(names: Sequence[str], stages: Sequence[Sequence[str]], unjudged: Sequence[Unjudged] = ()) -> list[str]:
    """Return the words for why a part is not good: its causes `names`, and exceeded limits of its stages.

    For a part that is not judged, the only text is `not_judged`, with the lines of the program.
    """
    if unjudged:
        return [not_judged(unjudged)]
    named = [f"{CAUSES[limit][0]} in stage {number}" for number, passed in enumerate(stages, 1) for limit in passed]
    return [CAUSES[name][0] for name in names if name != "earlier" or not named] + named


def not_judged(found: Sequence[Unjudged]) -> str:
    """Return the sentence on a part that is not judged."""
    return f"not judged ({list_lines(line for each in found for line in each.lines)})"


def as_data(record: GrindingRecord, title: str) -> dict[str, Any]:
    """Return the record without strokes, in JSON types; names and units as in `record.PART_ROW` and `DRESS_ROW`.

    `plant` is the machine if it differs from the model. `cycles` are the executions of blocks
    (`EXECUTION_ROW`). Each part has a list `beyond` of the causes why it is not good and, in a job with
    stations, the name of its `station`. `reasons` says for each word in `beyond` where parts have exceeded the limit
    most, and what to do.
    """
    job, names = record.job, record.parts.dtype.names or ()
    return {
        "program": title,
        **({"plant": job.plant} if job.plant else {}),
        "seconds": record.seconds,
        "cost": float(record.parts["total_cost"].sum()),
        "good_parts": float(record.parts["survival"].sum()),
        "parts": [
            dict(zip(names, part.tolist(), strict=True))
            | ({STATION: job.station_of(int(part["part"]))} if job.stations else {})
            | {"beyond": cause_words(causes_of(part, job), stages, unjudged)}
            for part, stages, unjudged in zip(record.parts, record.stages, record.unjudged, strict=True)
        ],
        "cycles": _rows(record.executions),
        "dresses": _rows(record.dresses),
        "reasons": {fault.words: fault.why for fault in faults(record) if fault.why},
        "warnings": list(record.warnings),
    }


def _rows(table: Array) -> list[dict[str, Any]]:
    return [dict(zip(table.dtype.names or (), row, strict=True)) for row in table.tolist()]
