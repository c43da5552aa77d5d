"""The state of the wheel from dress to dress, and what a batch of parts takes of it."""

from typing import TYPE_CHECKING

import numpy as np

from grind_env.machine.record import GrindingRecord
from grind_env.render.figures import new_figure
from grind_env.render.style import COLOURS, COLUMN, DASHES, MARKS, paper_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANEL = 1.15
"""Height of a panel, in."""
STATE = {"A": "wear-flat\narea, %", "lam": "loading, %"}
"""Heading of what dulls, by the field of `record.STROKE_ROW`."""


def wheel_figure(record: GrindingRecord) -> "Figure":
    """Wear flats and loading over what was ground since the dress, and diameter lost over the parts of a run.

    All intervals from dress to dress lie upon one another, so that those that are alike are one line.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    strokes, breaks = record.strokes, record.dresses["after"]
    found = [rows for rows in np.split(strokes, breaks) if rows.size]
    begun = breaks.size > 0 and breaks[0] > 0
    with paper_style():
        from matplotlib.ticker import MaxNLocator

        figure = new_figure(COLUMN, 0.5 + PANEL * (len(STATE) + 1))
        *panels, below = figure.subplots(len(STATE) + 1, 1)
        for axes, (name, heading) in zip(panels, STATE.items(), strict=True):
            axes.sharex(panels[0])
            for k, rows in enumerate(found):
                first = begun and k == 0
                line = {"color": COLOURS[first], "ls": DASHES[first], "marker": MARKS[first] if rows.size == 1 else ""}
                axes.plot(rows["V"], 100.0 * rows[name], lw=0.7, **line)
            axes.set_ylabel(heading)
        panels[-1].set_xlabel("ground since the dress, mm³/mm")
        lost = 1000.0 * (strokes["ds"][0] - strokes["ds"])
        below.plot(
            np.insert(_places(record), breaks, np.nan), np.insert(lost, breaks, np.nan), color=COLOURS[0], lw=0.9
        )
        below.set(xlabel="part", ylabel="diameter\nlost, µm", xlim=(0.5, record.parts.size + 0.5))
        below.xaxis.set_major_locator(MaxNLocator(integer=True))
        for axes in (*panels, below):
            axes.margins(y=0.15)
            axes.grid(True)
        figure.align_ylabels()
        if begun:
            names = "from dress to dress", "before the first one"
            looks = zip(names, COLOURS, DASHES, strict=False)
            lines = [panels[0].plot([], [], color=color, ls=dash, label=name)[0] for name, color, dash in looks]
            figure.legend(handles=lines, loc="outside upper left", ncols=2)
    return figure


def _places(record: GrindingRecord) -> "np.ndarray":
    """Where strokes stand over the numbers of their parts: those of one around its number, in order."""
    part = record.strokes["part"]
    firsts = np.searchsorted(part, part)
    counts = np.searchsorted(part, part, side="right") - firsts
    places: np.ndarray = part + (np.arange(part.size) - firsts + 0.5) / counts - 0.5
    return places
