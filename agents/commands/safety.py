"""`python -m agents safety`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.benchmark.plan import chosen_problems
from agents.cells import RESULTS, RUNS
from grind_env.arguments import Keeps
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents safety --tasks power_limited --seeds 3")(safety)


def safety(
    tasks: Annotated[
        str | None,
        typer.Option(
            "--tasks", "--task", "--env", help="Tasks or ids, separated by commas; `core`, the default, or `all` tasks."
        ),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Trainings of each agent, from seed 0.")] = 3,
    steps: Annotated[int, typer.Option(min=1, help="Environment steps of a training.")] = 600_000,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = 256,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    results: Annotated[
        Path | None,
        typer.Option(help="Folder of safety.csv and safety.md; of some tasks alone, by default that of what is kept."),
        Keeps(),
    ] = None,
) -> None:
    """What PPO with a GRU earns and violates, unconstrained and with a budget of scrap, beside a guarded rule.

    Power, size, Ra and burning are counted block by block, scrap part by part. What the same code has found before is
    kept: interrupted, the same command goes on.
    """
    from agents.safety.page import page
    from agents.safety.study import run_safety

    console, problems = table_console(), chosen_problems(tasks or "core")
    folder = results or (runs if tasks else RESULTS)
    found = run_safety(problems, seeds, steps, episodes, jobs=jobs, console=console, runs=runs, results=folder)
    console.print(page(found), soft_wrap=True)
    console.print(f"written to {folder}: safety.csv and safety.md")
