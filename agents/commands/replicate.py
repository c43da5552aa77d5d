"""`python -m agents replicate`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.benchmark.plan import EPISODES, chosen_problems
from agents.cells import RESULTS, RUNS
from agents.commands.options import Tasks
from grind_env.arguments import Keeps, Reads
from grind_env.commands import Configs, JobFile, Parts
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents replicate --task rush --first 7000000 --episodes 64")(replicate)


def replicate(
    tasks: Tasks = None,
    job: JobFile = None,
    parts: Parts = 1,
    first: Annotated[
        list[int] | None,
        typer.Option("--first", min=0, help="First seed of a set; may be repeated; three sets by default."),
    ] = None,
    episodes: Annotated[
        int, typer.Option(min=2, help="Episodes of a set, on the model and on machines that are not.")
    ] = EPISODES,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    configs: Configs = None,
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

    Policies of the results, by default of all tasks that have some, are run on other episodes, whose mean costs are to
    lie where the published rows have them with 95 %. What the same code has found before is kept: interrupted, the same
    command goes on.
    """
    from agents.benchmark.replications import BEGINS, FIRSTS, write
    from agents.benchmark.replications import replicate as run
    from agents.benchmark.results import read_results
    from agents.benchmark.summary import tasks_of
    from agents.tables import check_tables

    console, known = table_console(), read_results(published)
    folder = results or (runs if tasks or first or published != RESULTS else RESULTS)
    check_tables(folder, "replicate", BEGINS)
    problems = chosen_problems(tasks or ",".join(tasks_of(known)), job, parts) if known else []
    sets = list(dict.fromkeys(first or FIRSTS))
    found = run(known, problems, sets, episodes, jobs=jobs, console=console, runs=runs, configs=configs)
    console.print(write(known, found, folder), soft_wrap=True, highlight=False, markup=False)
    console.print(f"written to {folder}: replications.csv and replications.md", highlight=False)
