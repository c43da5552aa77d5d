"""The table of the checks in the terminal."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby

from rich import box
from rich.console import Console
from rich.text import Text

from grind_env.table import Cell, Column, table_of
from grind_env.validation import GROUPS, Evidence, Row, is_as_known, known_failures, unfit_uses
from grind_env.validation.leave_out import (
    CONSTANT,
    MODEL,
    POWER_LAW,
    PREDICTORS,
    WEAR_KNOWN,
    Error,
    LeftOut,
    difference,
    mean_errors,
)
from grind_env.validation.neighbours import Neighbour
from grind_env.validation.rig import CONDITIONS, USUAL

WIDTH = 120
"""Characters of the longest line."""

PREDICTION = tuple(Column(title, wrap=True) for title in ("wheel", "response", "left out", *PREDICTORS))
PREDICTION_TITLE = "Valve alloys: each left out and predicted from the other"
PREDICTION_NOTE = (
    "Errors of nine runs, %: of their mean (level) / of each beside that mean (course, root mean square). Constant, "
    "power law and model are fitted to the other alloy (1, 3, and 2 constants of wear, 1 of Ra) and know nothing of "
    "the one left out, so that their level is one and the same. "
    f"{WEAR_KNOWN.capitalize()}: told how fast the left-out alloy wears the wheel, not what Ra it has. As shipped: the "
    "entry of the catalogue, whose slope of wear was fitted to INC751; its level supposes units that the data do not "
    "state."
)
STEP_TITLE = "A step away from the usual conditions"


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


def _described(row: Row) -> Cell:
    """The number, its conditions, where its band is from, and what else is to be said of the row; a line each."""
    why = f"why: {reason(row)}" if reason(row) else ""
    said = "\n".join(filter(None, (row.check.at, str(row.check.basis), why, outside(row))))
    return Cell(row.check.what, "" if row.passed else "poor" if is_as_known(row) else "bad", said)


def outside(row: Row) -> str:
    """What the conditions ask beyond the limits of the catalogue; "" if nothing."""
    return f"outside the catalogue: {'; '.join(map(str, row.outside))}" if row.outside else ""


def expected(row: Row) -> str:
    """The band, and the number that was measured, published or remembered."""
    reference = "" if row.check.reference is None else f" ({number(row.check.reference)})"
    return f"{row.check.band}{reference}"


NUMBERS = (
    Column("model", lambda row: number(row.value), wrap=True),
    Column("band (reference)", expected, wrap=True),
    Column("unit", "check.unit", wrap=True),
)
COLUMNS = (Column("what, at, from", _described, wrap=True), *NUMBERS, Column("", verdict, wrap=True))
LOOK = {"box": box.SIMPLE, "show_edge": True, "pad_edge": True, "padding": (0, 1)}


def sources(rows: Sequence[Row]) -> str:
    """How many rows have what behind them, in one sentence."""
    counts = Counter(row.check.basis.evidence for row in rows)
    first, *others = Evidence
    listed = ", ".join(f"{counts[kind]} {kind.value}" for kind in others)
    return f"{len(rows)} rows: {counts[first]} carry {first.value}, {listed}."


def beyond_limits(rows: Sequence[Row]) -> str:
    """How many rows lie beyond the catalogue, in one sentence."""
    count = sum(bool(row.outside) for row in rows)
    return f"{count} rows are taken outside the limits that the catalogue states of wheel or machine; each says which."


def totals(rows: Sequence[Row]) -> str:
    """How many pass and fail, in one line."""
    passed = sum(row.passed for row in rows)
    known = sum(not row.passed and is_as_known(row) for row in rows)
    wrong = sum(not is_as_known(row) for row in rows)
    return f"{len(rows)} rows: {passed} pass, {known} known to fail, {wrong} not as known"


def prediction_rows(predicted: Sequence[LeftOut]) -> list[tuple[str, ...]]:
    """The predictions as texts, by `PREDICTION`, and their means by response."""
    rows = [(each.wheel, each.response, each.alloy, *_errors(each.errors)) for each in predicted]
    return rows + [("mean", response, "", *_errors(mean_errors(each))) for response, each in _by_response(predicted)]


def _errors(errors: Mapping[str, Error]) -> list[str]:
    return [f"{errors[name].level:.0f} / {errors[name].course:.0f}" if name in errors else "-" for name in PREDICTORS]


def _by_response(predicted: Sequence[LeftOut]) -> list[tuple[str, list[LeftOut]]]:
    responses = dict.fromkeys(each.response for each in predicted)
    return [(response, [each for each in predicted if each.response == response]) for response in responses]


def comparison(predicted: Sequence[LeftOut]) -> list[str]:
    """What wins on the mean, a sentence for level and course of each response."""
    return [sentence for response, each in _by_response(predicted) for sentence in _judged(response, each)]


def _judged(response: str, each: Sequence[LeftOut]) -> list[str]:
    means = mean_errors(each)
    level = f"Level of {response}: {means[MODEL].level:.1f} % by whatever is fitted to the other alloy"
    if WEAR_KNOWN in means:
        level += f", {means[WEAR_KNOWN].level:.1f} % by the model that knows the wear"
    course = ", ".join(f"{name} {means[name].course:.1f} %" for name in (CONSTANT, POWER_LAW, MODEL))
    compared = "; ".join(_compared(each, other) for other in (POWER_LAW, CONSTANT))
    return [f"{level}.", f"Course of {response}: {course}. {compared}."]


def _compared(each: Sequence[LeftOut], other: str) -> str:
    less, uncertain = difference(each, MODEL, other)
    won = "neither wins" if abs(less) < 2.0 * uncertain else "the model wins" if less < 0.0 else f"the {other} wins"
    return f"Model less {other} {less:+.1f} +- {uncertain:.1f} %: {won}"


def step_introduction(steps: Sequence[Neighbour]) -> str:
    """What the steps are, and how many rows they move out of their bands, in words."""
    moved = {row.check.name for step in steps for row in step.failing}
    kept = sum(not step.failing for step in steps)
    return (
        f"The {max((len(step.rows) for step in steps), default=0)} rows of groups 1 to 9 that pass are taken again, "
        "with one thing other than usual where the row does not set it itself. A band that holds under the usual "
        f"conditions alone is a number of these, and no law. {len(moved)} rows leave their band in some step; {kept} "
        f"of {len(steps)} steps move none."
    )


def step_sentence(step: Neighbour) -> str:
    """What a step does, in words."""
    beyond = f" (outside the catalogue: {'; '.join(map(str, step.outside))})" if step.outside else ""
    where = f"With {step.change}{beyond}"
    if not step.failing:
        return f"{where} all {len(step.rows)} rows stay in their bands."
    count = len(step.failing)
    leave = "leaves its band" if count == 1 else "leave their bands"
    return f"{where} {count} of {len(step.rows)} rows {leave}: {'; '.join(map(_moved, step.failing))}."


def _moved(row: Row) -> str:
    at = row.check.at.removeprefix(USUAL).removeprefix("; ")
    return f"{row.check.what}{at and f' ({at})'} is {row.value:.4g}, not {row.check.band}"


def print_report(
    rows: Sequence[Row], predicted: Sequence[LeftOut], steps: Sequence[Neighbour], console: Console
) -> None:
    """Print rows by group, predictions of the valve alloys, what fails a step away, and what the model is not for."""
    console.print(sources(rows))
    console.print(beyond_limits(rows))
    console.print(CONDITIONS)
    console.print()
    for group, members in groupby(rows, lambda row: row.check.group):
        table_of(COLUMNS, members, f"{group}. {GROUPS[group]}").print(console, **LOOK)
    if predicted:
        table_of(PREDICTION, prediction_rows(predicted), PREDICTION_TITLE).print(console, **LOOK)
        for sentence in (PREDICTION_NOTE, *comparison(predicted)):
            console.print(sentence)
        console.print()
    if steps:
        console.print(Text(STEP_TITLE, "bold"))
        console.print(step_introduction(steps))
        for step in steps:
            console.print(f"- {step_sentence(step)}")
        console.print()
    console.print(Text("The model must not be used for", "bold"))
    for use, why in unfit_uses().items():
        console.print(f"- {use}: {why}.")
    console.print()
    console.print(totals(rows))
