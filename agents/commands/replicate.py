"""`python -m agents replicate`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.cells import RESULTS, RUNS
from grind_env.arguments import PROBLEM, Keeps, Reads
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents replicate --task rush --first 7000000 --episodes 64")(replicate)


def replicate(
    task: Annotated[
        list[str] | None,
        typer.Option("--task", "--env", help="A task with results; may be repeated; all that have some by default."),
        PROBLEM,
    ] = None,
    first: Annotated[
        list[int] | None,
        typer.Option("--first", min=0, help="First seed of a set; may be repeated; three sets by default."),
    ] = None,
    episodes: Annotated[
        int, typer.Option(min=2, help="Episodes of a set, on the model and on machines that are not.")
    ] = 128,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    published: Annotated[
        Path,
        typer.Option(help="Folder of benchmark.parquet, the results that are replicated."),
        Reads(files=lambda text: [Path(text) / "benchmark.parquet"]),
    ] = RESULTS,
    results: Annotated[
        Path | None,
        typer.Option(
            help="Folder of replications.csv and .md; of what is chosen here, by default that of what is kept."
        ),
        Keeps(),
    ] = None,
) -> None:
    """Whether published results of the benchmark hold on seeds that nothing was chosen by.

    Policies of the results are run on other episodes, whose mean costs are to lie where the published rows have them
    with 95 %. What the same code has found before is kept: interrupted, the same command goes on.
    """
    from agents.benchmark.replications import BEGINS, FIRSTS, write
    from agents.benchmark.replications import replicate as run
    from agents.benchmark.results import read_results
    from agents.benchmark.summary import tasks_of
    from agents.tables import check_tables
    from grind_env.policies.problem import find_problem

    console, known = table_console(), read_results(published)
    folder = results or (runs if task or first or published != RESULTS else RESULTS)
    check_tables(folder, "replicate", BEGINS)
    problems = [find_problem(name) for name in dict.fromkeys(task or tasks_of(known))]
    found = run(known, problems, list(dict.fromkeys(first or FIRSTS)), episodes, jobs=jobs, console=console, runs=runs)
    console.print(write(known, found, folder), soft_wrap=True, highlight=False, markup=False)
    console.print(f"written to {folder}: replications.csv and replications.md", highlight=False)
