"""The `grind` command."""

import io
import json
import shlex
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

from grind_env.command_exit import BAD_INPUT, command
from grind_env.command_help import HelpfulGroup
from grind_env.errors import GrindError
from grind_env.figures import commands as figure_commands
from grind_env.file_arguments import JOB, PROBLEM, Application, Writes
from grind_env.message_text import printable, quoted
from grind_env.policy_commands import evaluate, play, verify
from grind_env.shop.commands import EXAMPLES, arguments
from grind_env.task_version import TASK_VERSION
from grind_env.terminal_output import table_console
from grind_env.training import train_command as training_command

if TYPE_CHECKING:
    from grind_env.control import Control, Programs, Report

GROUND_SCRAP = 1


class GrindCommands(HelpfulGroup):
    """The commands of `grind` in groups."""

    groups: ClassVar = {
        "Run": "check trace run report",
        "Improve": "sweep optimise calibrate",
        "At the machine": "advise",
        "Learn": "train evaluate verify play tasks",
        "Reference": "init job catalogue facts figure warm-up doctor",
    }


app = Application(cls=GrindCommands)

Strokes = Annotated[int, typer.Option(help="Strokes assumed for a G81 without an end.")]
Acceleration = Annotated[float | None, typer.Option(help="Acceleration of the axes, mm/s2; default of --job, or 1000.")]
MachineJob = Annotated[Path | None, typer.Option("--job", help="Job file, default none; adds times and warnings."), JOB]
Radius = Annotated[
    list[str] | None,
    typer.Option(help="Radius for G41 and G42, mm: 0.5, or 2=0.5 for offset 2; repeatable."),
]


FIRST_STEPS = """\
grind_env simulates the surface-grinding cycles of a CNC grinder. Three commands to begin with:

  grind init my_part              a program, its job, a catalogue and a notebook to start from
  grind run my_part/part.nc       grinds a part: time, size, Ra, power, temperature, cost
  grind report my_part/part.nc    the same as one HTML page, to read and to print

All commands: grind --help"""


