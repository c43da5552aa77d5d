"""`python -m agents hindsight`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.benchmark.plan import chosen_problems
from agents.cells import RESULTS, RUNS
from agents.commands.interrupted import going_on
from grind_env.arguments import PROBLEM, Keeps
from grind_env.targets import check_own
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents hindsight --tasks power_limited,rush --episodes 16")(hindsight)


def hindsight(
    tasks: Annotated[
        str,
        typer.Option(
            "--tasks", "--task", "--env", help="Tasks, ids or task files, separated by commas; `core` or `all` tasks."
        ),
        PROBLEM,
    ] = "core",
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = 32,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    results: Annotated[
        Path | None,
        typer.Option(help="Folder of hindsight.csv; of other tasks than `core`, by default that of what is kept."),
        Keeps(),
    ] = None,
) -> None:
    """What the hindsight planner, which scores 100, would score if it searched less, or longer than it does.

    Searches that are done are kept: interrupted, the same command goes on.
    """
    from agents.benchmark.effort import CSV, OWNED, Request, curves, write_curves
    from agents.benchmark.page import effort_table

    console, folder = table_console(), results or (RESULTS if tasks == "core" else runs)
    check_own(folder / CSV, OWNED, "--results")
    with going_on():
        points = curves(chosen_problems(tasks), Request(episodes, runs), jobs, console)
    write_curves(points, folder)
    console.print(effort_table(points), soft_wrap=True, highlight=False, markup=False)
    console.print(f"written to {folder}: {CSV}", highlight=False)
