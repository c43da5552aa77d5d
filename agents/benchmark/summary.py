"""One line for each policy of a task, over its training runs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agents.benchmark.judge import Sampled, is_ratio, over_runs, sampled
from agents.benchmark.plan import LIMIT
from agents.benchmark.results import INTERPOLATION, PLANTS, Result
from grind_env.envs.names import CORE
from grind_env.policies.statistics import Interval
from grind_env.table import NONE, Column, Table, table_of

KNOWLEDGE = ("measurements", "state", "future")
"""From least to most, the order of the table."""
ON_SCREEN = 8
"""Columns that a terminal has room for."""
MEANS = ("blocks", "decision_ms", "train_seconds")
"""Columns of results of which a line has the mean."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicySummary:
    """One line of a table: means over the runs of a policy; what is not known of it is None."""

    policy: str
    kind: str
    sees: str
    model: str | None
    runs: int
    cost: Interval
    """$ per good part."""
    scrap: float
    score: Interval | None
    ratio: Interval | None
    """Cost over that of the best fixed plan."""
    over: Interval | None
    """Points more than the best rule with the same inputs, paired."""
    interpolation_score: Interval | None
    """With contexts of the split `interpolation`, as the ratio that follows."""
    interpolation_ratio: Interval | None
    plants_cost: Interval | None
    """$ per good part on machines that are held out."""
    plants_scrap: float | None
    blocks: float | None
    decision_ms: float | None
    train_seconds: float | None


def budget(blocks: float | None) -> str:
    """Return the budget class of a policy that so many blocks were ground to make; a rollout more does not count."""
    return NONE if blocks is None else "1M" if blocks < 1.02 * LIMIT else "open"


def shown(interval: Interval | None, ratio: bool, form: str = "") -> str:
    """Return a score, or a ratio of costs, with its interval; with half its length if the form is `±`."""
    if interval is None or np.isnan(interval.value):
        return NONE
    digits = 3 if ratio else 1 if abs(interval.value) < 100.05 else 0
    text = f"{interval:{form}.{digits}f}"
    return text.replace(" ", "x ", 1) if ratio else text


def brief(interval: Interval | None, ratio: bool) -> str:
    """Return the same with half the length of the interval."""
    return shown(interval, ratio, "±")


def tasks_of(results: Sequence[Result]) -> list[str]:
    """Return the tasks of results, those of the core set first."""
    found = dict.fromkeys(each.task for each in results)
    return [*(name for name in CORE if name in found), *(name for name in found if name not in CORE)]


def best(sampled: Sampled, sees: str, kind: str = "", *, limited: bool = False) -> str | None:
    """Return the policy with such inputs that scores best; None if there is none, or no score.

    `kind` is that of its results, by default any; a limited one is of the budget class 1M.
    """
    scores = sampled.scores()
    if scores is None:
        return None
    names = dict.fromkeys(
        each.policy
        for each in sampled.results
        if each.sees == sees and kind in ("", each.kind) and not (limited and budget(each.blocks) == "open")
    )
    return max(names, key=lambda name: float(scores[0][sampled.runs(name)].mean()), default=None)


def summaries(results: Sequence[Result], task: str) -> list[PolicySummary]:
    """Return the lines of a task, from those that know least to those that know most, and from poor to good."""
    group = [each for each in results if each.task == task]
    every, between, plants = Sampled(group), sampled(group, INTERPOLATION), sampled(group, PLANTS)
    costs, scores, ratios = every.costs(), every.scores(), every.ratios()
    rules = {sees: best(every, sees, "scripted") for sees in KNOWLEDGE}
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
    """Mean of a column over runs of which it is known."""
    values = [value for each in results if (value := getattr(each, name)) is not None]
    return float(np.mean(values)) if values else None


def columns_of(ratio: bool) -> Sequence[Column]:
    """Return the columns of a table of lines; `ratio` for a task of which the ratio stands in place of the score."""
    between = "interpolation_ratio" if ratio else "interpolation_score"
    return (
        Column("policy", "policy"),
        Column("score (95 %)", lambda line: shown(line.ratio if ratio else line.score, ratio), right=True),
        Column("over best rule", lambda line: None if ratio else brief(line.over, False), right=True),
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
    """Return the table of a task, a row a policy; of its columns the first ones, `most` of them."""
    return table_of(columns_of(is_ratio(task))[:most], summaries(results, task), title)
