"""The page on the validation of the process model, from the rows that `python -m grind_env.validation` prints."""

from collections.abc import Sequence
from itertools import groupby

from grind_env.data_table import Column, table_of
from grind_env.validation import GROUPS, Row, unfit_uses
from grind_env.validation.report import NUMBERS, beyond_limits, outside, reason, sources, totals, verdict
from grind_env.validation.rig import CONDITIONS

FILE, PICTURE, ROWS = "validation.md", "validation.png", "validation.csv"

INTRODUCTION = """\
Every number below comes from the functions that all simulations run, under the conditions in its row. The first word of
its source says what its band is worth: *measured*; *drawn* from data or tables that were seen; *remembered*, not looked
up; *own*, what this project expects. Where two published numbers exclude each other, the row names the one that was
chosen. The rows are also [a CSV file](validation.csv); papers and data stand with their DOI, where one was
seen, among [the sources](process/index.md#sources).

Two limits concern heat. The **temperature limit** of a part (the rise that tempers its material) decides whether it is
scrap. The **burn ratio**, specific energy over Malkin's threshold, is a warning margin and scraps nothing."""


def _verdict(row: Row) -> str:
    said = ": ".join(filter(None, (verdict(row) if row.passed else f"**{verdict(row)}**", reason(row))))
    return "; ".join(filter(None, (said, outside(row))))


COLUMNS = (
    Column("what", "check.what"),
    Column("at", "check.at"),
    *NUMBERS,
    Column("from", "check.basis"),
    Column("", _verdict),
)


def validation_page(rows: Sequence[Row], caption: str = "") -> str:
    """Return the page, Markdown; `caption` is that of the picture beside it (`plot_series`), "" without one."""
    lines = ["# Validation of the process model", f"**{sources(rows)}** {totals(rows)}. {beyond_limits(rows)}"]
    lines += [INTRODUCTION, CONDITIONS]
    lines += [
        "## What the model must not be used for",
        "\n".join(f"- {use}: {why}." for use, why in unfit_uses().items()),
    ]
    if caption:
        lines += ["## Published series beside the model", f"![published series over the model]({PICTURE})", caption]
    for group, members in groupby(rows, lambda row: row.check.group):
        lines += [f"## {group}. {GROUPS[group]}", table_of(COLUMNS, members).markdown()]
    return "\n\n".join(lines) + "\n"
