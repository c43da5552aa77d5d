"""The commands of `grind` for one's own programs, jobs and logs."""

import json
from pathlib import Path
from typing import Annotated

import typer

NOT_BETTER, INFEASIBLE = 3, 4
"""Exit statuses of `optimise`."""

PartProgram = Annotated[Path, typer.Argument(metavar="PROGRAM", help="Part program, a text file.")]
JobFile = Annotated[Path | None, typer.Option(help="Job file; PROGRAM with .toml if not given.")]
Runs = Annotated[int, typer.Option(min=1, max=1000, help="Runs of the program in a batch; the wheel carries over.")]
Seed = Annotated[int, typer.Option(min=0, help="Of lots and search; the same seed finds the same.")]


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command(epilog="Example: grind optimise plate.nc --vary E,D,J --margin power=.85 -o plate_opt.nc")(optimise)


def optimise(
    program: PartProgram,
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
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
) -> None:
    """Find better words for a program: E and D, or others, with which a part costs less and keeps its limits.

    The program is replayed on lots of the job ([lots]) for batches of parts, in which the wheel carries over. The best
    one is judged on 256 lots that the search has not seen, each ground with both programs. It is written only if the
    upper end of the 95 % interval of the difference is below 0, and if 95 of 100 parts keep every limit with its
    margin. Only the words that change are changed in the text, and a comment at each block says what it was; a block
    that runs several times keeps one value for all its runs.

    Exit status 3: no better program was found. 4: no program keeps the limits.
    """
    from rich.console import Console

    from grind_env.files import write_atomically
    from grind_env.shop.optimise.optimise import optimise as search
    from grind_env.shop.optimise.outcome import Verdict
    from grind_env.shop.optimise.table import as_data, print_optimised
    from grind_env.shop.optimise.wishes import seconds_of, wishes_of
    from grind_env.shop.progress import progress

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
    statuses = {Verdict.NOT_BETTER: NOT_BETTER, Verdict.INFEASIBLE: INFEASIBLE}
    if found.verdict in statuses:
        raise typer.Exit(statuses[found.verdict])
