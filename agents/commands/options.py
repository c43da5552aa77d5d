"""Options of several commands."""

from typing import Annotated

import typer

Ray = Annotated[
    str | None,
    typer.Option(
        "--ray",
        metavar="local|ADDRESS",
        help="Work on the nodes of a Ray cluster, whose head has this host:port, or with its workers on this machine.",
    ),
]
