"""The commands of `grind` for one's own programs, jobs and logs."""

import json
from pathlib import Path
from typing import Annotated

import typer

NOT_BETTER, INFEASIBLE = 3, 4
"""Exit statuses of `optimise`."""

ProgramFile = Annotated[Path, typer.Argument(metavar="PROGRAM", help="Part program, a text file.")]
JobFile = Annotated[Path | None, typer.Option("--job", help="Job file; PROGRAM with .toml if not given.")]
Runs = Annotated[int, typer.Option(min=1, max=1000, help="Runs of the program in a batch; the wheel carries over.")]
ReportFile = Annotated[Path | None, typer.Option("--report", help="Write the result up as this .html file.")]
Seed = Annotated[int, typer.Option(min=0, help="Of lots and search; the same seed finds the same.")]


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command(epilog="Example: grind init my_part")(init)
    app.command(epilog="Example: grind job --template > plate.toml")(job)
    app.command(epilog="Example: grind catalogue wheel a60j")(catalogue)
    app.command(epilog="Example: grind report plate.nc --job plate.toml -o plate.html")(report)
    app.command(epilog="Example: grind optimise plate.nc --vary E,D,J --margin power=.85 -o plate_opt.nc")(optimise)
    app.command(epilog="Example: grind sweep plate.nc --E 8000..24000 --dress-every 1..20 --plot plate.png")(sweep)
    app.command(epilog="Example: grind advise plate.nc --parts 30 --measurements measured.csv --follow")(advise)
    app.command(
        epilog="Example: grind calibrate log.csv --program plate.nc --job plate.toml --gauge parts.csv -o shop.toml"
    )(calibrate)


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


def optimise(
    program: ProgramFile,
    job: JobFile = None,
    vary: Annotated[
        str | None,
        typer.Option(
            help="What may change: E, D, J, L of cycle blocks, lead, depth, passes of dress programs; words that a "
            "block lacks are then added. If not given, those E and D that are there."
        ),
    ] = None,
    bounds: Annotated[
        list[str] | None, typer.Option(help="As E=5000..25000,J=.002..02, in units of the program; lead a revolution.")
    ] = None,
    rounding: Annotated[
        list[str] | None, typer.Option("--round", help="Of what values are multiples: E=100,J=.001.")
    ] = None,
    margin: Annotated[
        list[str] | None,
        typer.Option(help="Share of a limit that 95 of 100 parts must keep: power=.85,temp=.8,Ra=.85,size=.7."),
    ] = None,
    keep: Annotated[list[str] | None, typer.Option(help="Cycle blocks that stay as they are: N80.")] = None,
    unroll: Annotated[
        bool, typer.Option("--unroll", help="Write M98 calls out, so that each has words of its own.")
    ] = False,
    parts: Runs = 50,
    budget: Annotated[str, typer.Option(help="Time of the search: 60s, 2min.")] = "60s",
    seed: Seed = 1,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the program here, if it is better.")
    ] = None,
    report: ReportFile = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> None:
    """Find better words for a program: E and D, or others, with which a part costs less and keeps its limits.

    The program is replayed on lots of the job ([lots]) for batches of parts, in which the wheel carries over. The best
    one is judged on 256 lots that the search has not seen, each ground with both programs. It is written only if the
    upper end of the 95 % interval of the difference is below 0, and if 95 of 100 parts keep every limit with its
    margin. Only the words that change are changed in the text, and a comment at each block says what it was; a block
    that runs several times keeps one value for all its runs.

    The report is written whatever was found.

    Exit status 3: no better program was found. 4: no program keeps the limits.
    """
    from rich.console import Console

    from grind_env.files import write_atomically
    from grind_env.machine.job_file import job_beside, load_job
    from grind_env.shop.optimise.optimise import optimise as search
    from grind_env.shop.optimise.outcome import Verdict
    from grind_env.shop.optimise.table import as_data, print_optimised
    from grind_env.shop.optimise.wishes import seconds_of, wishes_of
    from grind_env.shop.progress import progress
    from grind_env.shop.report.document import write_page
    from grind_env.shop.report.optimised import optimised_report

    wishes = wishes_of(vary, bounds or (), rounding or (), keep or (), margin or ())
    seconds = seconds_of(budget)
    with progress() as advance:
        found = search(program, job, wishes, parts=parts, seconds=seconds, seed=seed, unroll=unroll, progress=advance)
    if found.verdict is Verdict.BETTER and output is not None:
        write_atomically(output, lambda path: path.write_bytes(found.data))
    if as_json:
        print(json.dumps(as_data(found)))
    else:
        print_optimised(found, Console())
        if found.verdict is Verdict.BETTER:
            print("name a file with -o to have it" if output is None else f"written to {output}")
    if report is not None:
        path = job_beside(program) if job is None else job
        write_page(report, optimised_report(found, load_job(path), {"program": program, "job": path}))
    statuses = {Verdict.NOT_BETTER: NOT_BETTER, Verdict.INFEASIBLE: INFEASIBLE}
    if found.verdict in statuses:
        raise typer.Exit(statuses[found.verdict])


