"""Gaps of a task: the gain from adapting E, D or both, and the gain still possible."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.evaluations import Evaluations, by_problem, chunks
from agents.reference.score_study import tune_missing
from agents.reference.table import best_plan, flat, spread_names
from agents.study import Found, Study, StudyOptions
from grind_env.array_types import Array
from grind_env.data_table import NONE, Column, Table, table_of
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.policy import Sees
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.registry import ABLATIONS, REFERENCE, make_policy, policy_names
from grind_env.policies.score_statistics import Interval, bootstrap

#: compared policies: the best plan without sensors; the adaptive rule for one decision, and for both; the cheapest
#: scripted policy on measurements; the planner that knows the state; the planner that knows the future
FIXED, SPEED, DRESS, BOTH, BEST, PLANNER, HINDSIGHT = ROLES = (
    "fixed plan",
    "E alone",
    "D alone",
    "both",
    "best rule",
    "planner",
    "hindsight",
)
#: knowledge of the rule on the state before a block: the dullness of the wheel, alone, with the dulling rate of the
#: lot, or with the Ra of wheel and part; or all
DULLNESS, GROWTH, ROUGHNESS, STATE = KNOWN = ("dullness", "dullness, growth", "dullness, Ra", "full state")
ADAPTING_E, ADAPTING_D = "adapting E", "adapting D"
AGAINST = {ADAPTING_E: DRESS, ADAPTING_D: SPEED}  #: role from which a saving is counted, if not from the fixed plan
DOES = {ADAPTING_E: BOTH, ADAPTING_D: BOTH}  #: role that saves, for savings whose name is not a role


@dataclass(frozen=True, slots=True)
class Gap:
    """Cost of one policy in a task, and its saving over another in the same episodes."""

    what: str
    policy: str
    sees: Sees
    cost: Interval  #: cost per step of the best fixed plan, $, with the terminal cost, like `reference_cost`
    against: str  #: policy from which the saving is counted
    saving: Interval  #: saving of the mean cost of an episode, %
    score: Interval  #: score: 0 is the best fixed plan, 100 hindsight


@dataclass(frozen=True, slots=True)
class TaskGaps:
    """All gaps of a task, by role, saving or knowledge."""

    task: str
    reference_cost: float
    gaps: Mapping[str, Gap]

    @property
    def off(self) -> float:
        """Reference cost over the measured cost of the best fixed plan, minus one, %."""
        return 100.0 * (self.reference_cost / self.gaps[FIXED].cost.value - 1.0)


def task_gaps(problem: Problem, found: Mapping[str, Evaluation], configs: Path | None = None) -> TaskGaps:
    """Return the gaps of a task, from the evaluations of its policies on the same episodes."""
    simulation = problem.simulation()
    sees = {name: make_policy(name, simulation, configs).sees for name in found}
    rules = [name for name in found if sees[name] == "measurements"]
    policies = {
        FIXED: best_plan(found),
        SPEED: "adaptive_speed",
        DRESS: "adaptive_dress",
        BOTH: "adaptive_rule",
        BEST: min(rules, key=lambda name: float(found[name].cost.mean())),
        PLANNER: "mpc",
        HINDSIGHT: REFERENCE,
        DULLNESS: "dullness_rule",
        GROWTH: "growth_rule",
        ROUGHNESS: "roughness_rule",
        STATE: "full_state_rule",
    }
    fixed, hindsight = found[policies[FIXED]], found[REFERENCE]
    steps = fixed.speeds.shape[1]
    gaps = {}
    for what in (*ROLES, ADAPTING_E, ADAPTING_D, *KNOWN):
        policy, against = policies[DOES.get(what, what)], policies[AGAINST.get(what, FIXED)]
        if policy in found:
            run = found[policy]
            gaps[what] = Gap(
                what=what,
                policy=policy,
                sees=sees[policy],
                cost=bootstrap(mean, run.cost / steps),
                against=against,
                saving=bootstrap(saving, run.cost, found[against].cost),
                score=run.score(fixed, hindsight),
            )
    return TaskGaps(problem.name, simulation.task.reference_cost, gaps)


def mean(cost: Array) -> Array:
    """Return the mean along the last axis."""
    return np.asarray(cost.mean(axis=-1))


def saving(cost: Array, against: Array) -> Array:
    """Return the saving of the mean cost over another cost, %, along the last axis."""
    return np.asarray(100.0 * (1.0 - cost.mean(axis=-1) / against.mean(axis=-1)))


class Promise(NamedTuple):
    """Promise of the tasks: a bound on a figure, in all tasks that have the figure or in `least` of these tasks."""

    text: str
    figure: Callable[[TaskGaps], float | None]
    unit: str
    kept: Callable[[float], bool]
    least: int | None = None

    def verdict(self, tasks: Iterable[TaskGaps]) -> tuple[bool, str, str]:
        """Return whether the promise holds, the tasks that keep the promise and the other tasks, with figures."""
        of = {each.task: figure for each in tasks if (figure := self.figure(each)) is not None}
        keep = {task: figure for task, figure in of.items() if self.kept(figure)}
        held = len(keep) == len(of) if self.least is None else len(keep) >= self.least
        broken = {task: figure for task, figure in of.items() if task not in keep}
        return held, self._listed(keep), self._listed(broken)

    def _listed(self, figures: Mapping[str, float]) -> str:
        return ", ".join(f"{task} {figure:.3g}{self.unit}" for task, figure in figures.items()) or NONE


def _saved(what: str) -> Callable[[TaskGaps], float | None]:
    """Return a function from the gaps of a task to a saving, %; None for a task without it."""

    def figure(found: TaskGaps) -> float | None:
        return found.gaps[what].saving.value if what in found.gaps else None

    return figure


PROMISES = (
    Promise(
        "the planner saves 15 % on the best fixed plan in every task",
        _saved(PLANNER),
        " %",
        lambda saving: saving >= 15.0,
    ),
    Promise("adapting E saves 8 % in three tasks", _saved(ADAPTING_E), " %", lambda saving: saving >= 8.0, least=3),
    Promise("adapting D saves 10 % in four tasks", _saved(ADAPTING_D), " %", lambda saving: saving >= 10.0, least=4),
    Promise(
        "no rule on measurements comes within 3 points of hindsight",
        lambda found: found.gaps[BEST].score.value,
        "",
        lambda score: score <= 97.0,
    ),
    Promise(
        "the reference cost is within 1 % of that of the best fixed plan",
        lambda found: found.off,
        " %",
        lambda off: abs(off) <= 1.0,
    ),
)

VERDICTS = ("promise", "holds", "on", "not on")


def study(asked: StudyOptions) -> Study:
    """Return the study, which first tunes policies that have not been tuned."""

    def gaps(found: Found) -> list[TaskGaps]:
        return [task_gaps(problem, runs, asked.configs) for problem, runs in by_problem(found).items()]

    return Evaluations(
        name="gaps",
        title="Gaps",
        trials=chunks(asked, lambda problem: [*ABLATIONS, *policy_names(problem.simulation())]),
        prepare=partial(tune_missing, asked, ABLATIONS),
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
    """Return the tables and the promises as Markdown."""
    lines = [
        f"`python -m agents gaps`: what adapting E (table speed), D (dresses) or both saves, on {episodes} evaluation"
        " episodes, the same for all policies. ± is half a 95 % interval of a paired bootstrap over episodes.",
    ]
    for shown in tables(tasks):
        lines += ["", f"{shown.title}:", "", shown.markdown()]
    lines += ["", "Promises of the tasks:", "", table_of(VERDICTS, verdicts(tasks)).markdown()]
    return "\n".join(lines)


def verdicts(tasks: Sequence[TaskGaps]) -> list[list[str]]:
    """Return a row for each promise, under `VERDICTS`."""
    found = [(each.text, each.verdict(tasks)) for each in PROMISES]
    return [[text, "yes" if held else "no", by, but] for text, (held, by, but) in found]


def tables(tasks: Sequence[TaskGaps]) -> list[Table]:
    """Return the tables, each with its title."""

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
        "Saving, % of the mean cost of an episode. *Adapting E*: both against D alone; *adapting D*: both against E"
        " alone; all others against the best fixed plan": savings,
        "Score: 0 is the best fixed plan, 100 hindsight": scores,
        "What more measurements are worth: score of the best rule on measurements, and of a rule that also knows how"
        " dull the wheel is (dullness), how fast the lot dulls it (growth), which Ra wheel and part give, or the full"
        " state": known,
    }
    return [table_of(columns, tasks, title) for title, columns in titles.items()]
