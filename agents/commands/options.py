"""Options that all commands share: what is ground."""

from typing import Annotated

import typer

NamedProblem = Annotated[
    str,
    typer.Option(
        "--task", "--env", "--program", help="A task, an id, a task file (.toml), or a part program (any other file)."
    ),
]
JobFile = Annotated[str | None, typer.Option(help="Job file of a part program; its name with .toml by default.")]
Parts = Annotated[int, typer.Option(min=1, help="How often a part program is run.")]
