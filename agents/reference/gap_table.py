"""The tables of gaps: for a terminal, as a page, and as a CSV file."""

from collections.abc import Sequence
from dataclasses import fields

from agents.evaluations import Evaluations, by_problem, chunks, run_chunk
from agents.reference.gaps import ADAPTING_D, ADAPTING_E, BEST, FIXED, KNOWN, PLANNER, ROLES, Gap, TaskGaps, task_gaps
from agents.reference.promises import PROMISES
from agents.reference.scores import tune_missing
from agents.reference.table import flat, spread_names
from agents.study import Found, Study, StudyOptions
from agents.tuning.rules import tunable
from grind_env.policies.registry import ABLATIONS, policy_names
from grind_env.policies.statistics import Interval
from grind_env.table import Column, Table, table_of

VERDICTS = ("promise", "held", "by", "not by")


def study(asked: StudyOptions) -> Study:
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
    for shown in tables(tasks):
        lines += ["", f"{shown.title}:", "", shown.markdown()]
    lines += ["", "What the tasks are to hold:", "", table_of(VERDICTS, verdicts(tasks)).markdown()]
    return "\n".join(lines)


def verdicts(tasks: Sequence[TaskGaps]) -> list[list[str]]:
    """A row for each promise, under `VERDICTS`."""
    found = [(each.text, each.verdict(tasks)) for each in PROMISES]
    return [[text, "yes" if held else "no", by, but] for text, (held, by, but) in found]


def tables(tasks: Sequence[TaskGaps]) -> list[Table]:
    """The tables, each with its title."""

    def gap(what: str, field: str, form: str) -> Column:
        return Column(what, lambda each: getattr(each.gaps.get(what), field, None), form, right=True)

    def policy(what: str) -> Column:
        return Column(what, lambda each: each.gaps[what].policy, right=True)

    task = Column("task", "task")
    reference = Column("reference cost", lambda each: f"{each.reference_cost:g} ({each.off:+.1f} %)", right=True)
    costs = (task, *(gap(what, "cost", "±.3f") for what in ROLES), reference)
    savings = (task, policy(FIXED), *(gap(what, "saving", "±.1f") for what in (*ROLES[1:], ADAPTING_E, ADAPTING_D)))
    scores = (task, policy(BEST), *(gap(what, "score", "±.1f") for what in ROLES[1:-1]))
    known = (task, *(gap(what, "score", "±.1f") for what in (BEST, *KNOWN, PLANNER)))
    titles = {
        "Cost, $ per block": costs,
        "Saving, % of the mean cost of an episode: on the best fixed plan; by adapting E, on D alone; by adapting D, on"
        " E alone": savings,
        "Score: 0 is the best fixed plan, 100 hindsight": scores,
        "What measuring would be worth: score of the best rule on what is measured, and of the rule on the state that"
        " knows before every block how dull the wheel is, how fast the lot dulls it (growth), which Ra wheel and part"
        " give, or all": known,
    }
    return [table_of(columns, tasks, title) for title, columns in titles.items()]
