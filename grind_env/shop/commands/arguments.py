"""What several commands are given."""

from pathlib import Path
from typing import Annotated

import typer

ProgramFile = Annotated[Path, typer.Argument(metavar="PROGRAM", help="Part program, a text file.")]
JobFile = Annotated[Path | None, typer.Option("--job", help="Job file; PROGRAM with .toml if not given.")]
Runs = Annotated[int, typer.Option(min=1, max=1000, help="Runs of the program in a batch; the wheel carries over.")]
ReportFile = Annotated[Path | None, typer.Option("--report", help="Write the result up as this .html file.")]
Seed = Annotated[int, typer.Option(min=0, help="Of lots and search; the same seed finds the same.")]
