"""`python -m agents gaps`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.budgets import GAP_EPISODES
from agents.cells import RESULTS, RUNS
from grind_env.arguments import PROBLEM, Keeps
from grind_env.commands import Configs
from grind_env.policies.problem import find_problem
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents gaps --task power_limited --task rush")(gaps)


def gaps(
    task: Annotated[
        list[str] | None,
        typer.Option("--task", "--env", help="A task, a file, or an id; may be repeated; all by default."),
        PROBLEM,
    ] = None,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = GAP_EPISODES,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    configs: Configs = None,
    results: Annotated[
        Path | None,
        typer.Option(help="Folder of gaps.csv and gaps.md; of some tasks alone, by default that of what is kept."),
        Keeps(),
    ] = None,
) -> None:
    """What it is worth to adapt E, D or both: tune what is missing, run every policy, write the tables.

    The fixed plan is the best one without sensors. The planner knows the state of the wheel; hindsight knows what is to
    come, too.
    """
    from agents.reference.gap_table import BEGINS, rich_tables, write_gaps
    from agents.reference.gaps import measure_gaps
    from agents.reference.scores import scored_problems
    from agents.tables import check_tables

    console = table_console()
    problems = [find_problem(name) for name in dict.fromkeys(task)] if task else scored_problems()
    results = results or (runs if task else RESULTS)
    check_tables(results, "gaps", BEGINS)
    found = measure_gaps(problems, episodes=episodes, runs=runs, configs=configs, jobs=jobs, console=console)
    write_gaps(found, episodes, results)
    for each in rich_tables(found):
        console.print(each)
    console.print(f"written to {results}: gaps.csv and gaps.md", highlight=False)
