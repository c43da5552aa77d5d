"""Reference scores of a task: every policy on the evaluation episodes, `results/<task>.csv` and `scores.toml`."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from agents.csv_tables import csv_of
from agents.evaluation_cache import RESULTS
from agents.evaluations import Evaluations, by_problem, chunks
from agents.provenance import provenance
from agents.reference.table import COLUMNS, ScoreRow, best_plan, flat, spread_names, table_rows
from agents.study import Found, Study, StudyOptions
from agents.tuning.rule_tuning import tunable, tune
from grind_env.data_table import table_of
from grind_env.envs.tasks import Task
from grind_env.errors import GrindError
from grind_env.policies.evaluation import Evaluation, episode_seeds
from grind_env.policies.policy import Policy
from grind_env.policies.registry import REFERENCE, make_policy, policy_names
from grind_env.policies.tuned_parameters import write_whole
from grind_env.score_scale import FILE, HEADING, Mean, Reference, read_references, write_text

EVALUATIONS = 300  #: number of evaluations of each CMA-ES run of a policy that has not been tuned yet
#: policies that take seconds per evaluation. They have few parameters, whose first values are near the best
SLOW = ("look_ahead",)
SLOW_EVALUATIONS, SLOW_STARTS = 40, 2  #: number of evaluations of each CMA-ES run of a slow policy, and number of runs

#: least gain of the planner over the fixed plan's return, as a share; with less gain a score would be noise
NEARLY = 0.02


def study(asked: StudyOptions) -> Study:
    """Return the study of registered environments; another results folder gets its own file of reference scores."""
    data = FILE if asked.results == RESULTS else asked.results / FILE.name
    for problem in asked.problems:
        if file := problem.simulation().task.file:
            raise GrindError(
                f"{problem.name} has no reference scores, which registered environments have: "
                f"run `python -m agents gaps --task {file}`"
            )

    def publish(found: Found, folder: Path) -> str:
        texts = []
        for problem, runs in by_problem(found).items():
            simulation = problem.simulation()
            policies = [make_policy(each, simulation, asked.configs) for each in policy_names(simulation)]
            rows = table_rows(policies, runs)
            write_whole(folder / f"{problem.name}.csv", csv_text(simulation.task, rows, asked.episodes))
            references = {**read_references(data), problem.id: reference_of(simulation.task, policies, runs)}
            write_whole(data, write_text(references))
            title = f"{simulation.task.title}: {asked.episodes} evaluation episodes"
            texts.append(f"{title}\n\n{table_of(COLUMNS, rows).markdown()}")
        return "\n\n".join(texts)

    return Evaluations(
        name="scores",
        title="Reference scores",
        trials=chunks(asked, lambda problem: policy_names(problem.simulation())),
        prepare=partial(tune_missing, asked),
        publish=publish,
        files={f"{problem.name}.csv": "task,policy,sees," for problem in asked.problems} | {FILE.name: HEADING},
    )


def tune_missing(asked: StudyOptions, more: Sequence[str] = ()) -> None:
    """Tune the policies of each problem, and the policies `more`, that have not been tuned for the problem yet."""
    options = asked.options
    for problem in asked.problems:
        names = [*tunable(problem.simulation()), *more]
        quick, slow = ([name for name in names if (name in SLOW) == those] for those in (False, True))
        tuned = partial(tune, problem, folder=asked.configs, runs=options.runs, jobs=options.jobs, ray=options.ray)
        tuned(quick, evaluations=EVALUATIONS)
        tuned(slow, evaluations=SLOW_EVALUATIONS, starts=SLOW_STARTS)


def reference_of(task: Task, policies: Sequence[Policy], found: Mapping[str, Evaluation]) -> Reference:
    """Return the reference scores of a task, from evaluations on the same episodes."""
    measured = {each.name: found[each.name] for each in policies if each.sees == "measurements"}
    best = min(measured, key=lambda name: float(measured[name].cost.mean()))
    fixed = best_plan(found)
    zero, hundred = mean_return(task, found[fixed]).value, mean_return(task, found[REFERENCE]).value
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
    """Return the mean return of an episode and its standard error."""
    returns = -run.cost / task.reference_cost
    error = float(returns.std(ddof=1)) / len(returns) ** 0.5 if len(returns) > 1 else 0.0
    return Mean(round(float(returns.mean()), 4), round(error, 4))


def csv_text(task: Task, rows: Sequence[ScoreRow], episodes: int) -> str:
    """Return all numbers unrounded, with seeds and versions in every row."""
    columns = ["policy", "sees", *spread_names("cost_per_good_part"), "scrap", "E", "D", *spread_names("score")]
    facts = provenance(episode_seeds("evaluation", episodes), trains=False)
    return csv_of(["task", *columns, *facts], [[task.name, *flat(row), *facts.values()] for row in rows])
