"""The table of the checks in the terminal."""

import math
from collections.abc import Sequence
from itertools import groupby

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from grind_env.validation import GROUPS, Row, is_as_known, known_failures, unfit_uses
from grind_env.validation.neighbours import Step
from grind_env.validation.rig import CONDITIONS
from grind_env.validation.valve_alloys import Prediction

PREDICTION = ("wheel", "response", "alloy predicted", "level only", "power law", "model, rate fitted", "model")
STEP = ("instead of the usual", "rows of groups 1 to 9 that pass no more (band)")
STEP_TITLE = "A step away from the usual conditions"
PREDICTION_NOTE = (
    "Root mean square error of eight runs, %; the centre run gives the level. Power law: exponents on rate and volume "
    "fitted on the other alloy. Model, rate fitted: that exponent on rate, the course over volume by the model. "
    "Model: its own constants of INC751."
)


def number(value: float) -> str:
    """A number in three digits; a dash where there is none."""
    return "-" if math.isnan(value) else f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"


def verdict(row: Row) -> str:
    """What becomes of a row, in a word or two."""
    if is_as_known(row):
        return "pass" if row.passed else "known to fail"
    return "passes, though known to fail" if row.passed else "FAILS"


def reason(row: Row) -> str:
    """Why a row has no number, or fails; "" without a reason."""
    return ". ".join(filter(None, (row.missing, known_failures().get(row.check.name, ""))))


def expected(row: Row) -> str:
    """The band, and what was measured."""
    measured = "" if row.check.measured is None else f" ({number(row.check.measured)})"
    return f"{row.check.band}{measured}"


def totals(rows: Sequence[Row]) -> str:
    """How many pass and fail, in one line."""
    passed = sum(row.passed for row in rows)
    known = sum(not row.passed and is_as_known(row) for row in rows)
    wrong = sum(not is_as_known(row) for row in rows)
    return f"{len(rows)} rows: {passed} pass, {known} known to fail, {wrong} not as known"


def comparison(predicted: Sequence[Prediction]) -> str:
    """How the model's course over volume does beside a plain power law, in one sentence."""
    better = sum(each.model_fitted < each.power_law for each in predicted)
    return f"The course by the model is nearer than the power law in {better} of {len(predicted)} predictions."


def prediction_cells(each: Prediction) -> tuple[str, ...]:
    """A prediction as texts, by `PREDICTION`."""
    errors = (each.level, each.power_law, each.model_fitted, each.model)
    return each.wheel, each.response, each.alloy, *(number(error) for error in errors)


def failing(step: Step) -> str:
    """What fails a step away from the usual conditions, with its numbers."""
    return "; ".join(f"{row.check.name} {number(row.value)} ({row.check.band})" for row in step.failing) or "-"


def print_report(rows: Sequence[Row], predicted: Sequence[Prediction], steps: Sequence[Step], console: Console) -> None:
    """Print rows by group, predictions of the valve alloys, what fails a step away, and what the model is not for."""
    console.print(CONDITIONS)
    console.print()
    for group, members in groupby(rows, lambda row: row.check.group):
        table = Table(
            "what", "at", "model", "band (measured)", "unit", "from", "", box=box.SIMPLE, title_justify="left"
        )
        table.title = f"{group}. {GROUPS[group]}"
        for row in members:
            style = "" if row.passed else "yellow" if is_as_known(row) else "red"
            cells = (row.check.what, row.check.at, number(row.value), expected(row), row.check.unit, row.check.source)
            table.add_row(*map(Text, cells), Text("\n".join(filter(None, (verdict(row), reason(row))))), style=style)
        console.print(table)
    if predicted:
        table = Table(
            *PREDICTION, box=box.SIMPLE, title="Valve alloys: one predicted from the other", title_justify="left"
        )
        for each in predicted:
            table.add_row(*prediction_cells(each))
        console.print(table)
        console.print(PREDICTION_NOTE)
        console.print(comparison(predicted))
        console.print()
    if steps:
        table = Table(*STEP, box=box.SIMPLE, title=STEP_TITLE, title_justify="left")
        for step in steps:
            table.add_row(step.change, failing(step))
        console.print(table)
    console.print(Text("The model must not be used for", "bold"))
    for use, why in unfit_uses().items():
        console.print(f"- {use}: {why}.")
    console.print()
    console.print(totals(rows))
