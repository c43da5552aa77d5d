"""Summaries of the policies of a task, one line per policy, over its training runs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agents.benchmark.plan import LIMIT
from agents.benchmark.results import INTERPOLATION, PLANTS, Result
from agents.benchmark.scoring import Sampled, is_ratio, over_runs, sampled
from grind_env.data_table import NONE, Column, Table, table_of
from grind_env.envs.task_names import CORE
from grind_env.policies.score_statistics import Interval

#: information that policies see, from least to most; the order of the table
KNOWLEDGE = ("measurements", "state", "future")
UNTRAINED = ("scripted", "planner")
KINDS = (*UNTRAINED, "learned")  #: kinds of policies in the results
ON_SCREEN = 8  #: number of columns that fit on a terminal
MEANS = ("blocks", "decision_ms", "train_seconds")  #: columns of results whose mean over the runs is in a line


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicySummary:
    """One line of a table: means over the runs of a policy; unknown values are None."""

    policy: str
    kind: str
    sees: str
    model: str | None
    runs: int
    cost: Interval  #: cost per good part, $
    scrap: float
    score: Interval | None
    ratio: Interval | None  #: ratio of the cost to the cost of the best fixed plan
    over: Interval | None  #: points over the best rule or planner with the same inputs, paired
    #: score in the split `interpolation`; the next field is the cost ratio in this split
    interpolation_score: Interval | None
    interpolation_ratio: Interval | None
    plants_cost: Interval | None  #: cost per good part on held-out machines, $
    plants_scrap: float | None
    blocks: float | None
    decision_ms: float | None
    train_seconds: float | None


def budget(blocks: float | None) -> str:
    """Return the budget class for a number of blocks of training or tuning; one rollout beyond the limit is allowed."""
    return NONE if blocks is None else "1M" if blocks < 1.02 * LIMIT else "open"


def shown(interval: Interval | None, ratio: bool, form: str = "") -> str:
    """Return a score, or a ratio of costs, with its interval as text; the form `±` gives half the length."""
    if interval is None or np.isnan(interval.value):
        return NONE
    digits = 3 if ratio else 1 if abs(interval.value) < 100.05 else 0
    text = f"{interval:{form}.{digits}f}"
    return text.replace(" ", "x ", 1) if ratio else text


def brief(interval: Interval | None, ratio: bool) -> str:
    """Return a score, or a ratio of costs, with half the length of its interval as text."""
    return shown(interval, ratio, "±")


def tasks_of(results: Sequence[Result]) -> list[str]:
    """Return the tasks of results, the core tasks first."""
    found = dict.fromkeys(each.task for each in results)
    return [*(name for name in CORE if name in found), *(name for name in found if name not in CORE)]


def best(sampled: Sampled, sees: str, kinds: Sequence[str] = KINDS, *, limited: bool = False) -> str | None:
    """Return the policy that scores best among policies with the inputs `sees`; None without a policy or a score.

    `kinds` are the kinds of its results; `limited` allows only the budget class 1M.
    """
    scores = sampled.scores()
    if scores is None:
        return None
    names = dict.fromkeys(
        each.policy
        for each in sampled.results
        if each.sees == sees and each.kind in kinds and not (limited and budget(each.blocks) == "open")
    )
    return max(names, key=lambda name: float(scores[0][sampled.runs(name)].mean()), default=None)


def summaries(results: Sequence[Result], task: str) -> list[PolicySummary]:
    """Return the lines of a task, ordered by what policies see, from least to most, and then from poor to good."""
    group = [each for each in results if each.task == task]
    every, between, plants = Sampled(group), sampled(group, INTERPOLATION), sampled(group, PLANTS)
    costs, scores, ratios = every.costs(), every.scores(), every.ratios()
    rules = {sees: best(every, sees, UNTRAINED) for sees in KNOWLEDGE}
    lines = []
    for policy in dict.fromkeys(each.policy for each in group):
        runs = every.runs(policy)
        of_policy = [every.results[i] for i in runs]
        first = of_policy[0]
        cost, rule = over_runs(costs, runs), rules[first.sees]
        assert cost is not None
        lines.append(
            PolicySummary(
                policy=policy,
                kind=first.kind,
                sees=first.sees,
                model=first.model,
                runs=len(runs),
                cost=cost,
                scrap=float(np.mean([each.scrap for each in of_policy])),
                score=over_runs(scores, runs),
                ratio=over_runs(ratios, runs),
                over=None if rule in (None, policy) else every.gain(policy, str(rule)),
                interpolation_score=None if between is None else over_runs(between.scores(), between.runs(policy)),
                interpolation_ratio=None if between is None else over_runs(between.ratios(), between.runs(policy)),
                plants_cost=None if plants is None else over_runs(plants.costs(), plants.runs(policy)),
                plants_scrap=mean_of(of_policy, "plants_scrap"),
                **{name: mean_of(of_policy, name) for name in MEANS},
            )
        )
    return sorted(lines, key=lambda line: (KNOWLEDGE.index(line.sees), -line.cost.value))


def mean_of(results: Sequence[Result], name: str) -> float | None:
    """Return the mean of a column over the runs with a value; None without a value."""
    values = [value for each in results if (value := getattr(each, name)) is not None]
    return float(np.mean(values)) if values else None


def columns_of(ratio: bool) -> Sequence[Column]:
    """Return the columns of a table of lines; `ratio` is for a task with cost ratios in place of scores."""
    between = "interpolation_ratio" if ratio else "interpolation_score"
    return (
        Column("policy", "policy"),
        Column("score (95 %)", lambda line: shown(line.ratio if ratio else line.score, ratio), right=True),
        Column("over best untrained", lambda line: None if ratio else brief(line.over, False), right=True),
        Column("sees", "sees", right=True),
        Column("budget", lambda line: budget(line.blocks), right=True),
        Column("runs", "runs", right=True),
        Column("$/good part", "cost", "±.3f", right=True),
        Column("scrap %", "scrap", ".2f", right=True, factor=100.0),
        Column("on plants, $", "plants_cost", "±.2f", right=True),
        Column("scrap there, %", "plants_scrap", ".2f", right=True, factor=100.0),
        Column("interpolation", lambda line: brief(getattr(line, between), ratio), right=True),
        Column("model", lambda line: line.model or None, right=True),
        Column("training, s", "train_seconds", ".0f", right=True),
        Column("decision, ms", "decision_ms", ".2f", right=True),
    )


def table_of_task(results: Sequence[Result], task: str, title: str = "", most: int | None = None) -> Table:
    """Return the table of a task, with a row per policy and the first `most` columns, by default all."""
    return table_of(columns_of(is_ratio(task))[:most], summaries(results, task), title)
