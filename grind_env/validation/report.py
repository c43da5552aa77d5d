"""The table of checks in the terminal, and its rows as a CSV file."""

import math
from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from rich import box
from rich.console import Console
from rich.text import Text

from grind_env.data_table import Cell, Column, table_of
from grind_env.files import write_csv as write_rows
from grind_env.validation import GROUPS, Evidence, Row, is_expected, known_failures, unfit_uses
from grind_env.validation.mutations import LEAST_ROWS, MutationResult
from grind_env.validation.rig import CONDITIONS

WIDTH = 120  #: most characters of a line


def number(value: float) -> str:
    """Return a number in three digits; a dash for NaN."""
    return "-" if math.isnan(value) else f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"


def verdict(row: Row) -> str:
    """Return the result of a row, in a word or two."""
    if is_expected(row):
        return "pass" if row.passed else "known to fail"
    return "passes, though known to fail" if row.passed else "FAILS"


def reason(row: Row) -> str:
    """Return the reason why a row has no number or fails; "" without a reason."""
    return ". ".join(filter(None, (row.missing, known_failures().get(row.check.name, ""))))


def _described(row: Row) -> Cell:
    """Return a cell with name, conditions, source of the band and remarks of a row, a line each."""
    why = f"why: {reason(row)}" if reason(row) else ""
    said = "\n".join(filter(None, (row.check.at, str(row.check.basis), why, outside(row))))
    return Cell(row.check.what, "" if row.passed else "poor" if is_expected(row) else "bad", said)


def outside(row: Row) -> str:
    """Return the conditions beyond the limits of the catalogue; "" for none."""
    return f"outside the catalogue: {'; '.join(map(str, row.outside))}" if row.outside else ""


def expected(row: Row) -> str:
    """Return the band, and the number that was measured, published or remembered."""
    reference = "" if row.check.reference is None else f" ({number(row.check.reference)})"
    return f"{row.check.band}{reference}"


NUMBERS = (
    Column("model", lambda row: number(row.value), wrap=True),
    Column("band (reference)", expected, wrap=True),
    Column("unit", "check.unit", wrap=True),
)
COLUMNS = (Column("what, at, from", _described, wrap=True), *NUMBERS, Column("", verdict, wrap=True))
CSV_COLUMNS = (
    *("group", "name", "what", "at", "evidence", "source", "reference", "predicted", "low", "high", "unit"),
    *("verdict", "reason", "outside limits"),
)
TABLE_STYLE = {"box": box.SIMPLE, "show_edge": True, "pad_edge": True, "padding": (0, 1)}


def sources(rows: Sequence[Row]) -> str:
    """Return how many rows have each kind of source, in one sentence."""
    counts = Counter(row.check.basis.evidence for row in rows)
    first, *others = Evidence
    listed = ", ".join(f"{counts[kind]} {kind.value}" for kind in others)
    return f"{len(rows)} rows: {counts[first]} carry {first.value}, {listed}."


def beyond_limits(rows: Sequence[Row]) -> str:
    """Return how many rows lie outside the catalogue, in one sentence."""
    count = sum(bool(row.outside) for row in rows)
    return f"{count} rows lie beyond a limit of wheel or machine in the catalogue; each names the limit."


def totals(rows: Sequence[Row]) -> str:
    """Return how many rows pass and fail, in one line."""
    passed = sum(row.passed for row in rows)
    known = sum(not row.passed and is_expected(row) for row in rows)
    wrong = sum(not is_expected(row) for row in rows)
    return f"{len(rows)} rows: {passed} pass, {known} known to fail, {wrong} unexpected"


def print_report(rows: Sequence[Row], console: Console) -> None:
    """Print the rows by group, and what the model must not be used for."""
    console.print(sources(rows))
    console.print(beyond_limits(rows))
    console.print(CONDITIONS)
    console.print()
    for group, members in groupby(rows, lambda row: row.check.group):
        table_of(COLUMNS, members, f"{group}. {GROUPS[group]}").print(console, **TABLE_STYLE)
    console.print(Text("The model must not be used for", "bold"))
    for use, why in unfit_uses().items():
        console.print(f"- {use}: {why}.")
    console.print()
    console.print(totals(rows))


def _law(found: MutationResult) -> Cell:
    texts = "; ".join(found.rows), found.law.known and f"why: {found.law.known}"
    return Cell(found.law.name, "" if found.is_expected else "bad", "\n".join(filter(None, texts)))


def print_mutations(found: Sequence[MutationResult], console: Console) -> None:
    """Print the rows that notice each changed law, and the number of laws that are noticed."""
    counted = Column("rows", lambda each: len(each.rows), right=True)
    columns = (Column("law, noticed by", _law, wrap=True), Column("decides", "law.decides"), counted)
    table_of(columns, found, "Laws of the process, changed one at a time").print(console, **TABLE_STYLE)
    idle = sum(not each.law.decides for each in found)
    enough = sum(len(each.rows) >= LEAST_ROWS for each in found)
    wrong = sum(not each.is_expected for each in found)
    said = f"{len(found)} laws, {idle} of them without a decision: {enough} are noticed by {LEAST_ROWS} rows or more"
    console.print(f"{said}; {wrong} unexpected")


def write_csv(rows: Sequence[Row], path: Path) -> None:
    """Write a line for each row, with six digits of each number; a missing number is an empty cell."""
    write_rows(path, [CSV_COLUMNS, *map(_cells, rows)])


def _cells(row: Row) -> tuple[object, ...]:
    check = row.check
    return (
        *(GROUPS[check.group], check.name, check.what, check.at, check.basis.evidence.name.lower(), check.basis.text),
        *map(_digits, (check.reference, row.value, check.band.low, check.band.high)),
        *(check.unit, verdict(row), reason(row), "; ".join(map(str, row.outside))),
    )


def _digits(value: float | None) -> float | None:
    return float(f"{value:.6g}") if value is not None and math.isfinite(value) else None
