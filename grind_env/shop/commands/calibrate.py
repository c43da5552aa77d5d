"""`grind calibrate`: constants of the process from a log."""

import json
from pathlib import Path
from typing import Annotated

import typer

from grind_env.errors import GrindError
from grind_env.file_arguments import FILE, JOB, PROGRAM, Writes
from grind_env.shop.commands.arguments import AsJson, ReportFile, prepare_report
from grind_env.terminal_output import table_console

NOT_TO_USE = 3


def calibrate(
    job: Annotated[Path, typer.Option(help="Job file (.toml)."), JOB],
    log: Annotated[Path | None, typer.Argument(metavar="[LOG]", help="Power log, or table of settings."), FILE] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write the fitted catalogue."), Writes()] = None,
    program: Annotated[Path | None, typer.Option(help="Logged program; without it LOG is a table."), PROGRAM] = None,
    gauge: Annotated[Path | None, typer.Option(help="File of Ra, size, burn: a row for each part."), FILE] = None,
    map_file: Annotated[Path | None, typer.Option("--columns", help="Names of the columns (.toml)."), FILE] = None,
    names: Annotated[str, typer.Option("--fit", help="Constants to fit: chip_energy,wheel.roughness.")] = "auto",
    force: Annotated[bool, typer.Option("--force", help="Write it even if the old catalogue is better.")] = False,
    plan: Annotated[Path | None, typer.Option(help="Write a test program, made from --program."), Writes()] = None,
    report: ReportFile = None,
    as_json: AsJson = False,
) -> None:
    """Fit the process model to a power log or a table of settings.

    To use the written file, add it at the end of `files` in [catalogue] of the job. See docs/howto/calibrate.md.
    Exit status 3: do not use the fit; the old catalogue predicts left-out parts better.
    """
    from rich.console import Console

    from grind_env.shop import python_api
    from grind_env.shop.calibrate.calibration_output import as_data, show
    from grind_env.shop.report.calibration_report import calibrated_report
    from grind_env.shop.report.document import write_page

    if plan is not None:
        print(python_api.plan(_given(program, "--program, the program of which a plan is made"), job, plan))
    if plan is not None and log is None:
        return
    log = _given(log, "LOG, a log of the power or a table of settings")
    prepare_report(report)
    constants = None if names.strip() == "auto" else [name.strip() for name in names.split(",")]
    with Console(stderr=True).status("reading") as status:
        found = python_api.calibrate(
            log, job, program=program, gauge=gauge, map_file=map_file, fit=constants, report_stage=status.update
        )
    if as_json:
        print(json.dumps(as_data(found)))
    else:
        show(found, table_console())
    if report is not None:
        named = {"log" if program else "table": log, "program": program, "gauge file": gauge, "job": job}
        files = {name: path for name, path in named.items() if path is not None}
        write_page(report, calibrated_report(found, files))
    if output is not None:
        found.write(output, force=force)
        if not as_json:
            to_do = "" if found.verdict.level == "bad" else f"; next: name it under [catalogue] files in {job}"
            print(f"written to {output}{to_do}")
    if found.verdict.level == "bad" and not force:
        raise typer.Exit(NOT_TO_USE)


def _given(file: Path | None, what: str) -> Path:
    if file is None:
        raise GrindError(f"name {what}")
    return file
