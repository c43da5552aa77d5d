"""`python -m agents benchmark`."""

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from agents.benchmark import plan
from agents.commands.options import Tasks, going_on
from agents.evaluation_cache import RESULTS, RUNS
from agents.study import Fresh, Hours, Jobs, Options, Ray, Results, Runs
from grind_env.message_text import printable
from grind_env.output_checks import check_replaceable
from grind_env.policies.tuned_parameters import ConfigError
from grind_env.policy_commands import Configs, JobFile, Parts
from grind_env.task_version import TASK_VERSION
from grind_env.terminal_output import table_console


def benchmark(
    tasks: Tasks = None,
    job: JobFile = None,
    parts: Parts = 1,
    policies: Annotated[str | None, typer.Option(help="Rules and planners; default all.")] = None,
    kinds: Annotated[str | None, typer.Option(help="ppo,plain_gru (default),plain_belief,robust; or NAME@3M.")] = None,
    seeds: Annotated[int | None, typer.Option(min=0, help="Trainings of each agent; default 1.")] = None,
    steps: Annotated[int | None, typer.Option(min=1, help="Training steps; default that of the kind.")] = None,
    episodes: Annotated[int | None, typer.Option(min=2, help=f"Evaluation episodes; default {plan.EPISODES}.")] = None,
    interpolation_episodes: Annotated[
        int | None,
        typer.Option(min=0, help=f"Episodes of the split interpolation; default {plan.INTERPOLATION_EPISODES}."),
    ] = None,
    plants_episodes: Annotated[
        int | None, typer.Option(min=0, help=f"Episodes on held-out machines; default {plan.PLANTS_EPISODES}.")
    ] = None,
    jobs: Jobs = 2,
    ray: Ray = None,
    runs: Runs = RUNS,
    configs: Configs = None,
    results: Results = None,
    full: Annotated[bool, typer.Option("--full", help="Use the defaults of the published results.")] = False,
    fresh: Fresh = False,
    hours: Hours = False,
    report: Annotated[bool, typer.Option("--report", help="Train nothing: write figures and pages anew.")] = False,
) -> None:
    """Train agents and compare them with rules and planners.

    The default task is power_limited. To resume, repeat the command.
    """
    from agents.benchmark import grid
    from agents.benchmark.results import CSV, TABLE, Result, merged, read_results, result, write_results
    from agents.benchmark.scoring import judged
    from agents.benchmark.summary import ON_SCREEN, table_of_task
    from agents.benchmark.trials import study

    console = table_console()
    if report:
        rebuild(results or RESULTS, console)
        return
    published = full and all(each is None for each in (tasks, policies, kinds, steps))
    folder = results or (RESULTS if published else runs)
    check_replaceable(folder / CSV, TABLE, "--results")
    before = read_results(folder)  # a damaged file fails now, not after hours of work
    chosen = plan.chosen_problems(tasks or ("core" if full else plan.FLAGSHIP), job, parts)
    if full:
        cells = grid.grid(chosen, listed(policies), listed(kinds), seeds)
    else:
        trained = list(plan.USUAL_KINDS) if kinds is None else listed(kinds) or []
        cells = plan.planned(chosen, listed(policies), trained, 1 if seeds is None else seeds)
    usual = grid if full else plan
    episodes = episodes or usual.EPISODES
    if interpolation_episodes is None:
        interpolation_episodes = usual.INTERPOLATION_EPISODES
    if plants_episodes is None:
        plants_episodes = usual.PLANTS_EPISODES
    request = plan.Request(
        episodes=episodes,
        interpolation_episodes=interpolation_episodes,
        plants_episodes=plants_episodes,
        steps=steps,
        runs=runs,
        configs=configs,
        fresh=fresh,
    )
    made = study("benchmark", cells, request, files={}, finished=() if fresh else before)
    asked = Options(jobs=jobs, ray=ray, runs=runs, fresh=fresh, hours=hours, console=console)

    def write(found: Iterable[Mapping[str, Any]]) -> Sequence[Result]:
        made = judged(merged(before, [result(each) for each in found]))
        write_results(made, folder)
        return made

    try:
        with going_on(fresh):
            found, failed = made.find(asked)
    except typer.Exit as end:
        if end.exit_code:  # keep the finished rows of an interrupted command
            write(row for row in (made.cached(trial, runs.absolute()) for trial in made.trials) if row is not None)
        raise
    table = write(found.values())
    for problem in chosen:
        if any(each.task == problem.name for each in table):
            title = problem.simulation().task.title
            said = f"{title}: {episodes} paired episodes"
            table_of_task(table, problem.name, said, ON_SCREEN).print(console)
    console.print(printable(f"written to {folder}: benchmark.parquet and .csv"), highlight=False, markup=False)
    if full and not failed:
        rebuild(folder, console)
    if failed:
        print(f"agents: {len(failed)} of {len(cells)} runs failed: {', '.join(map(str, failed))}", file=sys.stderr)
        raise typer.Exit(1)


def rebuild(folder: Path, console: Console) -> None:
    """Write the figures below a folder of results, and the README if these are the checked-in results."""
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
    """Return the names in a comma-separated list."""
    return None if names is None else [name.strip() for name in names.split(",") if name.strip()]
