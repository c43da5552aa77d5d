"""What a program does, as one HTML file."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import Writes
from grind_env.shop.commands.arguments import (
    BlockDelete,
    Blocks,
    DressAt,
    GrooveRetract,
    Interrupts,
    JobFile,
    Plant,
    ProgramFile,
    Variables,
)
from grind_env.shop.report.document import PAGE, SUFFIXES


def report(
    program: ProgramFile,
    job: JobFile = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="The .html file; usually PROGRAM with .html."),
        Writes(usual=SUFFIXES[0], own=PAGE),
    ] = None,
    block_delete: BlockDelete = False,
    blocks: Blocks = None,
    groove_retract: GrooveRetract = None,
    variables: Variables = None,
    dress_at: DressAt = None,
    interrupts: Interrupts = None,
    plant: Plant = None,
) -> None:
    """Grind with a program and write one HTML page that works offline.

    Verdict, margin to each limit, blocks, plots, parts, dresses, cost, warnings. Needs the extra [shop].
    """
    from grind_env.control.options import variables_of
    from grind_env.errors import printable
    from grind_env.shop import calls

    written = calls.report(
        program,
        job,
        output,
        block_delete=block_delete,
        blocks=blocks,
        groove_retract=groove_retract,
        variables=variables_of(variables or ()),
        dress_at=dress_at or (),
        interrupts=interrupts or (),
        plant=plant,
    )
    print(printable(f"written: {written}"))
