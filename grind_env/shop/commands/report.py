"""`grind report`: the result of a program as one HTML file."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.file_arguments import Writes
from grind_env.shop.commands import arguments
from grind_env.shop.report.document import PAGE, SUFFIXES


def report(
    program: arguments.ProgramFile,
    job: arguments.JobFile = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="The .html file; default PROGRAM with .html."),
        Writes(default_suffix=SUFFIXES[0], replaceable=PAGE),
    ] = None,
    block_delete: arguments.BlockDelete = False,
    max_blocks: arguments.MaxBlocks = None,
    groove_retract: arguments.GrooveRetract = None,
    variables: arguments.Variables = None,
    dress_at: arguments.DressAt = None,
    interrupts: arguments.Interrupts = None,
    plant: arguments.Plant = None,
) -> None:
    """Simulate a program and write an HTML report.

    The report has the verdict, margins to limits, blocks, plots, parts, dresses, cost and warnings, and works offline.
    Needs the extra [shop].
    """
    from grind_env.control.cli_options import variables_of
    from grind_env.message_text import printable
    from grind_env.shop import python_api

    written = python_api.report(
        program,
        job,
        output,
        block_delete=block_delete,
        blocks=max_blocks,
        groove_retract=groove_retract,
        variables=variables_of(variables or ()),
        dress_at=dress_at or (),
        interrupts=interrupts or (),
        plant=plant,
    )
    print(printable(f"written: {written}"))
