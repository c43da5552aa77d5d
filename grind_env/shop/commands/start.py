"""A folder to start from, and what a job file and the catalogue may say."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import FILE, Keeps
from grind_env.shop.commands.optimise import INFEASIBLE
from grind_env.terminal import table_console

BUDGET, SEED = "30s", 1
"""Of a proposal."""


def init(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Is made if need be."), Keeps()],
    stations: Annotated[int, typer.Option(metavar="COUNT", help="Parts on the table, ground one after the other.")] = 1,
    material: Annotated[
        str | None,
        typer.Option(
            help="Work material, a name of the catalogue; with this or one of the next, a program "
            "is proposed for the part. What is not said is that of the example."
        ),
    ] = None,
    wheel: Annotated[str | None, typer.Option(help="Grinding wheel, a name of the catalogue.")] = None,
    Ra: Annotated[float | None, typer.Option("--Ra", help="Highest roughness Ra, um.")] = None,
    tolerance: Annotated[float | None, typer.Option(help="On the size error, um.")] = None,
    length: Annotated[float | None, typer.Option(help="Of the part along the table, mm.")] = None,
    width: Annotated[float | None, typer.Option(help="Across, mm; a part wider than the wheel is traversed.")] = None,
    stock: Annotated[float | None, typer.Option(help="To grind off, mm.")] = None,
    catalogue: Annotated[
        Path | None,
        typer.Option(
            help="Catalogue file of yours with material or wheel, which is copied; the machine is its "
            "our_grinder, or default."
        ),
        FILE,
    ] = None,
    budget: Annotated[
        str | None, typer.Option(help=f"Time of search and judgement of a proposal: 2min; {BUDGET} by default.")
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help=f"Of lots and search of it; {SEED} by default.")] = None,
) -> None:
    """Write a program, its job, a catalogue of the shop, a notebook and a sample log; they run as they are.

    The log is made up, for `grind calibrate`: a log of your spindle takes its place. With `--stations 2` the program
    grinds two parts on the table, and there are no notebook and no log.

    With --material, --wheel, --Ra, --tolerance or a size the program is proposed for that part: E, picks, spark-outs,
    dresses, lead and depth of the dress begin with rules of thumb, and the search of `grind optimise` goes on from them
    on machines drawn from how uncertain the catalogue is. Parts keep each limit with a probability of .95, whatever
    their lot and machine, where it can be with a fifth of it to spare. What sets each word stands in the table and in
    comments of the program.

    Nothing is overwritten.

    Exit status 4: no program that was tried keeps the limits, and nothing is written.
    """
    from grind_env.errors import GrindError, printable
    from grind_env.shop.commands.texts import seconds
    from grind_env.shop.progress import progress
    from grind_env.shop.start.folder import start_folder
    from grind_env.shop.start.proposal import NotHeldError
    from grind_env.shop.start.proposed import Asked, propose_folder
    from grind_env.shop.start.show import print_proposal

    asked = Asked(
        material=material,
        wheel=wheel,
        Ra=Ra,
        tolerance=tolerance,
        length=length,
        width=width,
        stock=stock,
        catalogue=catalogue,
    )
    if asked == Asked() and (budget, seed) != (None, None):
        raise GrindError("--budget and --seed are of a proposal: say what is asked of the part, such as --Ra 0.4")
    if asked == Asked():
        paths = start_folder(folder, stations)
    elif stations != 1:
        raise GrindError("--stations is of the example, and no program is proposed for several parts: leave it out")
    else:
        try:
            most = seconds(budget or "30s")
            with progress(most) as advance:
                paths, found = propose_folder(
                    folder, asked, seconds=most, seed=1 if seed is None else seed, progress=advance
                )
        except NotHeldError as error:
            print(printable(f"grind: {error}"), file=sys.stderr)
            raise typer.Exit(INFEASIBLE) from None
        print_proposal(found, paths[0], paths[1], table_console())
    program, *others = paths
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
    file: Annotated[list[Path] | None, typer.Option(help="A catalogue of yours on top; repeatable."), FILE] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """List materials, wheels, dressers, fluids and machines, or show an entry: values, units, ranges and source."""
    from grind_env.shop.entries import catalogue_data, print_catalogue

    if as_json:
        print(json.dumps(catalogue_data(kind, name, file or ())))
    else:
        print_catalogue(kind, name, file or (), table_console())
