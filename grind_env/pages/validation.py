"""The page on the validation of the process model, from the rows that `python -m grind_env.validation` prints."""

from collections.abc import Sequence
from itertools import groupby

from grind_env.pages.markdown import table
from grind_env.validation import GROUPS, Row, unfit_uses
from grind_env.validation.neighbours import Step
from grind_env.validation.report import (
    PREDICTION,
    PREDICTION_NOTE,
    STEP,
    STEP_TITLE,
    comparison,
    expected,
    failing,
    number,
    prediction_cells,
    reason,
    totals,
    verdict,
)
from grind_env.validation.rig import CONDITIONS
from grind_env.validation.valve_alloys import Prediction

FILE, PICTURE = "validation.md", "validation.png"

INTRODUCTION = """\
Every number below is taken by the functions that all simulations run, under the conditions beside it. A band without a
source is what this project expects of the trend. Where two published numbers exclude each other, the row says which was
chosen.

Two limits speak of heat. The **temperature limit** of a part (the rise that tempers its material) decides whether it is
scrap. The **burn ratio**, specific energy over Malkin's threshold, is a warning margin and scraps nothing."""


def validation_page(
    rows: Sequence[Row], predicted: Sequence[Prediction], steps: Sequence[Step], picture: str = ""
) -> str:
    """The page, Markdown.

    Args:
        rows: of `validate`.
        predicted: of `predictions`.
        steps: of `neighbours`.
        picture: the file of `plot_exponents` beside the page; none if "".
    """
    lines = ["# Validation of the process model", INTRODUCTION, CONDITIONS, f"**{totals(rows)}.**"]
    lines += [
        "## What the model must not be used for",
        "\n".join(f"- {use}: {why}." for use, why in unfit_uses().items()),
    ]
    if picture:
        lines.append(f"![measured exponents beside those of the model]({picture})")
    for group, members in groupby(rows, lambda row: row.check.group):
        lines += [f"## {group}. {GROUPS[group]}", _rows(list(members))]
    cells = [prediction_cells(each) for each in predicted]
    note = f"{PREDICTION_NOTE} {comparison(predicted)}"
    lines += ["## Valve alloys: one predicted from the other", note, table(PREDICTION, cells)]
    lines += [f"## {STEP_TITLE}", table(STEP, [(step.change, failing(step)) for step in steps])]
    return "\n\n".join(lines) + "\n"


def _rows(rows: list[Row]) -> str:
    header = ("what", "at", "model", "band (measured)", "unit", "from", "")
    return table(
        header,
        [
            (
                row.check.what,
                row.check.at,
                number(row.value),
                expected(row),
                row.check.unit,
                row.check.source,
                ": ".join(filter(None, (verdict(row) if row.passed else f"**{verdict(row)}**", reason(row)))),
            )
            for row in rows
        ],
    )
