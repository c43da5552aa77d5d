"""The tables of the track: as a page, and every run as a row."""

import math
from collections.abc import Callable, Iterator

import numpy as np

from agents.track.scores import Found, Scored, scored
from grind_env.table import Column, table_of

COLUMNS = ("task", "plant", "adapter", "seed", "blocks", "cost", "scrap", "spent", "learning_scrap", "cpu_seconds")
"""Of the CSV: $ an episode and share of scrap where it is judged, and $ and bad parts of the blocks before."""
WHAT = """\
Score: 0 is the fixed plan that was retuned on the machine, 100 the planner that holds the machine as its model and sees
its state; mean over machines, and of the worst tenth of them, one at least, with 95 % (machines, their seeds and
episodes resampled). A few machines on which an adapter is dear may carry its mean: beside it the *median*, and on how
many it is *better* than the fixed plan.
*Cost of these blocks*, on the machine before it is judged: over that of the fixed plan on the same lots. *Over the
budget*: runs with more scrap in them than one part or 1 %, whichever is more. *Beaten after*: blocks after which all of
them together have cost less than with the fixed plan, median of the runs."""


def _finite(name: str, form: str = ".0f", factor: float = 1.0) -> Callable[[Scored], str]:
    """Return the text of a number; "" where it is none."""
    return lambda row: f"{factor * getattr(row, name):{form}}" if math.isfinite(getattr(row, name)) else ""


SHOWN = (
    Column("adapter", "adapter"),
    Column("blocks", "blocks"),
    Column("score", "score", ".0f"),
    Column("median", _finite("median")),
    Column("better on", lambda row: f"{row.better} of {row.machines}"),
    Column("worst tenth", "worst", ".0f"),
    Column("scrap, %", _finite("scrap", ".2f", 100.0)),
    Column("cost of these blocks", _finite("spent", ".2f")),
    Column("scrap in them, %", _finite("learning_scrap", ".2f", 100.0)),
    Column("over the budget", lambda row: f"{row.violations} of {row.runs}" if row.blocks else ""),
    Column("beaten after", lambda row: (_finite("beaten")(row) or "never") if row.blocks else ""),
    Column("CPU-seconds", _finite("cpu_seconds")),
)


def rows(found: Found) -> Iterator[list[object]]:
    """Yield a row for every run and every time that it is judged."""
    for cell, run in found.items():
        shift = cell.problem.simulation().task.blocks
        for blocks in cell.blocks:
            cost, good, finished = np.array(run.judged[f"{blocks}"])
            before = [sum(values[: blocks // shift]) for values in (run.costs, run.scrap)]
            numbers = cost.mean(), 1.0 - good.sum() / finished.sum(), *before, run.cpu_seconds
            of = cell.problem.name, cell.plant, cell.adapter, cell.seed, blocks
            yield [*of, *(f"{number:.6g}" for number in numbers)]


def page(found: Found) -> str:
    """The tables, Markdown."""
    parts = ["`python -m agents track`; its machines and seeds are in track.csv.", WHAT]
    for heading, runs in tables_of(found).items():
        parts += [f"## {heading}", table_of(SHOWN, scored(runs)).markdown()]
    return "\n\n".join(parts)


def tables_of(found: Found) -> dict[str, Found]:
    """The runs of each table: of a task on all machines; where more adapters are on fewer machines, of all on these."""
    tables: dict[str, Found] = {}
    for problem in dict.fromkeys(cell.problem for cell in found):
        on = dict[str, set[str]]()
        for cell in found:
            if cell.problem == problem:
                on.setdefault(cell.adapter, set()).add(cell.plant)
        for plants in sorted(on.values(), key=len, reverse=True):
            tables[f"{problem.name}, {len(plants)} machine{'s' * (len(plants) > 1)}"] = {
                cell: run
                for cell, run in found.items()
                if cell.problem == problem and cell.plant in plants and on[cell.adapter] >= plants
            }
    return tables
