"""`python -m agents plants`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from agents.budgets import STUDY_MACHINES
from agents.cells import RESULTS, RUNS
from agents.commands.interrupted import going_on
from agents.study import Fresh, Jobs, Options, Ray, Results, Runs
from grind_env.arguments import JOB, PROBLEM
from grind_env.errors import GrindError, did_you_mean, quoted
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents plants --family meter --seeds 1 --program plate")(plants)


def plants(
    family: Annotated[
        list[str] | None,
        typer.Option("--family", help="Of machines, or `model`; may be repeated; all by default."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Machines of each family.")] = STUDY_MACHINES,
    tasks: Annotated[
        str | None,
        typer.Option(
            "--tasks",
            "--task",
            "--env",
            "--program",
            help="Part programs: plate, rail, die or files, separated by commas; these three by default.",
        ),
        PROBLEM,
    ] = None,
    episodes: Annotated[
        int, typer.Option(min=1, help="Batches of 60 parts that judge advice and agents on a machine.")
    ] = 1,
    job: Annotated[
        Path | None, typer.Option(help="Job file of that file; its name with .toml if not given."), JOB
    ] = None,
    question: Annotated[
        list[str] | None,
        typer.Option("--question", help="calibrate, optimise, advise or robust; may be repeated; all by default."),
    ] = None,
    jobs: Jobs = 2,
    ray: Ray = None,
    runs: Runs = RUNS,
    results: Results = None,
    fresh: Fresh = False,
) -> None:
    """How calibration, search and adviser hold on machines that are not the model: how far off, at what cost.

    The two families `bursts` and `graded` were kept out of all tuning of calibration and adviser. The tables keep the
    answers to other questions.
    """
    from agents.plants.asked import programs_of
    from agents.plants.machines import FAMILY_NAMES, machines
    from agents.plants.page import study
    from agents.plants.study import QUESTIONS

    families, questions = _chosen("--family", family, FAMILY_NAMES), _chosen("--question", question, tuple(QUESTIONS))
    programs = programs_of(None if tasks is None else [name.strip() for name in tasks.split(",")], job)
    whole = not (family or tasks or question) and (seeds, episodes) == (STUDY_MACHINES, 1)
    options = Options(jobs=jobs, ray=ray, runs=runs, fresh=fresh, console=table_console())
    with going_on(fresh):
        study(machines(families, seeds, programs), questions, runs, episodes).publish_to(
            results or (RESULTS if whole else runs), options
        )


def _chosen(option: str, names: list[str] | None, known: Sequence[str]) -> Sequence[str]:
    """The names that were given, or all.

    Raises:
        GrindError: there is none of a name.
    """
    for name in names or ():
        if name not in known:
            raise GrindError(f"{option} is {quoted(name)}{did_you_mean(name, known)}: choose {', '.join(known)}")
    return tuple(dict.fromkeys(names)) if names else known
