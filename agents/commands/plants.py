"""`python -m agents plants`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from agents.budgets import STUDY_MACHINES
from agents.cells import RESULTS, RUNS
from grind_env.arguments import JOB, Keeps, Reads, task_programs
from grind_env.errors import GrindError, did_you_mean, quoted
from grind_env.terminal import table_console


class ArgumentError(GrindError):
    """A name that the study does not have."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents plants --family meter --seeds 1 --program plate")(plants)


def plants(
    family: Annotated[
        list[str] | None,
        typer.Option("--family", help="Of machines, or `model`; may be repeated; all by default."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Machines of each family.")] = STUDY_MACHINES,
    program: Annotated[
        list[str] | None,
        typer.Option("--program", help="plate, rail or die, or a file; may be repeated; these three by default."),
        Reads(programs=task_programs),
    ] = None,
    job: Annotated[
        Path | None, typer.Option(help="Job file of that file; its name with .toml if not given."), JOB
    ] = None,
    question: Annotated[
        list[str] | None,
        typer.Option("--question", help="calibrate, optimise, advise or robust; may be repeated; all by default."),
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept."), Keeps()] = RUNS,
    results: Annotated[
        Path | None,
        typer.Option(
            help="Folder of plants.csv and plants.md, in which other questions stay; of some cells alone, by default "
            "that of what is kept."
        ),
        Keeps(),
    ] = None,
) -> None:
    """How calibration, search and adviser hold on machines that are not the model: how far off, at what cost.

    The two families `bursts` and `graded` were kept out of all tuning of calibration and adviser. What the same code
    has found before is kept: interrupted, the same command goes on.
    """
    from agents.plants.asked import programs_of
    from agents.plants.machines import FAMILY_NAMES, machines
    from agents.plants.page import BEGINS, rich_tables, write
    from agents.plants.study import QUESTIONS, run_study
    from agents.tables import check_tables

    console = table_console()
    families, questions = _chosen("--family", family, FAMILY_NAMES), _chosen("--question", question, tuple(QUESTIONS))
    programs = programs_of(program, job)
    whole = not (family or program or question) and seeds == STUDY_MACHINES
    folder = results or (RESULTS if whole else runs)
    check_tables(folder, "plants", BEGINS)
    found = run_study(machines(families, seeds, programs), questions, jobs=jobs, console=console, runs=runs)
    for each in rich_tables(found):
        console.print(each)
    write(found, folder)
    console.print(f"written to {folder}: plants.csv and plants.md", highlight=False)


def _chosen(option: str, names: list[str] | None, known: Sequence[str]) -> Sequence[str]:
    """The names that were given, or all.

    Raises:
        ArgumentError: there is none of a name.
    """
    for name in names or ():
        if name not in known:
            raise ArgumentError(f"{option} is {quoted(name)}{did_you_mean(name, known)}: choose {', '.join(known)}")
    return tuple(dict.fromkeys(names)) if names else known
