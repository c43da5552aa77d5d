"""`python -m agents scores`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.budgets import SCORE_EPISODES
from agents.cells import RESULTS, RUNS
from agents.commands.interrupted import going_on
from agents.commands.options import Ray
from grind_env.arguments import PROBLEM, Keeps, Writes
from grind_env.errors import GrindError
from grind_env.policies.problem import find_problem
from grind_env.policies.tuned import CONFIGS
from grind_env.scores import FILE as SCORES
from grind_env.scores import REFERENCES
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents scores --task power_limited")(scores)


def scores(
    task: Annotated[
        str | None, typer.Option("--task", "--env", help="A task or an id; all by default."), PROBLEM
    ] = None,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = SCORE_EPISODES,
    compare: Annotated[bool, typer.Option("--compare", help="Only set the tables beside the published costs.")] = False,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    configs: Annotated[
        Path, typer.Option(help="Folder of the tuned parameters of the scripted policies."), Keeps()
    ] = CONFIGS,
    results: Annotated[Path, typer.Option(help="Folder of the tables."), Keeps()] = RESULTS,
    data: Annotated[
        Path, typer.Option(help="File of the reference scores."), Writes(own=REFERENCES, always=True)
    ] = SCORES,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    ray: Ray = None,
) -> None:
    """Measure the reference scores: tune what is missing, run every policy, write the tables."""
    from agents.reference.compare import compare as compare_published
    from agents.reference.compare import comparison_table
    from agents.reference.scores import score, scored_problems

    problems = scored_problems() if task is None else [find_problem(task)]
    if of_user := next((problem for problem in problems if problem.simulation().task.file), None):
        raise GrindError(
            f"{of_user.name} has no reference scores, which registered environments have: "
            f"run `python -m agents gaps --task {of_user.simulation().task.file}`"
        )
    if compare:
        table = comparison_table(compare_published([problem.name for problem in problems], results))
        table_console().print(table)
        return
    with going_on():
        for problem in problems:
            score(
                problem,
                episodes=episodes,
                results=results,
                runs=runs,
                configs=configs,
                data=data,
                jobs=jobs,
                cluster=ray,
            )
