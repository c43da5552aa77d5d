"""`grind sweep`: a dress study of a user's part."""

import json
import shlex
from pathlib import Path
from typing import Annotated

import typer

from grind_env.file_arguments import Writes
from grind_env.files import write_atomically, write_csv
from grind_env.shop.commands import arguments
from grind_env.terminal_output import table_console


def sweep(
    program: arguments.ProgramFile,
    job: arguments.JobFile = None,
    speed: Annotated[
        str | None, typer.Option("--E", help="E of the first cycle block, mm/min; default half to twice its E.")
    ] = None,
    every: Annotated[str | None, typer.Option("--dress-every", help="Parts per dress; default 1..20.")] = None,
    lead: Annotated[str | None, typer.Option(help="Dress lead, mm/rev: .05..0.2; default unchanged.")] = None,
    depth: Annotated[str | None, typer.Option(help="Dress depth, mm/pass: .005..0.03; default unchanged.")] = None,
    parts: arguments.Runs = 50,
    seed: arguments.Seed = 1,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Write the cheapest program."), Writes()] = None,
    variables: arguments.FirstVariables = None,
    untried: arguments.Untried = False,
    plot: arguments.PlotFile = None,
    csv: arguments.CsvFile = None,
    as_json: arguments.AsJson = False,
) -> None:
    """Show cost and limits over E, dress interval, lead and depth.

    The E of all blocks change in proportion. The last column says kept, or the limit that is exceeded most
    (docs/howto/improve.md). Exit status 3: -o found no cheaper program, or half of your parts are scrap by the model.
    """
    from grind_env.control.cli_options import variables_of
    from grind_env.machine.job.job_file import job_beside
    from grind_env.render.figures import prepare_figure, write_figure
    from grind_env.shop import python_api, search_options
    from grind_env.shop.optimise.tables import print_result
    from grind_env.shop.sweep.figure import draw_sweep
    from grind_env.shop.sweep.recommended_program import recommended
    from grind_env.shop.sweep.table import as_data, points_table, sentences, tables_of

    if plot is not None:
        prepare_figure(plot)
    found = python_api.sweep(
        program,
        job,
        E=None if speed is None else search_options.ends("--E", "E", speed),
        dress_every=None if every is None else search_options.ends("--dress-every", "intervals", every),
        lead=None if lead is None else search_options.ends("--lead", "lead", lead),
        depth=None if depth is None else search_options.ends("--depth", "depth", depth),
        parts=parts,
        seed=seed,
        variables=variables_of(variables or ()),
        untried=untried,
    )
    if plot is not None:
        write_figure(draw_sweep(found), plot)
    if csv is not None:
        write_csv(csv, points_table(found).plain())
    if as_json:
        print(json.dumps(as_data(found)))
    else:
        print_result(table_console(), tables_of(found), sentences(found))
    if output is None:
        return
    best = recommended(found, program, job, seed=seed, variables=variables_of(variables or ()), untried=untried)
    write_atomically(output, lambda temporary: temporary.write_bytes(best.data))
    if not as_json:
        beyond = "" if best.keeps_limits else ", but with rounded values it exceeds a limit"
        run = f"grind run {shlex.quote(str(output))} --job {shlex.quote(str(job or job_beside(program)))}"
        print(f"written to {output}: {best.cost:.3f} $ a part{beyond}; next: {run}")
