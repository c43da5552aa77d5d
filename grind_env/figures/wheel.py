"""The state of the wheel over a batch of parts."""

from typing import TYPE_CHECKING

import numpy as np

from grind_env.machine.record import GrindingRecord
from grind_env.render.figures import new_figure
from grind_env.render.style import COLOURS, COLUMN, paper_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANEL = 0.95
"""Height of a panel, in."""
STATE = {
    "A": ("wear-flat\narea, %", 100.0),
    "lam": ("loading, %", 100.0),
    "V": ("ground since\ndress, mm³/mm", 1.0),
}
"""Heading and factor of each panel, by the field of `record.STROKE_ROW`."""
LOST = "diameter\nlost, µm"


def wheel_figure(record: GrindingRecord) -> "Figure":
    """Wear flats, loading, volume since the dress and diameter lost, over the parts of a run.

    Dresses are dotted lines.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    strokes = record.strokes
    at, dressed = _places(record)
    breaks = record.dresses["after"]
    with paper_style():
        from matplotlib.ticker import MaxNLocator

        figure = new_figure(COLUMN, 0.4 + PANEL * (len(STATE) + 1))
        panels = figure.subplots(len(STATE) + 1, 1, sharex=True)
        shown = [(heading, factor * strokes[name]) for name, (heading, factor) in STATE.items()]
        shown.append((LOST, 1000.0 * (strokes["ds"][0] - strokes["ds"])))
        for axes, (heading, values) in zip(panels, shown, strict=True):
            axes.vlines(dressed, 0.0, 1.0, transform=axes.get_xaxis_transform(), color="#8a8a8a", lw=0.6, ls=":")
            axes.plot(np.insert(at, breaks, np.nan), np.insert(values, breaks, np.nan), color=COLOURS[0], lw=0.9)
            axes.set_ylabel(heading)
            axes.margins(y=0.15)
            axes.grid(True)
        panels[-1].set_xlabel("part; dotted: dress" if dressed.size else "part")
        panels[-1].set_xlim(0.5, record.parts.size + 0.5)
        panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
        figure.align_ylabels(panels)
    return figure


def _places(record: GrindingRecord) -> "tuple[np.ndarray, np.ndarray]":
    """Where strokes and dresses stand over the numbers of their parts: those of one around its number, in order."""
    part = record.strokes["part"]
    firsts = np.searchsorted(part, part)
    counts = np.searchsorted(part, part, side="right") - firsts
    at = part + (np.arange(part.size) - firsts + 0.5) / counts - 0.5
    ends = np.append(at + 0.5 / counts, at[-1:] + 0.5)
    before = record.dresses["after"]
    dressed = np.where(before > 0, ends[np.maximum(before - 1, 0)], 0.5)
    return at, dressed
