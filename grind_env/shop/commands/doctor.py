"""What is installed, how fast it is, and compilation ahead of time."""

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


def warm_up() -> None:
    """Compile what `grind run`, `grind optimise` and the environments need, so that nobody waits for it later.

    A line for each example, environment and search: seconds, and kernels that are new. They are kept in the user's
    cache, or below NUMBA_CACHE_DIR. Policies and networks compile a few kernels more when they are first judged.
    """
    from rich.console import Console
    from rich.progress import track

    from grind_env.kernel.cache import cache_folder
    from grind_env.shop.warm_up import kernels, uses, warm_up

    every, console = uses(), Console(stderr=True)
    shown = track(
        warm_up(every), "compiling", total=len(every), console=console, transient=True, disable=not console.is_terminal
    )
    for name, seconds, new, left_out in shown:
        print(f"{name:40} {left_out or f'{seconds:4.1f} s {new:3} new'}", flush=True)
    print(f"{kernels()} kernels in {cache_folder()}")
