"""The commands of `grind` for one's own programs, jobs and logs."""

from pathlib import Path
from typing import Annotated

import typer

ProgramFile = Annotated[Path, typer.Argument(metavar="PROGRAM", help="Part program, a text file.")]
JobFile = Annotated[Path | None, typer.Option("--job", help="Job file; PROGRAM with .toml if not given.")]


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command(epilog="Example: grind init my_part")(init)
    app.command(epilog="Example: grind job --template > plate.toml")(job)
    app.command(epilog="Example: grind catalogue wheel a60j")(catalogue)
    app.command(epilog="Example: grind report plate.nc --job plate.toml -o plate.html")(report)
    app.command(epilog="Example: grind advise plate.nc --parts 30 --measurements measured.csv --follow")(advise)


def report(
    program: ProgramFile,
    job: JobFile = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The .html file; PROGRAM with .html if not given.")
    ] = None,
    block_delete: Annotated[bool, typer.Option("--block-delete", help="Skip blocks that begin with '/'.")] = False,
) -> None:
    """Grind with a program as `grind run` does, and write it up as one HTML file that works offline and prints on A4.

    Verdict, margin to each limit, a table of the blocks, plots, parts, dresses, cost, warnings, the program with
    remarks, and what the numbers rest on. Needs the extra [shop].
    """
    from dataclasses import replace

    from grind_env import control
    from grind_env.errors import printable
    from grind_env.machine.grind import grind
    from grind_env.machine.job_file import job_beside, load_job
    from grind_env.shop.report.document import write_page
    from grind_env.shop.report.run import run_report

    path = job_beside(program) if job is None else job
    programs, settings = control.read_file(program), load_job(path)
    record = grind(programs, settings, control=replace(settings.control, block_delete=block_delete))
    written = program.with_suffix(".html") if output is None else output
    write_page(written, run_report(record, programs, settings, (program, path)))
    print(printable(f"written: {written}"))


def advise(
    program: ProgramFile,
    job: JobFile = None,
    policy: Annotated[
        str | None,
        typer.Option(help="By name, a constant such as E12D0, or a .safetensors file; look_ahead if not given."),
    ] = None,
    parts: Annotated[int, typer.Option(help="Parts of the batch.")] = 30,
    by: Annotated[str, typer.Option(help="block or part: what a row of readings is of.")] = "block",
    measurements: Annotated[Path | None, typer.Option(help="CSV with a row for each block or part.")] = None,
    follow: Annotated[bool, typer.Option("--follow", help="Wait for further rows of that file.")] = False,
    state: Annotated[Path | None, typer.Option(help="State; PROGRAM with .advise.json if not given.")] = None,
    write: Annotated[
        Path | None, typer.Option(help="Write E and D as #101=..., #102=... into this file before each block.")
    ] = None,
    restart: Annotated[bool, typer.Option("--restart", help="Begin anew.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print advice as JSON objects, one a line.")] = False,
) -> None:
    """Advise at the machine: E and D of the next cycle block from what was measured of those before, with the reason.

    Readings are typed in, or come as JSON lines on standard input, or as rows of a CSV; all of them may be missing:
    mean_power, first_power, peak_power (W above idle), and of a finished part size_error, Ra, Ra_before (um), diameter
    (mm), new_lot, new_wheel (1 or 0); E and D where they were not the advised ones. It goes on where it was stopped,
    and logs everything into a CSV beside its state.
    """
    from grind_env.shop.advise.command import open_session

    session = open_session(
        program,
        job,
        policy=policy,
        parts=parts,
        by=by,
        measurements=measurements,
        follow=follow,
        state=state,
        values=write,
        as_json=as_json,
    )
    if restart:
        session.begin()
    session.resume()
    session.run()


def init(folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Is made if need be.")]) -> None:
    """Write a program, its job, a catalogue of the shop and a notebook into a folder; they run as they are.

    Nothing is overwritten.
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
    from grind_env.shop.start.template import job_template

    if not template:
        raise GrindError("say what of a job is wanted: grind job --template prints one with every key")
    print(job_template(), end="")


def catalogue(
    kind: Annotated[str | None, typer.Argument(help="material, wheel, dresser, fluid or machine.")] = None,
    name: Annotated[str | None, typer.Argument(help="An entry of that kind.")] = None,
    file: Annotated[list[Path] | None, typer.Option(help="A catalogue of yours on top; repeatable.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """List materials, wheels, dressers, fluids and machines, or show an entry: values, units, ranges and source."""
    import json

    from rich.console import Console

    from grind_env.shop.entries import catalogue_data, print_catalogue

    if as_json:
        print(json.dumps(catalogue_data(kind, name, file or ())))
    else:
        print_catalogue(kind, name, file or (), Console(markup=False, highlight=False))
