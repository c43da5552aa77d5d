"""A folder to start from, and what a job file and the catalogue may say."""

import json
from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import FILE, Keeps
from grind_env.terminal import table_console


def init(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Is made if need be."), Keeps()],
) -> None:
    """Write a program, its job, a catalogue, a notebook and a sample log that run.

    The log is made up, for `grind calibrate`: a log of your spindle takes its place. Nothing is overwritten.
    """
    from grind_env.errors import printable
    from grind_env.shop.start.folder import start_folder

    program, *others = start_folder(folder)
    print(printable(f"written: {program}, {', '.join(path.name for path in others)}"))
    print(printable(f"next: grind run {program}"))


def job(
    template: Annotated[bool, typer.Option("--template", help="Print a job file that runs, with every key.")] = False,
) -> None:
    """Print a job file with every key: unit, range, meaning and default."""
    from grind_env.errors import GrindError
    from grind_env.shop.start.folder import job_template

    if not template:
        raise GrindError("say what of a job is wanted: grind job --template prints one with every key")
    print(job_template(), end="")


def catalogue(
    kind: Annotated[str | None, typer.Argument(help="material, wheel, dresser, fluid or machine.")] = None,
    name: Annotated[str | None, typer.Argument(help="An entry of that kind.")] = None,
    file: Annotated[list[Path] | None, typer.Option(help="A catalogue of yours on top; repeatable."), FILE] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """List materials, wheels, dressers, fluids and machines, or show an entry: values, units, ranges and source."""
    from grind_env.shop.entries import catalogue_data, print_catalogue

    if as_json:
        print(json.dumps(catalogue_data(kind, name, file or ())))
    else:
        print_catalogue(kind, name, file or (), table_console())
