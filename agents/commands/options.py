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

Ray = Annotated[
    str | None,
    typer.Option(
        "--ray",
        metavar="local|ADDRESS",
        help="Work on the nodes of a Ray cluster, whose head has this host:port, or with its workers on this machine.",
    ),
]
