"""Options of several commands."""

from typing import Annotated

import typer

from grind_env.arguments import PROBLEM

Tasks = Annotated[
    str | None,
    typer.Option(
        "--tasks",
        "--task",
        "--env",
        "--program",
        help="Tasks, ids, task files (.toml) or part programs, separated by commas; `core` or `all` tasks.",
    ),
    PROBLEM,
]
"""What each command has by default, its own help says."""
