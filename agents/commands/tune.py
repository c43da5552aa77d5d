"""`python -m agents tune`."""

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from agents.budgets import TRIAL_STEPS, TRIALS, TUNING_EPISODES, TUNING_EVALUATIONS, TUNING_STARTS
from agents.cells import RUNS
from agents.commands.interrupted import going_on
from agents.commands.options import Ray
from agents.learning.settings import LAST_SEED, settings_folder
from grind_env.arguments import Keeps
from grind_env.commands import JobFile, NamedProblem, Parts
from grind_env.errors import GrindError
from grind_env.policies.problem import find_problem
from grind_env.policies.tuned import tuned_folder


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    epilog = "Example: python -m agents tune --task power_limited --policies belief_rule,look_ahead"
    app.command(name="tune", epilog=epilog)(tuning)


def tuning(
    task: NamedProblem = "power_limited",
    job: JobFile = None,
    parts: Parts = 1,
    policies: Annotated[
        str | None, typer.Option(help="Names of policies, separated by commas; all by default.")
    ] = None,
    evaluations: Annotated[int, typer.Option(min=1, help="Evaluations of each CMA-ES run.")] = TUNING_EVALUATIONS,
    starts: Annotated[int, typer.Option(min=1, help="CMA-ES runs of a policy.")] = TUNING_STARTS,
    episodes: Annotated[int, typer.Option(min=1, help="Episodes, training and validation each.")] = TUNING_EPISODES,
    kind: Annotated[str | None, typer.Option(help="Tune the settings of this kind of learned agent instead.")] = None,
    trials: Annotated[int, typer.Option(min=1, help="Trainings of a learned agent.")] = TRIALS,
    steps: Annotated[int, typer.Option(min=1, help="Environment steps of each of them.")] = TRIAL_STEPS,
    seed: Annotated[int, typer.Option(min=0, max=LAST_SEED, help="Training seed of all of them.")] = 0,
    storage: Annotated[
        str | None, typer.Option(help="URL of the database of the trials; by default runs/<task>/tune.db.")
    ] = None,
    configs: Annotated[
        Path | None, typer.Option(help="Folder of the tuned parameters; in its `learning` those of agents."), Keeps()
    ] = None,
    runs: Annotated[Path, typer.Option(help="Folder of the trials and trained agents."), Keeps()] = RUNS,
    fresh: Annotated[bool, typer.Option("--fresh", help="Do again what is already done.")] = False,
    jobs: Annotated[int, typer.Option(min=1, help="Processes for scripted policies.")] = 2,
    ray: Ray = None,
) -> None:
    """Tune scripted policies, or the settings of a learned agent, and store their parameters.

    Every trial is kept in an Optuna study: if the command is killed, the same command goes on.
    """
    problem = find_problem(task, job, parts)
    if kind is None:
        from agents.tuning.rules import tune

        names = None if policies is None else [name.strip() for name in policies.split(",")]
        with going_on(fresh):
            tuned = tune(
                problem,
                names,
                evaluations=evaluations,
                starts=starts,
                episodes=episodes,
                storage=storage,
                folder=configs,
                runs=runs,
                fresh=fresh,
                jobs=jobs,
                cluster=ray,
            )
        for name, entry in tuned.items():
            print(f"{name}: {entry.training_cost} $ an episode in training, {entry.validation_cost} $ in validation")
        print(f"parameters: {tuned_folder(problem.simulation().task, configs) / problem.name}.toml")
        return
    if ray is not None:
        raise GrindError("--ray does nothing with --kind, whose trainings learn one from the other: leave it out")
    # torch takes seconds to load
    from agents.tuning.learners import Search, tune_learner

    search = Search(
        trials=trials,
        steps=steps,
        seed=seed,
        storage=storage,
        configs=settings_folder(problem.simulation().task) if configs is None else configs / "learning",
        runs=runs,
        fresh=fresh,
    )
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with going_on(fresh), Progress(*columns) as progress:
        bar = progress.add_task(kind, total=trials)

        def report(done: int, cost: float) -> None:
            progress.update(bar, completed=done, description=f"{kind}: {cost:.2f} $ in validation")

        settings, cost = tune_learner(problem, kind, search, report)
    print(f"{kind}: {cost:.4f} $ an episode in validation with {dict(settings.hyper)}, layers {settings.hidden}")
