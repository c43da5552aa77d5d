"""Measure speed as ratios: `make speed`. With `--check`, only the ratios of `ratios.toml`, in about a minute."""

import sys

from rich.console import Console

from tests import speed_envs
from tests.speed import kernel, ratios, starts
from tests.speed.c_reference import compiler

WIDTH = 120  #: least width of the printed tables, so that a log has one line per measure


def main(*arguments: str) -> int:
    """Measure and print; with `--check`, return 1 if a ratio exceeds its limit."""
    console = Console(width=max(Console().width, WIDTH))
    ns = kernel.strokes()
    found = ratios.measured(ns)
    console.print(ratios.stroke_table(ns))
    console.print(ratios.ratio_table(found))
    if not compiler():
        console.print("No gcc here: the lines of C are left out.")
    if arguments == ("--check",):
        over_limits = ratios.over_limits(found)
        console.print("\n".join(over_limits), highlight=False)
        return 1 if over_limits else 0
    console.print(starts.table())
    console.print(speed_envs.table())
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
