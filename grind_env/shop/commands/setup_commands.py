"""First commands: a folder to start from, a job template, the catalogue, and a check of the installation."""

import json
import shlex
from pathlib import Path
from typing import Annotated

import typer

from grind_env.file_arguments import FILE, Keeps
from grind_env.terminal_output import table_console


def init(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Folder to write; created if it is missing."), Keeps()
    ],
) -> None:
    """Write an example: program, job, catalogue, notebook, log.

    The log is an invented example for `grind calibrate`; replace it by a log of your spindle. No file is overwritten.
    """
    from grind_env.message_text import printable
    from grind_env.shop.start.starter_folder import start_folder

    program, *others = start_folder(folder)
    print(printable(f"written: {program}, {', '.join(path.name for path in others)}"))
    print(printable(f"next: grind run {shlex.quote(str(program))}"))


def job(template: Annotated[bool, typer.Option("--template", help="Print a complete job file.")] = False) -> None:
    """Print a job file with every key, its unit, range and default."""
    from grind_env.errors import GrindError
    from grind_env.shop.start.job_template import job_template

    if not template:
        raise GrindError("say what of a job is wanted: grind job --template prints one with every key")
    print(job_template(), end="")


def catalogue(
    kind: Annotated[str | None, typer.Argument(help="material, wheel, dresser, fluid or machine.")] = None,
    name: Annotated[str | None, typer.Argument(help="Name of the entry.")] = None,
    file: Annotated[
        list[Path] | None, typer.Option(help="Your catalogue (.toml), read in addition; repeatable."), FILE
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """List or show materials, wheels, dressers, fluids and machines."""
    from grind_env.shop.catalogue_listing import catalogue_data, print_catalogue

    if as_json:
        print(json.dumps(catalogue_data(kind, name, file or ())))
    else:
        print_catalogue(kind, name, file or (), table_console())


def doctor(as_json: Annotated[bool, typer.Option("--json", help="Print a JSON list.")] = False) -> None:
    """Check the installation: versions, kernels, speed, extras.

    A missing extra is no error; the last column says how to install it.
    """
    from grind_env.data_table import Column, table_of
    from grind_env.shop.doctor import findings

    found = findings()
    if as_json:
        print(json.dumps([each._asdict() for each in found]))
        return
    columns = (Column("what"), Column("found", wrap=True), Column("to do", wrap=True))
    table_of(columns, found).print(table_console())


def warm_up() -> None:
    """Compile all kernels now, so that later commands start at once.

    The cache is the user's, or NUMBA_CACHE_DIR. Policies and networks compile a few kernels more at their first use.
    """
    from rich.console import Console
    from rich.progress import track

    from grind_env.kernel.cache import cache_folder
    from grind_env.shop.kernel_warm_up import kernels, uses, warm_up

    every, console = uses(), Console(stderr=True)
    shown = track(
        warm_up(every), "compiling", total=len(every), console=console, transient=True, disable=not console.is_terminal
    )
    for name, seconds, new, left_out in shown:
        print(f"{name:40} {left_out or f'{seconds:4.1f} s {new:3} new'}", flush=True)
    print(f"{kernels()} kernels in {cache_folder()}")
