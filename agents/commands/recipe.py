"""`python -m agents recipe`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.benchmark.plan import FLAGSHIP, chosen_problems
from agents.cells import RESULTS, RUNS
from grind_env.arguments import Keeps
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents recipe --tasks core --seeds 5")(recipe)


def recipe(
    tasks: Annotated[
        str,
        typer.Option("--tasks", "--task", "--env", help="Tasks or ids, separated by commas; `core` or `all` tasks."),
    ] = FLAGSHIP,
    seeds: Annotated[int, typer.Option(min=1, help="Trainings of each way, from seed 0.")] = 5,
    steps: Annotated[int, typer.Option(min=1, help="Environment steps of a training.")] = 1_000_000,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    results: Annotated[Path, typer.Option(help="Folder of recipe.csv and recipe.md."), Keeps()] = RESULTS,
) -> None:
    """Run the training recipe of the docs on several seeds, with the belief and without, and write the table.

    What was trained before by the same lines and code is kept: interrupted, the same command goes on. What the table
    has of other tasks stays.
    """
    from agents.recipe import page, run_recipe

    console = table_console()
    found = run_recipe(chosen_problems(tasks), seeds, steps, jobs=jobs, console=console, runs=runs, results=results)
    console.print(page(found), soft_wrap=True)
    console.print(f"written to {results}: recipe.csv and recipe.md")
