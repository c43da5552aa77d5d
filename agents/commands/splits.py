"""`python -m agents splits`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.cells import RESULTS, RUNS
from grind_env.arguments import PROBLEM, Keeps
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents splits --task rush --episodes 64")(splits)


def splits(
    task: Annotated[
        list[str] | None,
        typer.Option("--task", "--env", help="A task with agents; may be repeated; all core tasks by default."),
        PROBLEM,
    ] = None,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = 128,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    results: Annotated[
        Path | None,
        typer.Option(help="Folder of splits.csv and splits.md; of some tasks alone, by default that of what is kept."),
        Keeps(),
    ] = None,
) -> None:
    """Rules, planners and agents on contexts that no training has seen, and on some that the task does not draw.

    What the same code has found before is kept: interrupted, the same command goes on.
    """
    from agents.benchmark.plan import CORE
    from agents.splits import page, run_splits
    from grind_env.policies.problem import find_problem

    console, problems = table_console(), [find_problem(name) for name in dict.fromkeys(task or CORE)]
    folder = results or (runs if task else RESULTS)
    lines = run_splits(problems, episodes, jobs=jobs, console=console, runs=runs, results=folder)
    console.print(page(lines, episodes), soft_wrap=True)
    console.print(f"written to {folder}: splits.csv and splits.md")
