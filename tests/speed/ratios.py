"""Comparison of measured speed ratios with the last values and limits in `ratios.toml`.

Only ratios can be compared between machines.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from grind_env.array_types import Array
from grind_env.toml import read_toml
from tests.speed import kernel, others
from tests.speed.turns import Ratios

FILE = Path(__file__).with_name("ratios.toml")


@dataclass(frozen=True)
class Reference:
    """Entry of `ratios.toml` about a ratio."""

    last: float  #: median when the file was last updated
    aim: str = ""  #: target, as a text
    most: float = math.inf  #: largest permitted median, on any machine


def known() -> dict[str, Reference]:
    """Return the entries of the file by the name of the ratio."""
    return {name: Reference(**values) for name, values in read_toml(FILE).items()}


def measured(ns: Mapping[str, Array]) -> Ratios:
    """Return all ratios; `ns` is the result of `kernel.strokes`."""
    return kernel.ratios(ns) | others.ratios()


def over_limits(ratios: Ratios) -> list[str]:
    """Return a sentence for each ratio above its limit."""
    found = []
    for name, about in known().items():
        median = float(np.median(ratios.get(name, about.last)))
        if not median <= about.most:
            found.append(f"{name}: {median:.4g} is more than {about.most} (last {about.last})")
    return found


def ratio_table(ratios: Ratios) -> Table:
    """Return a table of the quartiles, last values and targets; a ratio that was not measured is marked."""
    table = Table(title="Ratios of this run")
    for heading in ("measure", "lower", "median", "upper quartile", "last", "aim"):
        table.add_column(heading, justify="left" if heading == "measure" else "right")
    for name, about in known().items():
        numbers = quartiles(ratios[name]) if name in ratios else ("", "left out", "")
        table.add_row(name, *numbers, f"{about.last:.4g}", about.aim)
    return table


def stroke_table(ns: Mapping[str, Array]) -> Table:
    """Return a table of the ns per stroke of every loop."""
    table = Table(title=f"ns per stroke ({kernel.vector_width()})")
    for heading in ("loop", "lower", "median", "upper quartile"):
        table.add_column(heading, justify="left" if heading == "loop" else "right")
    for name, values in ns.items():
        table.add_row(name, *quartiles(values))
    return table


def quartiles(values: Array) -> tuple[str, ...]:
    """Return the lower quartile, median and upper quartile as texts."""
    return tuple(f"{each:.3g}" if each < 1000.0 else f"{each:,.0f}" for each in np.percentile(values, (25, 50, 75)))
