"""`grind optimise`: a cheaper version of a program."""

import json
import shlex
from pathlib import Path
from typing import Annotated

import typer

from grind_env.file_arguments import Writes
from grind_env.files import write_csv
from grind_env.shop.commands import arguments
from grind_env.terminal_output import table_console

NOT_BETTER, INFEASIBLE = 3, 4  #: exit statuses beside those of every command


def optimise(
    program: arguments.ProgramFile,
    job: arguments.JobFile = None,
    vary: Annotated[str | None, typer.Option(help="E,D,interval (default),J,L,lead,depth,passes.")] = None,
    bounds: Annotated[list[str] | None, typer.Option(help="E=5000..9000 (mm/min),interval=1..8 (runs)")] = None,
    margin: Annotated[
        list[str] | None, typer.Option(help="Usable share of power, rise, Ra or size: power=.85.")
    ] = None,
    confidence: Annotated[float, typer.Option(help="Probability of keeping a limit.")] = 0.95,
    untried: arguments.Untried = False,
    fix: Annotated[list[str] | None, typer.Option(help="Cycle blocks not to change: N80.")] = None,
    constraint: Annotated[list[str] | None, typer.Option(help="Limit of a mean: seconds=75,cost=2.5.")] = None,
    objective: Annotated[str, typer.Option(help="What to minimise: cost or time.")] = "cost",
    parts: arguments.Runs = 50,
    budget: Annotated[str, typer.Option(help="60s, 2min or '2000 programs'.")] = "60s",
    seed: arguments.Seed = 1,
    variables: arguments.FirstVariables = None,
    plant: arguments.Plant = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write the better program."), Writes()] = None,
    plot: arguments.PlotFile = None,
    csv: arguments.CsvFile = None,
    report: arguments.ReportFile = None,
    as_json: arguments.AsJson = False,
) -> None:
    """Optimise table speed E and dresses D of a program for lower cost.

    The new program is written only if it is significantly cheaper, keeps all limits and is hardly ever dearer
    (docs/howto/improve.md). Exit status 3: nothing better, or your program makes scrap; 4: none keeps the limits.
    """
    from grind_env.control.cli_options import variables_of
    from grind_env.machine.job.job_file import job_beside, load_job
    from grind_env.render.figures import prepare_figure, write_figure
    from grind_env.shop import python_api, search_options
    from grind_env.shop.optimise import tables
    from grind_env.shop.optimise.result import Verdict
    from grind_env.shop.report.document import write_page
    from grind_env.shop.report.optimisation_report import optimised_report

    path = job or job_beside(program)
    seconds, programs = search_options.budget(budget)
    arguments.prepare_report(report)
    if plot is not None:
        prepare_figure(plot)
    found = python_api.optimise(
        program,
        job,
        vary=None if vary is None else search_options.listed([vary]),
        bounds=search_options.named("--bounds", bounds or (), search_options.ends),
        margin=search_options.named("--margin", margin or (), search_options.number),
        fix=[search_options.label(each) for each in search_options.listed(fix or ())],
        constraint=search_options.named("--constraint", constraint or (), search_options.number),
        objective=objective,
        parts=parts,
        budget=seconds,
        programs=programs,
        seed=seed,
        variables=variables_of(variables or ()),
        plant=plant,
        confidence=confidence,
        untried=untried,
    )
    if found.verdict.is_written and output is not None:
        found.write(output)
    if plot is not None:
        write_figure(tables.draw_optimised(found), plot)
    if csv is not None:
        write_csv(csv, tables.values_table(found).plain())
    if report is not None:
        write_page(report, optimised_report(found, load_job(path), {"program": program, "job": path}))
    if as_json:
        print(json.dumps(tables.as_data(found)))
    else:
        tables.print_result(table_console(), tables.tables_of(found), [tables.heading(found), *tables.sentences(found)])
        if found.verdict.is_written:
            run = f"grind run {shlex.quote(str(output))} --job {shlex.quote(str(path))}"
            print("next: add -o FILE to write the program" if output is None else f"written to {output}; next: {run}")
    if found.verdict is not Verdict.BETTER:
        forbidden = found.verdict in (Verdict.INFEASIBLE, Verdict.NEARER)
        raise typer.Exit(INFEASIBLE if forbidden else NOT_BETTER)
