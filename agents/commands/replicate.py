"""`python -m agents replicate`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.benchmark.plan import EPISODES, chosen_problems
from agents.cells import RESULTS, RUNS
from agents.commands.interrupted import going_on
from agents.commands.options import Tasks
from agents.study import Fresh, Jobs, Options, Ray, Results, Runs
from agents.tables import check_tables
from grind_env.arguments import Reads
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
    published: Annotated[
        Path,
        typer.Option(help="Folder of benchmark.parquet, the results that are replicated."),
        Reads(within="benchmark.parquet"),
    ] = RESULTS,
    episodes: Annotated[
        int, typer.Option(min=2, help="Episodes of a set, on the model and on machines that are not.")
    ] = EPISODES,
    jobs: Jobs = 2,
    ray: Ray = None,
    runs: Runs = RUNS,
    configs: Configs = None,
    results: Results = None,
    fresh: Fresh = False,
) -> None:
    """Re-run published results of the benchmark on new seeds, by which nothing was chosen.

    Policies of the results, by default of all tasks that have some, are run on other episodes, whose mean costs are to
    lie where the published rows have them with 95 %.
    """
    from agents.benchmark.replications import BEGINS, FIRSTS
    from agents.benchmark.replications import replicate as study
    from agents.benchmark.results import read_results
    from agents.benchmark.summary import tasks_of

    known = read_results(published)
    folder = results or (runs if tasks or first or published != RESULTS else RESULTS)
    check_tables(folder, "replicate", BEGINS)
    problems = chosen_problems(tasks or ",".join(tasks_of(known)), job, parts) if known else []
    options = Options(jobs=jobs, ray=ray, runs=runs, fresh=fresh, console=table_console())
    made = study(known, problems, list(dict.fromkeys(first or FIRSTS)), episodes, configs, options)
    with going_on(fresh):
        made.publish_to(folder, options)
