"""`python -m agents dress-study`."""

import os
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from agents.budgets import STUDY_EPISODES
from agents.cells import RESULTS, RUNS
from agents.commands.interrupted import going_on
from agents.commands.options import Ray
from grind_env.arguments import PROBLEM, Keeps
from grind_env.commands import JobFile, Parts, Plant
from grind_env.envs.names import task_names
from grind_env.errors import printable
from grind_env.files import is_file, write_atomically
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.problem import Problem, find_problem
from grind_env.policies.tuned import write_whole
from grind_env.targets import Own, check_own
from grind_env.terminal import table_console

FOLDER = RESULTS / "dress_study"
PICTURE = Own("picture of `python -m agents dress-study`, whose table would lie beside it", lambda head: False)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(name="dress-study", epilog="Example: python -m agents dress-study --task power_limited")(study)


def study(
    task: Annotated[
        str | None,
        typer.Option(
            "--task", "--env", "--program", help="A task, id, task file or part program; all tasks by default."
        ),
        PROBLEM,
    ] = None,
    job: JobFile = None,
    parts: Parts = 1,
    plant: Plant = None,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = STUDY_EPISODES,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    results: Annotated[Path, typer.Option(help="Folder of the tables and pictures."), Keeps()] = FOLDER,
    ray: Ray = None,
) -> None:
    """Cost against dress interval, dress lead, depth and passes, and what decides when to dress.

    With --plant on another machine, for which plans are chosen anew; policies that see measurements stay those of the
    model, and planners that see more hold the machine.
    """
    from agents.dressing.cells import Request, cells, deciding, find, on_plant
    from agents.dressing.figure import dress_figure
    from agents.dressing.study import TABLE, count, csv_text, dress_study
    from agents.pool import work_on_all

    problems = [find_problem(name, job, parts) for name in (task_names() if task is None else [task])]
    if plant is not None:
        problems = [on_plant(each, plant) for each in problems]
    for each in problems:
        check_own(results / f"{each.name}.csv", TABLE, "--results")
        if not is_file(results / f"{each.name}.csv"):
            check_own(results / f"{each.name}.png", PICTURE, "--results")
    deciders = {each.name: deciding(each) for each in problems}
    with going_on():
        if ray is not None:
            # what is kept then is all that the study below asks for
            listed = [cell for each in problems for cell in cells(each)]
            work_on_all(listed, Request(episodes=episodes, runs=runs), os.cpu_count() or 1, table_console(), find, ray)
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with Progress(*columns) as progress:
            bars = {
                each.name: progress.add_task(each.name, total=count(each, deciders[each.name])) for each in problems
            }
            for each in problems:
                advance = partial(progress.advance, bars[each.name])
                found = dress_study(each, deciders[each.name], episodes=episodes, runs=runs, advance=advance)
                write_whole(results / f"{each.name}.csv", csv_text(found, episode_seeds("evaluation", episodes)))
                write_picture(results / f"{each.name}.png", dress_figure(found, title(each)))
    print(printable(f"tables and pictures: {results}"))


def title(problem: Problem) -> str:
    """Of a picture: the task, and the machine where it is not the model."""
    plant = dict(problem.arguments).get("plant")
    return problem.simulation().task.title + (f", on {plant}" if plant else "")


def write_picture(path: Path, picture: bytes) -> None:
    """Write a picture whole or not at all."""
    write_atomically(path, lambda unfinished: unfinished.write_bytes(picture))
