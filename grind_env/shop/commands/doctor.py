"""What is installed, and how fast it is."""

from typing import Annotated

import typer

from grind_env.terminal import table_console


def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON list.")] = False,
) -> None:
    """Look over the installation: versions, compiled kernels, speed, extras, and how to get what is missing.

    The speed is that of the compiled process on this machine, while nothing else runs. An extra that is missing is no
    fault: the last column says how it is installed.
    """
    import json

    from grind_env.shop.doctor import findings
    from grind_env.table import Column, table_of

    found = findings()
    if as_json:
        print(json.dumps([each._asdict() for each in found]))
        return
    columns = (Column("what"), Column("found", wrap=True), Column("to do", wrap=True))
    table_of(columns, found).print(table_console())
