"""The report of an optimisation, which `grind optimise --report` writes."""

from collections.abc import Mapping
from difflib import SequenceMatcher
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grind_env.data_table import Kind
from grind_env.machine.job import Job
from grind_env.render.curve_data import BLUE, GREY, INK
from grind_env.render.series_graphs import Graph, Series
from grind_env.shop.optimise import tables
from grind_env.shop.optimise.judgement import WORTH_NAMING, confidence_text
from grind_env.shop.optimise.result import LimitUse, Optimised, Verdict
from grind_env.shop.report import document
from grind_env.shop.report.provenance import foundations, revisions
from grind_env.shop.trials import lots_text

if TYPE_CHECKING:
    from markupsafe import Markup

LEVELS: Mapping[Verdict, Kind] = {
    Verdict.BETTER: "good",
    Verdict.NEARER: "poor",
    Verdict.NOT_BETTER: "poor",
    Verdict.UNTRIED: "poor",
    Verdict.INFEASIBLE: "bad",
}

TRADE = (
    "The cheapest programs tried of each time that keep limits and options, on the lots of the search; the star is the "
    "one that was judged."
)


def optimised_report(found: Optimised, job: Job, files: Mapping[str, Path]) -> str:
    """Return the page of an optimisation, HTML."""
    after = "after" if found.verdict.is_written else "best one tried"
    sections = [
        document.Section("Verdict", [document.paragraph(f"{tables.heading(found)}."), _verdict(found)]),
        document.Section("Before and after", [_quantities(found, after)]),
        document.Section("Words", [document.table(tables.word_table(found, after))]),
        document.Section("Limits", _limits(found, after)),
        document.Section("Cost over time", [document.figure(tables.trade(found), TRADE)]),
        document.Section("Program", _program(found)),
        document.Section("Remarks", [document.items(tables.sentences(found)[:-1])]),
        document.Section("What the numbers rest on", [document.items(_rests_on(found)), *foundations(job)]),
    ]
    return document.page(f"Optimised: {found.program}", sections, revisions(files))


def _verdict(found: Optimised) -> "Markup":
    cost = found.quantity("cost")
    saved = tables.negative(cost.difference)
    headline = (
        f"A part costs {saved:.3f} $ less, {100.0 * saved.value / cost.before.value:.1f} % of "
        f"{cost.before.value:.3f} $."
        if found.verdict is Verdict.BETTER
        else f"{found.verdict.value[0].upper()}{found.verdict.value[1:]}: {found.reason}."
    )
    bind = [f"{each.name} ({tables.binding(each)})" for each in found.limits if each.binds]
    priced = all(each.price is not None for each in found.limits if each.limit > 0.0)
    named = [f"Limits that bind: {', '.join(bind)}."] if bind else ["No limit binds."] if priced else []
    return document.verdict(LEVELS[found.verdict], headline, named)


def _quantities(found: Optimised, after: str) -> "Markup":
    caption = (
        f"Means over batches of {found.parts} {found.counted}s on {lots_text(found.lots, 'unseen lots')}, with the "
        f"{tables.covered(found)} interval for one machine. The columns of one run are as grind run prints."
    )
    return document.table(tables.quantity_table(found, after, whole=True), caption)


def _limits(found: Optimised, after: str) -> "list[Markup]":
    limits = [each for each in found.limits if each.limit > 0.0]
    if not limits:
        return [document.paragraph("The job has no limits.")]
    stay = confidence_text(found.confidence)
    caption = (
        f"Shares are those of the limit below which {stay} stay. The last column is how much the best words without "
        "the limit change the cost; a limit binds if, beyond chance, they save more than "
        f"{100.0 * WORTH_NAMING:g} % and are refused because of it."
    )
    shares = (
        f"Share of each limit below which {stay} stay, before (ring) and {after} (square); strokes are what is asked."
    )
    return [document.table(tables.limit_table(found, after), caption), document.figure(_shares(limits, after), shares)]


def _shares(limits: list[LimitUse], after: str) -> Graph:
    def shares(name: str, field: str, **look: Any) -> Series:
        values = [100.0 * getattr(each, field) for each in limits]
        return Series(name=name, x=values, y=range(len(limits)), **look)

    return Graph(
        x="% of the limit",
        y="",
        series=(
            shares("asked", "margin", color=INK, mark="|", size=18.0),
            shares("before", "before", color=GREY, size=8.0, hollow=True),
            shares(after, "after", color=BLUE, mark="s", size=5.0),
        ),
        rows=tuple(each.name for each in limits),
        height=110 + 34 * len(limits),
    )


def _program(found: Optimised) -> "list[Markup]":
    """Return the new text, with the old text of each changed line."""
    old, new = found.before.splitlines(), found.after.splitlines()
    notes: dict[int, list[document.Note]] = {}
    for kind, first, last, start, end in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if kind in ("replace", "insert"):
            for place in range(start, end):
                was = first + place - start
                notes[place + 1] = [document.Note(f"was: {old[was][: document.LONGEST_LINE]}" if was < last else "new")]
    state = "The new program:" if found.verdict.is_written else "The program, which stays as it is:"
    return [document.paragraph(state), *document.listing(new, notes)]


def _rests_on(found: Optimised) -> list[str]:
    known = f"its numbers are as uncertain as the calibration says ({found.calibration})."
    if found.plant:
        known = "it is known here, and all that is open are its lots."
    elif found.calibration is None:
        known = "nothing was calibrated, so that its numbers are as uncertain as those of the catalogue."
    table, ground = "[lots]" if found.lots > 1 else "[[parts]]", lots_text(found.lots, "unseen lots")
    return [
        f"The job is {found.job}. How its lots and parts differ is what its {table} says.",
        f"Both programs are ground on {ground}, the same for both, in batches of {found.parts} {found.counted}s, in "
        "which the wheel carries over.",
        f"Intervals are what one machine comes to with {tables.covered(found)}: {known}",
    ]
