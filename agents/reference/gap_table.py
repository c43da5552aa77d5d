"""The tables of gaps: for a terminal, as a page, and as a CSV file."""

from collections.abc import Callable, Sequence
from dataclasses import fields

from agents.benchmark.page import table
from agents.benchmark.summary import NONE
from agents.commands.asked import Asked
from agents.evaluations import Evaluations, by_problem, chunks, run_chunk
from agents.reference.gaps import ADAPTING_D, ADAPTING_E, BEST, FIXED, KNOWN, PLANNER, ROLES, Gap, TaskGaps, task_gaps
from agents.reference.promises import PROMISES
from agents.reference.scores import tune_missing
from agents.reference.table import flat, spread_names
from agents.study import Found, Study
from agents.tuning.rules import tunable
from grind_env.policies.registry import ABLATIONS, policy_names
from grind_env.policies.statistics import Interval

VERDICTS = ("promise", "held", "by", "not by")


def study(asked: Asked) -> Study:
    """Tune what has not been tuned, and return the study."""

    def gaps(found: Found) -> list[TaskGaps]:
        return [task_gaps(problem, runs, asked.configs) for problem, runs in by_problem(found).items()]

    def prepare() -> None:
        for problem in asked.problems:
            tune_missing(problem, [*tunable(problem.simulation()), *ABLATIONS], asked.configs, asked.options)

    return Evaluations(
        name="gaps",
        title="Gaps",
        trials=[
            chunk
            for problem in asked.problems
            for name in (*ABLATIONS, *policy_names(problem.simulation()))
            for chunk in chunks(problem, name, asked.episodes, configs=asked.configs)
        ],
        run=run_chunk,
        prepare=prepare,
        columns=[
            "task",
            *(n for f in fields(Gap) for n in (spread_names(f.name) if f.type is Interval else [f.name])),
            "reference_cost",
        ],
        rows=lambda found: [
            (each.task, *flat(gap), each.reference_cost) for each in gaps(found) for gap in each.gaps.values()
        ],
        page=lambda found: page(gaps(found), asked.episodes),
        episodes=asked.episodes,
        trains=False,
    )


def page(tasks: Sequence[TaskGaps], episodes: int) -> str:
    """The tables and the promises as Markdown."""
    lines = [
        "Written by `python -m agents gaps`: what it is worth to adapt E (the reciprocation feedrate), D (the dress"
        f" executions) or both, on {episodes} evaluation episodes, the same for all policies; ± is half a 95 % interval"
        " of a paired bootstrap over episodes.",
    ]
    for title, headings, rows in tables(tasks):
        lines += ["", f"{title}:", "", table(headings, rows)]
    lines += ["", "What the tasks are to hold:", "", table(VERDICTS, verdicts(tasks), left=len(VERDICTS))]
    return "\n".join(lines)


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
