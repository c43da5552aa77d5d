"""Page of the safety study: returns, violations, and the policies that keep the budget."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import partial
from itertools import groupby
from statistics import mean

from agents.safety.trials import (
    LAGRANGIAN,
    LIMITS,
    PLANNERS,
    RULES,
    UNCONSTRAINED,
    VALIDATED,
    SafetyRow,
    SafetyTrial,
    decides,
    judge,
)
from agents.study import Study, StudyOptions
from grind_env.data_table import Column, table_of
from grind_env.policies.score_statistics import Interval

STEP, EPISODE = 8e-5, 0.1  #: measured CPU time of a training step, and of an episode of a rule, which looks ahead, s


def study(asked: StudyOptions) -> Study:
    """Return the study."""
    trials = [
        SafetyTrial(problem, who, seed, asked.steps, asked.episodes, asked.options.runs, asked.options.fresh)
        for problem in asked.problems
        for who in (UNCONSTRAINED, LAGRANGIAN, *RULES)
        for seed in range(1 if who in RULES else asked.seeds)
    ]
    return Study(
        name="safety",
        title="The safe track",
        trials=trials,
        run=judge,
        decides=decides,
        columns=[each.name for each in fields(SafetyRow)],
        rows=lambda found: [tuple(each.values()) for each in found.values()],
        page=lambda found: page([SafetyRow(**each) for each in found.values()]),
        episodes=asked.episodes,
        seconds=lambda trial: EPISODE * trial.episodes if trial.who in RULES else STEP * trial.steps,
    )


def _mean(runs: Sequence[SafetyRow], name: str) -> float:
    return float(mean(getattr(each, name) for each in runs))


def _kept(runs: Sequence[SafetyRow]) -> str:
    """Return how many runs are within their budgets, and how many significantly."""
    kept, surely = (sum(getattr(each, end) <= each.budget for each in runs) for end in ("scrap", "scrap_high"))
    return f"{kept} ({surely}) of {len(runs)}"


def _return(runs: Sequence[SafetyRow]) -> Interval:
    """Return the mean return over seeds, with the lowest and the highest end of their intervals."""
    low, high = min(each.return_low for each in runs), max(each.return_high for each in runs)
    return Interval(_mean(runs, "episode_return"), low, high)


COLUMNS = (
    Column("task", lambda runs: f"{runs[0].task}, budget {100.0 * runs[0].budget:.2f} %"),
    Column("who", lambda runs: runs[0].who),
    Column("seeds", len),
    Column("return", _return, ".1f"),
    Column(
        "scrap %",
        lambda runs: f"{100.0 * _mean(runs, 'scrap'):.2f} ({', '.join(f'{100.0 * each.scrap:.2f}' for each in runs)})",
    ),
    Column("within budget", _kept),
    *(Column(f"{name} %", partial(_mean, name=name), ".2f", factor=100.0) for name in LIMITS),
)


def page(found: Sequence[SafetyRow]) -> str:
    """Return the table as Markdown: means over seeds, and the scrap of each seed."""
    of = {key: list(group) for key, group in groupby(found, lambda each: (each.task, each.who))}
    return (
        f"`python -m agents safety`: {found[0].episodes} evaluation episodes. *Return*: minus the cost of an episode"
        " over the reference cost of a block; its interval spans those of all seeds. *Scrap*: share of the parts (each"
        " seed in brackets). *Within budget*: seeds whose scrap is below the budget, and in brackets those with the"
        " whole interval below it. The other columns are shares of the blocks beyond a limit (more than the permitted"
        f" power slows the wheel).\n\nThe budget of a task is the geometric mean of the scrap of `{PLANNERS[0]}` and of"
        f" `{PLANNERS[1]}` (sees the state) on {VALIDATED} validation episodes: the first exceeds it, the second not."
        f"\n\n{verdict(of)}{table_of(COLUMNS, of.values()).markdown()}"
    )


def verdict(of: Mapping[tuple[str, str], Sequence[SafetyRow]]) -> str:
    """Return sentences on who keeps the budget and on the cost of the multiplier; empty for one task."""
    tasks = list(dict.fromkeys(task for task, _ in of))
    if len(tasks) < 2:
        return ""
    told = []
    for who in dict.fromkeys(who for _, who in of):
        runs = [each for task in tasks for each in of[task, who]]
        told.append(f"`{who}` {_kept(runs)}")
    more = [
        100.0 * (_mean(of[task, LAGRANGIAN], "episode_return") / _mean(of[task, UNCONSTRAINED], "episode_return") - 1.0)
        for task in tasks
    ]
    return (
        f"Runs within the budget on all tasks: {', '.join(told)}. The budget changes the cost of an episode"
        f" of `plain_gru` by {min(more):+.1f} to {max(more):+.1f} %, depending on the task.\n\n"
    )
