"""`python -m agents worlds`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.benchmark.plan import FLAGSHIP
from agents.cells import RESULTS, RUNS
from grind_env.arguments import Keeps
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents worlds --episodes 64 --results runs")(worlds)


def worlds(
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = 256,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    results: Annotated[Path, typer.Option(help="Folder of worlds.csv and worlds.md."), Keeps()] = RESULTS,
) -> None:
    """What a guard makes of a trained agent on machines with another constant: forces, stiffness, dulling, coolant, Ra.

    On PowerLimited; beside it the agent alone, the rule that the guard falls back to, the fixed plan retuned on each
    machine, and an agent trained on many. What the same code has found before is kept: interrupted, the same command
    goes on.
    """
    from agents.worlds import page, run_worlds
    from grind_env.policies.problem import find_problem

    console, problem = table_console(), find_problem(FLAGSHIP)
    found = run_worlds(problem, episodes, jobs=jobs, console=console, runs=runs, results=results)
    console.print(page(found, problem.name, episodes), soft_wrap=True)
    console.print(f"written to {results}: worlds.csv and worlds.md")