def sweep(
    program: ProgramFile,
    job: JobFile = None,
    speed: Annotated[
        str | None, typer.Option("--E", help="As 8000..24000, mm/min, of the first block; others keep their ratio.")
    ] = None,
    every: Annotated[
        str | None, typer.Option("--dress-every", help="As 1..20: D on every n-th part only, instead of on each.")
    ] = None,
    lead: Annotated[str | None, typer.Option(help="Of the dress, as .05..0.2, mm a revolution.")] = None,
    depth: Annotated[str | None, typer.Option(help="Of the dress, as .005..0.03, mm a pass.")] = None,
    parts: Runs = 50,
    seed: Seed = 1,
    plot: Annotated[Path | None, typer.Option(help="Draw it into this .png, .svg or .pdf file.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> None:
    """What a part costs, and how near its limits are, over E and dress interval, then over lead and depth of the dress.

    Every point is ground on the same lots of the job ([lots]), in batches of parts in which the wheel carries over.
    Lead and depth are swept with the best E and dress interval. Without any range E is swept from half to twice its
    value, and dress intervals from 1 to 20.

    Columns: E (mm/min), every (parts from dress to dress), lead (mm a revolution), depth (mm a pass), cost, time, Ra
    (um), highest power (kW) and temperature rise (K), size error (um), scrap, and whether 95 of 100 parts keep every
    limit; if not, what they keep of the worst one.
    """
    from rich.console import Console

    from grind_env.shop.optimise.wishes import range_of
    from grind_env.shop.progress import progress
    from grind_env.shop.sweep.figure import plot_sweep
    from grind_env.shop.sweep.study import Ranges
    from grind_env.shop.sweep.study import sweep as study
    from grind_env.shop.sweep.table import as_data, print_sweep

    def ends(option: str, text: str | None) -> tuple[float, float] | None:
        if text is None:
            return None
        low, high = range_of(f"--{option}", option, text)
        return float(low), float(high)

    intervals = ends("dress-every", every)
    ranges = Ranges(
        E=ends("E", speed),
        every=None if intervals is None else (int(intervals[0]), int(intervals[1])),
        lead=ends("lead", lead),
        depth=ends("depth", depth),
    )
    with progress() as advance:
        found = study(program, job, ranges, parts=parts, seed=seed, progress=advance)
    if plot is not None:
        plot_sweep(found, plot)
    if as_json:
        print(json.dumps(as_data(found)))
    else:
        print_sweep(found, Console())


def calibrate(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="Log of the spindle's power, or a table of settings.")],
    job: Annotated[Path, typer.Option(help="Job file.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the catalogue to this .toml file.")
    ] = None,
    program: Annotated[
        Path | None, typer.Option(help="Part program that was logged; without it LOG is a table of settings.")
    ] = None,
    gauge: Annotated[Path | None, typer.Option(help="What was measured of the parts, a row each.")] = None,
    map_file: Annotated[Path | None, typer.Option("--map", help="Which column is what, a .toml file.")] = None,
    names: Annotated[
        str, typer.Option("--fit", help="Constants to fit, with commas between; auto: those that the log tells.")
    ] = "auto",
    report: ReportFile = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> None:
    """Fit the process model to a log of the spindle's power, or to a table of settings.

    The log is a text with a column of the time (clock, s, ms) and one of the power (W, kW, hp, % of the rating, or
    amperes), as it was exported: any separator, decimal point or comma, gaps, rows twice or out of order; one part or
    several with pauses between. The strokes of the program are looked for in it by their pattern; the power of the
    idling spindle is read between them. The gauge file has a row for every part: part, size (stock left), Ra, burn (yes
    or no),
    wheel diameter; cells may be empty.

    Columns are known by their names in the usual languages. Where they are not, a map says it, by heading or number:
    tables [log] with time, power, dress, power_unit, time_unit, rated_power (W), volts, power_factor; [gauge] with
    part, size, Ra, burn, diameter, nominal_size (mm), size_unit.

    What is found is written as a catalogue file, which a job takes up by [catalogue] files = ["shop.toml"]. Each
    constant has an interval that holds it with 90 %; what the measurements do not tell is kept as the catalogue has it,
    and named.

    A table of settings has a row for each, ground with a freshly dressed wheel: wheel_speed, table_speed, downfeed,
    width, length, lead, dress_depth, volume (mm3 per mm of width), and what was measured: power, Ft, Fn, Ra, wear, G.
    """
    from rich.console import Console

    from grind_env.shop.calibrate.calibration import calibrate as from_log
    from grind_env.shop.calibrate.result import write_catalogue
    from grind_env.shop.calibrate.show import as_data, show
    from grind_env.shop.calibrate.table import calibrate_table
    from grind_env.shop.report.calibrated import calibrated_report
    from grind_env.shop.report.document import write_page

    with Console(stderr=True).status("reading") as status:
        if program is None:
            found = calibrate_table(log, job, map_file=map_file, names=names, told=status.update)
        else:
            found = from_log(log, program, job, gauge=gauge, map_file=map_file, names=names, told=status.update)
    if as_json:
        print(json.dumps(as_data(found)))
    else:
        show(found, Console(markup=False, highlight=False))
    if report is not None:
        named = {"log" if program else "table": log, "program": program, "gauge file": gauge, "job": job}
        write_page(report, calibrated_report(found, {name: path for name, path in named.items() if path is not None}))
    if output is not None:
        write_catalogue(found, output)
