"""`python -m agents dress-study`."""

from typing import Annotated

import typer

from agents.benchmark.plan import chosen_problems
from agents.budgets import STUDY_EPISODES
from agents.cells import RESULTS, RUNS
from agents.commands.interrupted import going_on
from agents.commands.options import Tasks
from agents.study import Fresh, Jobs, Options, Ray, Results, Runs
from grind_env.commands import JobFile, Parts, Plant
from grind_env.files import is_file
from grind_env.targets import Own, check_own
from grind_env.terminal import table_console

FOLDER = RESULTS / "dress_study"
PICTURE = Own("picture of `python -m agents dress-study`, whose table would lie beside it", lambda head: False)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(name="dress-study", epilog="Example: python -m agents dress-study --task power_limited")(dress_study)


def dress_study(
    tasks: Tasks = None,
    job: JobFile = None,
    parts: Parts = 1,
    plant: Plant = None,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = STUDY_EPISODES,
    jobs: Jobs = 2,
    ray: Ray = None,
    runs: Runs = RUNS,
    results: Results = None,
    fresh: Fresh = False,
) -> None:
    """Cost against dress interval, dress lead, depth and passes, and what decides when to dress.

    With --plant on another machine, for which plans are chosen anew; policies that see measurements stay those of the
    model, and planners that see more hold the machine.
    """
    from agents.dressing.trials import on_plant, study

    problems, folder = chosen_problems(tasks or "all", job, parts), results or FOLDER
    if plant is not None:
        problems = [on_plant(each, plant) for each in problems]
    for each in problems:
        if not is_file(folder / f"{each.name}.csv"):
            check_own(folder / f"{each.name}.png", PICTURE, "--results")
    options = Options(jobs=jobs, ray=ray, runs=runs, fresh=fresh, console=table_console())
    with going_on(fresh):
        study(problems, episodes, runs.absolute()).publish_to(folder, options)