def _version(asked: bool) -> None:
    if asked:
        print(f"grind_env {version('grind_env')}, tasks of version {TASK_VERSION}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def commands(
    context: typer.Context,
    asked: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Simulate and optimise CNC surface grinding; start with `grind init my_part`."""
    if context.invoked_subcommand is None:
        print(FIRST_STEPS)


@app.command(epilog="grind check slot.nc\ngrind check slot.nc --job slot.toml --json")
def check(
    program: arguments.ProgramFile,
    strokes: Strokes = 10,
    acceleration: Acceleration = None,
    block_delete: arguments.BlockDelete = False,
    max_blocks: arguments.MaxBlocks = None,
    radius: Radius = None,
    groove_retract: arguments.GrooveRetract = None,
    variables: arguments.Variables = None,
    job: MachineJob = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Check a program: report all syntax errors, and time and motions.

    All syntax errors are listed (at most 1000). If the program then fails in the simulation, only the first failure is.
    With --job the program is ground as by `grind run`: the time has loading, travel and dresses, and warnings follow.
    """
    from grind_env import control
    from grind_env.control.program_check import ended_at, report_record, summary

    try:
        settings = _control(job, strokes, acceleration, block_delete, max_blocks, radius, groove_retract, variables)
        faults: list[control.ControlError] = []
        programs = control.read_file(program, faults)
        report = control.check(programs, settings, faults)
        if not report.blocks and not report.errors:
            raise control.ControlError("file", f"{program} has no blocks; name a part program")
        if job is not None and not report.errors:
            _grind_too(report, programs, job, settings)
    except control.ControlError as error:
        report = control.Report(errors=[error])
    if as_json:
        print(json.dumps(report_record(report, program.name)))
    elif not report.errors:
        print(printable(summary(report)))
        beside = program.with_suffix(".toml")
        if job is None and beside.is_file():
            said = f"grind check {shlex.quote(str(program))} --job {shlex.quote(str(beside))}"
            print(printable(f"without the times of the job; next: {said}"))
    for found in report.errors:
        print(printable(f"grind: {found}"), file=sys.stderr)
    if ended_at(report):
        print(printable(f"grind: {ended_at(report)}"), file=sys.stderr)
    if report.errors:
        raise typer.Exit(BAD_INPUT)


@app.command(epilog="grind trace slot.nc\ngrind trace slot.nc --strokes 4 --acceleration 2000")
def trace(
    program: arguments.ProgramFile,
    strokes: Strokes = 10,
    acceleration: Acceleration = None,
    block_delete: arguments.BlockDelete = False,
    max_blocks: arguments.MaxBlocks = None,
    radius: Radius = None,
    groove_retract: arguments.GrooveRetract = None,
    variables: arguments.Variables = None,
    job: MachineJob = None,
) -> None:
    """Print the motions of a program, one JSON object a line.

    Motions are in the order in which they end; strokes and picks overlap with others. Messages to the operator go to
    standard error. Fields: docs/reference/columns.md.
    """
    from grind_env import control

    try:
        settings = _control(job, strokes, acceleration, block_delete, max_blocks, radius, groove_retract, variables)
        for event in control.execute(control.read_file(program), settings):
            record = control.record(event)
            if record is not None:
                print(json.dumps(record))
            elif isinstance(event, control.Message):
                print(printable(f"grind: {event.text}"), file=sys.stderr)
    except control.ControlError as error:
        print(json.dumps(control.error_record(error, program.name)))
        raise typer.Exit(BAD_INPUT) from None


@app.command(epilog="grind run plate.nc --plot plate.png\ngrind run plate.nc --job steel.toml --record strokes.csv")
def run(
    program: arguments.ProgramFile,
    job: arguments.JobFile = None,
    as_json: arguments.AsJson = False,
    plot: arguments.PlotFile = None,
    record: Annotated[
        Path | None, typer.Option(help="Write all strokes to this .csv or .parquet file."), Writes()
    ] = None,
    block_delete: arguments.BlockDelete = False,
    max_blocks: arguments.MaxBlocks = None,
    groove_retract: arguments.GrooveRetract = None,
    variables: arguments.Variables = None,
    dress_at: arguments.DressAt = None,
    interrupts: arguments.Interrupts = None,
    plant: arguments.Plant = None,
) -> None:
    """Simulate a program: time, size, Ra, power and cost of each part.

    More: docs/howto/shop.md (M00, M01, operator), docs/howto/job-file.md, docs/reference/columns.md.
    Exit status 1: a part is more likely scrap than good, or has motions that are not simulated.
    """
    from grind_env.control.cli_options import variables_of
    from grind_env.machine.grind import grind_file
    from grind_env.process.cost import SCRAP_BELOW
    from grind_env.render.record_tables import as_data, print_record

    result = grind_file(
        program,
        job,
        block_delete=block_delete,
        blocks=max_blocks,
        groove_retract=groove_retract,
        variables=variables_of(variables or ()),
        dress_at=dress_at or (),
        interrupts=interrupts or (),
        plant=plant,
    )
    if record is not None:
        result.write(record)
    if plot is not None:
        from grind_env.render.record_plots import plot_record

        plot_record(result, plot, program.name)
    if as_json:
        print(json.dumps(as_data(result, program.name)))
    else:
        print_record(result, program.name, table_console())
    if result.parts["survival"].min() < SCRAP_BELOW:
        raise typer.Exit(GROUND_SCRAP)


@app.command(epilog="grind facts --page 16-4\ngrind facts --mark decided --json")
def facts(
    mark: Annotated[str | None, typer.Option(help="Only facts with this mark: seen, inferred, decided.")] = None,
    page: Annotated[str | None, typer.Option(help="Only facts of this page of a manual: 16-13.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the facts as a JSON list.")] = False,
) -> None:
    """List the rules of the simulated control and their sources."""
    from dataclasses import asdict

    from rich.padding import Padding

    from grind_env.control.facts import MARKS, load_facts

    if mark is not None and mark not in MARKS:
        raise GrindError(f"there is no mark {quoted(mark)}; marks are {', '.join(MARKS)}")
    known = load_facts()
    pages = {fact.page for fact in known if fact.page}
    if page is not None and page not in pages:
        raise GrindError(f"no fact is of page {quoted(page)}; pages are {', '.join(sorted(pages))}")
    chosen = [fact for fact in known if mark in (None, fact.mark) and page in (None, fact.page)]
    if as_json:
        print(json.dumps([asdict(fact) for fact in chosen]))
        return
    console = table_console()
    for fact in chosen:
        console.print("  ".join(filter(None, (fact.id, fact.page and f"page {fact.page}", fact.mark))), style="bold")
        console.print(Padding(fact.text, (0, 0, 0, 4), expand=False))
        if fact.outside:
            console.print(Padding(f"outside: {fact.outside}", (0, 0, 0, 4), expand=False))
        for test in fact.tests:  # not wrapped, so that the user can copy the line
            console.print(f"    {test}", soft_wrap=True)


@app.command(epilog="grind tasks grind/Rush-v0\ngrind tasks shop.toml")
def tasks(
    env_id: Annotated[
        str | None,
        typer.Argument(
            metavar="ID|TASK|FILE", help="grind/Rush-v0 or rush to describe, or a task file (.toml) to check and print."
        ),
        PROBLEM,
    ] = None,
    schema: Annotated[bool, typer.Option("--schema", help="Print all keys of a task file.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON: environments, task, or JSON Schema.")] = False,
) -> None:
    """List the environments, or describe one: spaces, reward, example.

    Your own task is a TOML file: gym.make("grind/Task-v0", task="shop.toml").
    """
    from dataclasses import asdict

    from grind_env.data_table import Column, table_of
    from grind_env.envs.blocks.task_job import check_task
    from grind_env.envs.tasks import read_task
    from grind_env.envs.tasks.reading import is_file
    from grind_env.envs.tasks.schema import document, json_schema, schema_text, toml_text
    from grind_env.pages import page, summaries, summary

    if schema:
        print(json.dumps(json_schema()) if as_json else schema_text())
        return
    if env_id is not None and is_file(env_id):
        task = read_task(env_id)
        check_task(task)
        print(json.dumps(document(task)) if as_json else toml_text(document(task)))
        return
    if env_id is not None and not as_json:
        print(page(env_id), end="")
        return
    rows = summaries() if env_id is None else [summary(env_id)]
    if as_json:
        print(json.dumps([asdict(row) for row in rows]))
        return
    columns = (
        Column("id", "id"),
        Column("steps", lambda row: row.steps or "-"),
        Column("obs.", "observation"),
        Column("rule", "scripted", ".0f", right=True),
        Column("difficulty", "hard", wrap=True),
    )
    console = table_console()
    table_of(columns, rows).print(console)
    console.print("rule: score of the best tuned rule or planner; 0: best fixed plan; 100: planner that knows all lots")


def _grind_too(report: "Report", programs: "Programs", job: Path, settings: "Control") -> None:
    """Simulate the program with a job; add the time and the warnings, or the error, to the report of a check."""
    from grind_env.control import ControlError
    from grind_env.machine.grind import grind
    from grind_env.machine.job.job_file import load_job

    try:
        record = grind(programs, load_job(job), control=settings)
    except GrindError as error:
        report.errors.append(ControlError("job", str(error)))
    else:
        report.seconds, report.warnings = record.seconds, list(record.warnings)


def _control(
    job: Path | None,
    strokes: int,
    acceleration: float | None,
    block_delete: bool,
    max_blocks: int | None,
    radius: list[str] | None,
    groove_retract: float | None,
    variables: list[str] | None,
) -> "Control":
    from dataclasses import replace

    from grind_env.control import Control, ControlError
    from grind_env.control.cli_options import radii_of, variables_of
    from grind_env.control.control_settings import WHEEL_RADIUS

    every, radii = radii_of(radius or ())
    machine = Control()
    if job is not None:
        from grind_env.machine.dress.mounted_wheel import first_diameter
        from grind_env.machine.job.job_file import load_job

        try:
            ground = load_job(job)
        except GrindError as error:  # reported like an error of the program
            raise ControlError("job", str(error)) from None
        machine, radii = ground.control, {WHEEL_RADIUS: 0.5 * first_diameter(ground)} | radii
    return replace(
        machine,
        strokes=strokes,
        acceleration=machine.acceleration if acceleration is None else acceleration,
        block_delete=block_delete,
        block_budget=machine.block_budget if max_blocks is None else max_blocks,
        radius=every,
        radii=radii,
        groove_retract=groove_retract,
        variables=variables_of(variables or ()),
    )


POLICY_EXAMPLES: dict[Callable[..., None], tuple[str, ...]] = {
    evaluate: ("grind evaluate --task plate.nc --policy E12000D1", "grind evaluate --core --policy my_rule:MyRule"),
    verify: ("grind verify row.json", "grind verify row.json --seed 31415926535897932384"),
    play: ("grind play --task rush --policy adaptive_rule", "grind play --no-window --output played.nc"),
}
for function, examples in {**POLICY_EXAMPLES, **EXAMPLES}.items():
    app.command(epilog="\n".join(examples))(function)
training_command.register(app)
app.add_typer(figure_commands.app, name="figure")


def main(arguments: list[str] | None = None) -> None:
    """Run the console command; bad input gives one line on standard error and exit status 2."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a terminal may lack some characters
    with command("grind"):
        app(args=arguments)
