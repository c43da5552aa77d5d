"""`python -m agents benchmark`."""

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from agents.benchmark.plan import (
    EPISODES,
    FLAGSHIP,
    INTERPOLATION_EPISODES,
    PLANTS_EPISODES,
    USUAL_KINDS,
    Request,
    chosen_problems,
    planned,
)
from agents.cells import RESULTS, RUNS
from agents.commands.options import Tasks, going_on
from agents.study import Fresh, Jobs, Options, Ray, Results, Runs
from grind_env.commands import Configs, JobFile, Parts
from grind_env.errors import printable
from grind_env.policies.tuned import ConfigError
from grind_env.targets import check_own
from grind_env.task_version import TASK_VERSION
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="python -m agents benchmark --tasks core --kinds ppo,dqn --seeds 3 --episodes 256")(benchmark)


def benchmark(
    tasks: Tasks = None,
    job: JobFile = None,
    parts: Parts = 1,
    policies: Annotated[
        str | None,
        typer.Option(help="Names of policies, or RULE@1M and hindsight@SWEEPS, separated by commas; all by default."),
    ] = None,
    kinds: Annotated[
        str | None,
        typer.Option(help="Kinds of learned agents, separated by commas; may be empty; ppo and plain_gru by default."),
    ] = None,
    seeds: Annotated[int | None, typer.Option(min=0, help="Agents to train of each kind; 1 by default.")] = None,
    steps: Annotated[int | None, typer.Option(min=1, help="Training steps; by default those of the kind.")] = None,
    episodes: Annotated[int | None, typer.Option(min=2, help=f"Evaluation episodes; {EPISODES} by default.")] = None,
    interpolation_episodes: Annotated[
        int | None,
        typer.Option(
            min=0,
            help="Evaluation episodes with contexts of the split interpolation; 0 for none;"
            f" {INTERPOLATION_EPISODES} by default.",
        ),
    ] = None,
    plants_episodes: Annotated[
        int | None,
        typer.Option(
            min=0,
            help="Evaluation episodes on machines that are not the model and are held out, of what sees measurements;"
            f" 0 for none; {PLANTS_EPISODES} by default.",
        ),
    ] = None,
    jobs: Jobs = 2,
    ray: Ray = None,
    runs: Runs = RUNS,
    configs: Configs = None,
    results: Results = None,
    whole: Annotated[
        bool,
        typer.Option(
            "--grid",
            help="What is not said is that of the published results: core tasks, all policies, the variants that are"
            " named RULE@1M (tuned on a million blocks) and hindsight@SWEEPS, all kinds of agents, more seeds and"
            " episodes; and their page.",
        ),
    ] = False,
    fresh: Fresh = False,
    report: Annotated[
        bool, typer.Option("--report", help="Run nothing: write figures and README anew from the checked-in results.")
    ] = False,
) -> None:
    """Compare policies, agents trained for it among them, on the same evaluation episodes, by default of power_limited.

    How long it takes is said before it begins. Killed at any moment, the same command goes on where it was. Results
    that are in the folder already stay there, but for those of the same task whose episodes begin with another seed.
    """
    from agents.benchmark import grid, plan
    from agents.benchmark.judge import judged
    from agents.benchmark.results import CSV, TABLE, merged, read_results, write_results
    from agents.benchmark.summary import ON_SCREEN, table_of_task
    from agents.benchmark.trials import result, study

    console = table_console()
    if report:
        rebuild(results or RESULTS, console)
        return
    published = whole and all(each is None for each in (tasks, policies, kinds, steps))
    folder = results or (RESULTS if published else runs)
    check_own(folder / CSV, TABLE, "--results")
    read_results(folder)  # better now than after hours of work
    chosen = chosen_problems(tasks or ("core" if whole else FLAGSHIP), job, parts)
    if whole:
        cells = grid.grid(chosen, listed(policies), listed(kinds), seeds)
    else:
        trained = list(USUAL_KINDS) if kinds is None else listed(kinds) or []
        cells = planned(chosen, listed(policies), trained, 1 if seeds is None else seeds)
    usual = grid if whole else plan
    episodes = episodes or usual.EPISODES
    if interpolation_episodes is None:
        interpolation_episodes = usual.INTERPOLATION_EPISODES
    if plants_episodes is None:
        plants_episodes = usual.PLANTS_EPISODES
    request = Request(
        episodes=episodes,
        interpolation_episodes=interpolation_episodes,
        plants_episodes=plants_episodes,
        steps=steps,
        runs=runs,
        configs=configs,
        fresh=fresh,
    )
    made = study("benchmark", cells, request, files={})
    with going_on(fresh):
        found, failed = made.find(Options(jobs=jobs, ray=ray, runs=runs, fresh=fresh, console=console))
    before = read_results(folder)
    table = judged(merged(before, [result(each) for each in found.values()]))
    write_results(table, folder)
    for problem in chosen:
        if any(each.task == problem.name for each in table):
            title = problem.simulation().task.title
            said = f"{title}: {episodes} paired episodes"
            table_of_task(table, problem.name, said, ON_SCREEN).print(console)
    console.print(printable(f"written to {folder}: benchmark.parquet and .csv"), highlight=False, markup=False)
    if gone := sorted(
        {f"{task} {policy}" for task, policy, _ in {each.key for each in before} - {each.key for each in table}}
    ):
        print(f"agents: of other episodes, and no longer in the table: {', '.join(gone)}", file=sys.stderr)
    if whole and not failed:
        rebuild(folder, console)
    if failed:
        print(f"agents: {len(failed)} of {len(cells)} cells failed: {', '.join(map(str, failed))}", file=sys.stderr)
        raise typer.Exit(1)


def rebuild(folder: Path, console: Console) -> None:
    """Write the figures below a folder of results, and the README if they are the checked-in ones."""
    from agents.benchmark.figures import write_figures
    from agents.benchmark.readme import PAGE, write_readme
    from agents.benchmark.results import read_results

    table = read_results(folder)
    if not table:
        raise ConfigError(
            f"there are no results in {folder} of task version {TASK_VERSION}:"
            f" run the benchmark with --results {folder} first"
        )
    for path in write_figures(table, folder / "figures"):
        console.print(f"written to {path}", highlight=False)
    if folder.resolve() == RESULTS:
        write_readme(table)
        console.print(f"written to README.md and {PAGE}", highlight=False)


def listed(names: str | None) -> list[str] | None:
    """The names in a comma-separated list."""
    return None if names is None else [name.strip() for name in names.split(",") if name.strip()]
