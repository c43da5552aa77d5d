"""Constants of the process from a log."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import FILE, JOB, PROGRAM, Writes
from grind_env.errors import GrindError
from grind_env.shop.commands.arguments import ReportFile, prepare_report
from grind_env.terminal import table_console

WORSE = 3


def calibrate(
    job: Annotated[Path, typer.Option(help="Job file."), JOB],
    log: Annotated[
        Path | None,
        typer.Argument(metavar="[LOG]", help="Log of the spindle's power, or a table of settings."),
        FILE,
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the catalogue to this .toml file."), Writes()
    ] = None,
    program: Annotated[
        Path | None, typer.Option(help="Part program that was logged; without it LOG is a table of settings."), PROGRAM
    ] = None,
    gauge: Annotated[Path | None, typer.Option(help="What was measured of the parts, a row each."), FILE] = None,
    map_file: Annotated[Path | None, typer.Option("--map", help="Which column is what, a .toml file."), FILE] = None,
    names: Annotated[
        str, typer.Option("--fit", help="Constants to fit, with commas between; auto: those that the log tells.")
    ] = "auto",
    force: Annotated[
        bool, typer.Option("--force", help="Write it, too, where the catalogue predicts parts held out better.")
    ] = False,
    plan: Annotated[
        Path | None, typer.Option(help="Write what to log, made of the program, into this .nc file; no LOG."), Writes()
    ] = None,
    report: ReportFile = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> None:
    """Fit the process model to a log of the spindle's power, or to a table of settings.

    The log is a text with a column of the time (clock, s, ms) and one of the power (W, kW, hp, % of the rating, or
    amperes), as it was exported: any separator, decimal point or comma, gaps, rows twice or out of order; one part or
    several with pauses between. The strokes of the program are looked for in it by their pattern; the power of the
    idling spindle is read between them. The gauge file has a row for every part: part, size (stock left), Ra, burn (yes
    or no), wheel diameter; cells may be empty.

    Columns are known by their names in the usual languages. Where they are not, a map says it, by heading or number:
    tables [log] with time, power, dress, power_unit, time_unit, rated_power (W), volts, power_factor, scale
    (what the meter shows over the power, which is then not fitted); [gauge] with part, size, Ra, burn, diameter,
    nominal_size (mm), size_unit.

    What is found is written as a catalogue file, which a job takes up by [catalogue] files = ["shop.toml"]. Each
    constant has an interval that holds it with 90 %; what the measurements do not tell is kept as the catalogue has it,
    and named. What the model does not follow is left to a factor and exponents of the power, as far as parts that are
    held out in turn say so. A fit that predicts the last parts worse than the catalogue is not written without --force
    (exit status 3).

    Without LOG, --plan writes what to log: the program with a few E and picks and one dress in place of its first
    cycle, within the limits of the job.

    A table of settings has a row for each, ground with a freshly dressed wheel: wheel_speed, table_speed, downfeed,
    width, length, lead, dress_depth, volume (mm3 per mm of width), and what was measured: power, Ft, Fn, Ra, wear, G.
    """
    from rich.console import Console

    from grind_env.shop import calls
    from grind_env.shop.calibrate.errors import WorseFit
    from grind_env.shop.calibrate.show import as_data, show
    from grind_env.shop.report.calibrated import calibrated_report
    from grind_env.shop.report.document import write_page

    if plan is not None:
        print(calls.plan(_given(program, "--program, the program of which a plan is made"), job, plan))
    if plan is not None and log is None:
        return
    log = _given(log, "LOG, the log or table")
    prepare_report(report)
    constants = None if names.strip() == "auto" else [name.strip() for name in names.split(",")]
    with Console(stderr=True).status("reading") as status:
        found = calls.calibrate(
            log, job, program=program, gauge=gauge, map_file=map_file, fit=constants, told=status.update
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
        try:
            found.write(output, force=force)
        except WorseFit as error:
            print(error, file=sys.stderr)
            raise typer.Exit(WORSE) from None


def _given(file: Path | None, what: str) -> Path:
    if file is None:
        raise GrindError(f"name {what}")
    return file
