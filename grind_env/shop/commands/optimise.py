"""Better words for a program."""

import json
from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import Writes
from grind_env.shop.commands.arguments import FirstVariables, JobFile, ProgramFile, ReportFile, Runs, Seed
from grind_env.terminal import table_console

NOT_BETTER, INFEASIBLE = 3, 4
"""Exit statuses beside those of every command."""


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
    variables: FirstVariables = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write the program here, if it is better."), Writes()
    ] = None,
    report: ReportFile = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> None:
    """Find better words for a program: E and D, or others, with which a part costs less and keeps its limits.

    The program is replayed on lots of the job ([lots]) for batches of parts, in which the wheel carries over. The best
    one is judged on 256 lots that the search has not seen, each ground with both programs; on fewer where the control
    has to execute the program step by step and the budget has no time for more. It is written only if the
    upper end of the 95 % interval of the difference is below 0, and if 95 of 100 parts keep every limit with its
    margin. Only the words that change are changed in the text, and a comment at each block says what it was; a block
    that runs several times keeps one value for all its runs. A word that reads a variable, as E#101, is changed where
    #101 is assigned, if that is one number and no other word reads it.

    The report is written whatever was found.

    Exit status 3: no better program was found, or there was no time to try one. 4: no program keeps the limits.
    """
    from grind_env.control.options import variables_of
    from grind_env.machine.job.file import job_beside, load_job
    from grind_env.shop import calls
    from grind_env.shop.commands import texts
    from grind_env.shop.optimise.outcome import Verdict
    from grind_env.shop.optimise.table import as_data, print_optimised
    from grind_env.shop.report.document import prepare_page, write_page
    from grind_env.shop.report.optimised import optimised_report

    if report is not None:
        prepare_page(report)
    found = calls.optimise(
        program,
        job,
        vary=None if vary is None else texts.listed([vary]),
        bounds=texts.named("--bounds", bounds or (), texts.ends),
        rounding=texts.named("--round", rounding or (), texts.number),
        margin=texts.named("--margin", margin or (), texts.number),
        keep=[texts.label(each) for each in texts.listed(keep or ())],
        unroll=unroll,
        parts=parts,
        budget=texts.seconds(budget),
        seed=seed,
        variables=variables_of(variables or ()),
    )
    if found.verdict is Verdict.BETTER and output is not None:
        found.write(output)
    if as_json:
        print(json.dumps(as_data(found)))
    else:
        print_optimised(found, table_console())
        if found.verdict is Verdict.BETTER:
            print("name a file with -o to have it" if output is None else f"written to {output}")
    if report is not None:
        path = job_beside(program) if job is None else job
        write_page(report, optimised_report(found, load_job(path), {"program": program, "job": path}))
    statuses = {Verdict.NOT_BETTER: NOT_BETTER, Verdict.UNTRIED: NOT_BETTER, Verdict.INFEASIBLE: INFEASIBLE}
    if found.verdict in statuses:
        raise typer.Exit(statuses[found.verdict])
