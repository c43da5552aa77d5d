"""Reference scores of a task: every policy on the evaluation episodes, `results/<task>.csv` and `scores.toml`."""

import io
import re
from collections.abc import Mapping, Sequence
from csv import writer
from functools import partial
from pathlib import Path

from rich.console import Console

from agents.budgets import SCORE_EPISODES
from agents.cells import RESULTS, RUNS
from agents.provenance import provenance
from agents.reference.measuring import Places, measure_all
from agents.reference.table import Row, best_plan, flat, rich_table, spread_names, table_rows
from agents.tuning.rules import tunable, tune
from grind_env.envs.names import OTHERS, task_names
from grind_env.envs.tasks import Task
from grind_env.policies.evaluation import Evaluation, episode_seeds
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem, find_problem
from grind_env.policies.registry import REFERENCE, make_policy, policy_names
from grind_env.policies.tuned import CONFIGS, write_whole
from grind_env.scores import FILE, Mean, Reference, read_references, write_text
from grind_env.targets import Own, check_own
from grind_env.terminal import table_console

EVALUATIONS = 300
"""Evaluations of each CMA-ES run of a policy that has not been tuned yet."""
SLOW = ("look_ahead",)
"""Policies that take seconds an evaluation. They have few parameters, whose first values are near the best."""
SLOW_EVALUATIONS, SLOW_STARTS = 40, 2
"""Evaluations of each CMA-ES run of these, and their runs."""

TABLE = Own("table of `python -m agents scores`", re.compile(b"task,policy,sees,").match)
NEARLY = 0.02
"""Share of the return of the fixed plan; where the planner earns no more than it beyond, a score would be noise."""


def score(
    problem: Problem,
    *,
    episodes: int = SCORE_EPISODES,
    results: Path = RESULTS,
    runs: Path = RUNS,
    configs: Path = CONFIGS,
    data: Path = FILE,
    console: Console | None = None,
    jobs: int = 1,
    cluster: str | None = None,
) -> list[Row]:
    """Tune what has not been tuned, run every policy, print the table and write it and the reference scores.

    What a policy did is kept below `runs`; see `agents.cells`.

    Args:
        problem: a registered environment.
        episodes: evaluation episodes.
        results: folder of the tables.
        runs: folder of what is kept.
        configs: folder of the tuned parameters.
        data: file of the reference scores.
        console: where to print.
        jobs: processes.
        cluster: of Ray that works in place of processes of our own; see `agents.cluster`.
    """
    console = console or table_console()
    name, simulation = problem.name, problem.simulation()
    check_own(results / f"{name}.csv", TABLE, "--results")
    tune_missing(problem, tunable(simulation), runs=runs, configs=configs, jobs=jobs, cluster=cluster)
    names = policy_names(simulation)
    policies = [make_policy(each, simulation, configs) for each in names]
    places = Places(runs=runs, configs=configs)
    found = measure_all({problem: names}, episodes, places, jobs, console, cluster)[problem]
    rows = table_rows(policies, found)
    console.print(rich_table(rows, f"{simulation.task.title}: {episodes} evaluation episodes"))
    write_whole(results / f"{name}.csv", csv_text(simulation.task, rows, found))
    references = {**read_references(data), problem.id: reference_of(simulation.task, policies, found)}
    write_whole(data, write_text(references))
    return rows


def tune_missing(
    problem: Problem,
    names: Sequence[str],
    *,
    runs: Path,
    configs: Path | None,
    jobs: int,
    cluster: str | None = None,
) -> None:
    """Tune those of the policies that have not been tuned for a problem yet, with the budget of all tables."""
    quick, slow = ([name for name in names if (name in SLOW) == those] for those in (False, True))
    tuned = partial(tune, problem, folder=configs, runs=runs, jobs=jobs, cluster=cluster)
    tuned(quick, evaluations=EVALUATIONS)
    tuned(slow, evaluations=SLOW_EVALUATIONS, starts=SLOW_STARTS)


def scored_problems() -> list[Problem]:
    """The registered environments in which E and D are chosen, the shortest episodes first."""
    problems = [find_problem(name) for name in (*task_names(), *OTHERS) if name != "job"]
    return sorted(problems, key=lambda problem: problem.simulation().most_steps)


def reference_of(task: Task, policies: Sequence[Policy], found: Mapping[str, Evaluation]) -> Reference:
    """The reference scores of a task: anchors on the episodes of the planner, returns on all."""
    planned = len(found[REFERENCE].cost)
    measured = {each.name: found[each.name] for each in policies if each.sees == "measurements"}
    best = min(measured, key=lambda name: float(measured[name].cost.mean()))
    fixed = best_plan(found)
    zero, hundred = mean_return(task, found[fixed].first(planned)).value, mean_return(task, found[REFERENCE]).value
    return Reference(
        zero=zero,
        hundred=hundred,
        ratio=hundred - zero <= NEARLY * abs(zero),
        fixed_plan=fixed,
        best_scripted=best,
        J_fix=round(float(found[fixed].cost.mean()), 4),
        J_plan=round(float(found[REFERENCE].cost.mean()), 4),
        returns={name: mean_return(task, run) for name, run in found.items()},
    )


def mean_return(task: Task, run: Evaluation) -> Mean:
    """Mean return of an episode and its standard error."""
    returns = -run.cost / task.reference_cost
    error = float(returns.std(ddof=1)) / len(returns) ** 0.5 if len(returns) > 1 else 0.0
    return Mean(round(float(returns.mean()), 4), round(error, 4))


def csv_text(task: Task, rows: Sequence[Row], found: Mapping[str, Evaluation]) -> str:
    """All numbers in full, with seeds and versions in every row."""
    text = io.StringIO()
    lines = writer(text, lineterminator="\n")
    columns = ["policy", "sees", *spread_names("cost_per_good_part"), "scrap", "E", "D", *spread_names("score")]
    facts = [provenance(episode_seeds("evaluation", len(found[row.policy].cost))) for row in rows]
    kept = [name for name in facts[0] if name not in ("stable_baselines3", "torch")]
    lines.writerow(["task", *columns, *kept])
    for row, fact in zip(rows, facts, strict=True):
        lines.writerow([task.name, *flat(row), *(fact[name] for name in kept)])
    return text.getvalue()
