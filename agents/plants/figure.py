"""Figure of the study: cost of a part on each machine over the best fixed plan or the original program."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, ScalarFormatter

from agents.benchmark.figures import COLOURS, DPI, GREY, WIDTH, plain
from agents.plants.trials import Found, PlantsTrial

#: height of the line of a family, inches, and distance of the compared costs in it, in lines
LINE, BETWEEN = 0.34, 0.22
LEAST, MOST = 0.2, 5.0  #: ends of the axis; values beyond are drawn at the ends
TICKS = (0.25, 0.5, 1.0, 2.0, 4.0)


class Compared(NamedTuple):
    """Compared costs: the question of the cost and of its reference, the names of both, and a label."""

    question: str
    cost: str
    over: str
    label: str


PANELS = {
    "60 parts, over the best of 15 fixed plans": (
        Compared("advise", "floor_cost", "plan_cost", "adviser without a model"),
        Compared("advise", "adviser_cost", "plan_cost", "grind advise"),
        Compared("robust", "robust_cost", "plan_cost", "agent of grind train"),
    ),
    "grind optimise, over the original program": (
        Compared("optimise", "uncalibrated_cost", "original", "not calibrated"),
        Compared("optimise", "calibrated_cost", "original", "calibrated"),
        Compared("optimise", "known_cost", "original", "the machine as its model"),
    ),
}
MARKS = "^os"
LEGEND: dict[str, Any] = {"fontsize": 7.5, "handletextpad": 0.1, "frameon": False}


def plants_figure(found: Mapping[PlantsTrial, Found]) -> Figure | None:
    """Return the figure: a dot per machine and program, a line per family, a panel for advisers and one for searches.

    None if neither was asked.
    """
    families = list(dict.fromkeys(cell.machine.family for cell in found))
    asked = {cell.question for cell in found}
    shown = {title: [each for each in who if each.question in asked] for title, who in PANELS.items()}
    shown = {title: who for title, who in shown.items() if who}
    if not shown:
        return None
    size = WIDTH, 1.1 + LINE * len(families)
    drawn = Figure(figsize=size, dpi=DPI, layout="constrained")
    panels = drawn.subplots(1, len(shown), sharey=True, squeeze=False)[0]
    for panel, (title, compared) in zip(panels, shown.items(), strict=True):
        for each in compared:
            _dots(panel, found, each, families, PANELS[title].index(each))
        panel.set_title(title, fontsize=9)
        panel.axvline(1.0, color=GREY, lw=0.8, zorder=0)
        panel.set_xscale("log")
        panel.set_xlim(LEAST / 1.08, MOST * 1.08)
        panel.set_xticks(TICKS)
        panel.xaxis.set_major_formatter(ScalarFormatter())
        panel.xaxis.set_minor_formatter(NullFormatter())
        plain(panel, "x")
        panel.tick_params(labelsize=8)
        panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=3, columnspacing=1.2, **LEGEND)
    panels[0].set_yticks(-np.arange(len(families)), families)
    return drawn


def _dots(panel: Axes, found: Mapping[PlantsTrial, Found], who: Compared, families: list[str], k: int) -> None:
    of = [(cell, numbers) for cell, numbers in found.items() if cell.question == who.question]
    ratios = np.clip([numbers.get(who.cost, np.nan) / numbers[who.over] for _, numbers in of], LEAST, MOST)
    places = [BETWEEN * (1 - k) - families.index(cell.machine.family) for cell, _ in of]
    panel.plot(ratios, places, MARKS[k], color=COLOURS[k], ms=3.5, alpha=0.7, mew=0.0, label=who.label)
