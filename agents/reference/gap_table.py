"""The tables of gaps: for a terminal, as a page, and as a CSV file."""

import io
from collections.abc import Callable, Sequence
from csv import writer
from dataclasses import fields
from pathlib import Path

from rich.table import Table

from agents.benchmark.page import table
from agents.benchmark.summary import NONE
from agents.provenance import provenance
from agents.reference.gaps import ADAPTING_D, ADAPTING_E, BEST, FIXED, KNOWN, PLANNER, ROLES, Gap, TaskGaps
from agents.reference.promises import PROMISES
from agents.reference.table import flat, spread_names
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.statistics import Interval
from grind_env.policies.tuned import write_whole

TABLE, PAGE = "gaps.csv", "gaps.md"
BEGINS = {TABLE: "task,what,policy,", PAGE: "# Gaps"}
VERDICTS = ("promise", "held", "by", "not by")


def write_gaps(tasks: Sequence[TaskGaps], episodes: int, folder: Path) -> None:
    """Write `gaps.csv` and `gaps.md`, each whole or not at all."""
    write_whole(folder / TABLE, csv_text(tasks, episodes))
    write_whole(folder / PAGE, page(tasks, episodes))


def rich_tables(tasks: Sequence[TaskGaps]) -> list[Table]:
    """The tables for a terminal."""
    found = [*tables(tasks), ("What the tasks are to hold", VERDICTS, verdicts(tasks))]
    return [rich_table(*each) for each in found]


def rich_table(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    """One of them."""
    made = Table(title=title)
    for heading in headings:
        made.add_column(heading)
    for row in rows:
        made.add_row(*row)
    return made


def page(tasks: Sequence[TaskGaps], episodes: int) -> str:
    """The tables and the promises as Markdown."""
    lines = [
        "# Gaps",
        "",
        "Written by `python -m agents gaps`: what it is worth to adapt E (the reciprocation feedrate), D (the dress"
        f" executions) or both, on {episodes} evaluation episodes, the same for all policies; ± is half a 95 % interval"
        " of a paired bootstrap over episodes.",
    ]
    for title, headings, rows in tables(tasks):
        lines += ["", f"{title}:", "", table(headings, rows)]
    lines += ["", "What the tasks are to hold:", "", table(VERDICTS, verdicts(tasks), left=len(VERDICTS))]
    return "\n".join([*lines, ""])


def verdicts(tasks: Sequence[TaskGaps]) -> list[list[str]]:
    """A row for each promise, under `VERDICTS`."""
    found = [(each.text, each.verdict(tasks)) for each in PROMISES]
    return [[text, "yes" if held else "no", by, but] for text, (held, by, but) in found]


def tables(tasks: Sequence[TaskGaps]) -> list[tuple[str, Sequence[str], list[list[str]]]]:
    """Title, headings and rows of the tables."""

    def cell(of: TaskGaps, what: str, text: Callable[[Gap], str]) -> str:
        return text(of.gaps[what]) if what in of.gaps else NONE

    def score(gap: Gap) -> str:
        return spread(gap.score, 1)

    costs = [
        [
            each.task,
            *(cell(each, what, lambda gap: spread(gap.cost, 3)) for what in ROLES),
            f"{each.reference_cost:g} ({each.off:+.1f} %)",
        ]
        for each in tasks
    ]
    savings = [
        [
            each.task,
            each.gaps[FIXED].policy,
            *(cell(each, what, lambda gap: spread(gap.saving, 1)) for what in (*ROLES[1:], ADAPTING_E, ADAPTING_D)),
        ]
        for each in tasks
    ]
    scores = [
        [
            each.task,
            each.gaps[BEST].policy,
            *(cell(each, what, score) for what in ROLES[1:-1]),
        ]
        for each in tasks
    ]
    return [
        ("Cost, $ per block", ("task", *ROLES, "reference cost"), costs),
        (
            "Saving, % of the mean cost of an episode: on the best fixed plan; by adapting E, on D alone; by adapting"
            " D, on E alone",
            ("task", FIXED, *ROLES[1:], ADAPTING_E, ADAPTING_D),
            savings,
        ),
        ("Score: 0 is the best fixed plan, 100 hindsight", ("task", BEST, *ROLES[1:-1]), scores),
        (
            "What measuring would be worth: score of the best rule on what is measured, and of the rule on the state"
            " that knows before every block how dull the wheel is, how fast the lot dulls it (growth), which Ra wheel"
            " and part give, or all",
            ("task", BEST, *KNOWN, PLANNER),
            [[each.task, *(cell(each, what, score) for what in (BEST, *KNOWN, PLANNER))] for each in tasks],
        ),
    ]


def spread(value: Interval, digits: int) -> str:
    """A value and half its interval."""
    return f"{value.value:.{digits}f} ± {value.half_width:.{digits}f}"


def csv_text(tasks: Sequence[TaskGaps], episodes: int) -> str:
    """All numbers in full, with seeds and versions in every row."""
    facts = provenance(episode_seeds("evaluation", episodes))
    kept = [name for name in facts if name not in ("stable_baselines3", "torch")]
    columns = [
        name for each in fields(Gap) for name in (spread_names(each.name) if each.type is Interval else [each.name])
    ]
    text = io.StringIO()
    lines = writer(text, lineterminator="\n")
    lines.writerow(["task", *columns, "reference_cost", *kept])
    for each in tasks:
        for gap in each.gaps.values():
            lines.writerow([each.task, *flat(gap), each.reference_cost, *(facts[name] for name in kept)])
    return text.getvalue()
