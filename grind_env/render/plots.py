"""Pictures of a grinding record."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from grind_env.errors import GrindError
from grind_env.files import write_atomically
from grind_env.machine.record import GrindingRecord
from grind_env.process.cost import Limits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg", ".pdf")
SPARKING = 0.001
"""mm; the burn ratio of a stroke that cuts less says nothing: its specific energy is that of rubbing."""

MOST_LABELS = 20
"""Parts that are all numbered and set off by lines; of more every k-th is numbered, without lines."""

SHORT_LABELS = 10
"""Parts above which the word `part` stands before the first number only."""

BLUE, ORANGE, GREEN, RED, GREY = "#1f5f8b", "#d9822b", "#2e8b57", "#b5322b", "#8a8a8a"


class PlotError(GrindError):
    """A picture that cannot be drawn."""


def plot_record(record: GrindingRecord, path: str | Path, limits: Limits | None = None) -> None:
    """Draw depth, power, wear-flat area, temperature and burn ratio over the time of the run.

    Dresses are shaded and parts numbered.

    Args:
        record: of `machine.grind`.
        path: a .png, .svg or .pdf file.
        limits: of the job; those of power and temperature are drawn.

    Raises:
        PlotError: another suffix, or matplotlib is not installed.
        FileError: the folder does not exist or cannot be written to.
    """
    path = Path(path)
    if path.suffix not in FORMATS:
        raise PlotError(f"{path}: a plot is written as {', '.join(FORMATS)}; name such a file")
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise PlotError("plots need matplotlib; install grind_env[plot]") from None
    figure = Figure(figsize=(10, 9.5))
    figure.subplots_adjust(left=0.1, right=0.93, top=0.97, bottom=0.055, hspace=0.1)
    FigureCanvasAgg(figure)
    _draw(record, figure, limits)
    write_atomically(path, lambda temporary: figure.savefig(temporary, dpi=130))


def _draw(record: GrindingRecord, figure: "Figure", limits: Limits | None) -> None:
    strokes = record.strokes
    time = strokes["time"] + 0.5 * strokes["seconds"]
    panels = list(figure.subplots(5, 1, sharex=True))
    depth, cut, power, flats, heat = panels

    changes = np.flatnonzero(np.diff(strokes["part"])) + 1
    pauses = np.union1d(record.dresses["after"], changes)
    Z = np.insert(1000.0 * strokes["Z"], pauses, np.nan)
    depth.step(np.insert(time, pauses, np.nan), Z, where="mid", color=BLUE, lw=1.4)
    depth.invert_yaxis()
    _label(depth, "programmed\ndepth, µm")
    _dots(cut, time, 1000.0 * strokes["ae"], pauses, BLUE)
    _label(cut, "depth of\ncut, µm")
    _dots(power, time, 0.001 * strokes["power"], pauses, ORANGE)
    _label(power, "power\nabove idle, kW")
    _dots(flats, time, 100.0 * strokes["A"], pauses, GREEN)
    _label(flats, "wear-flat\narea, %")
    _dots(heat, time, strokes["T"], pauses, RED)
    _label(heat, "temperature\nrise, K", RED)
    burn = heat.twinx()
    _dots(burn, time, np.where(strokes["ae"] >= SPARKING, strokes["Br"], np.nan), pauses, GREY)
    _limit(burn, 1.0, "burn ratio 1", GREY, burn, 1.0)
    _label(burn, "burn ratio", GREY)
    burn.grid(False)
    heat.set_xlabel("time, s")

    for panel in (cut, power, heat):
        panel.set_ylim(bottom=0.0)
    burn.set_ylim(0.0, max(1.5, burn.get_ylim()[1]))  # so that its line is not on that of the temperature
    if limits is not None:
        _limit(power, 0.001 * limits.power, f"limit {0.001 * limits.power:.2f} kW", ORANGE, power, 0.0)
        _limit(heat, limits.rise, f"temperature limit {limits.rise:.0f} K", RED, burn, 0.0)
    for panel in panels:
        _mark_dresses(panel, record)
        _mark_parts(panel, record, numbered=panel is depth)
        panel.yaxis.set_label_coords(-0.07, 0.5)
    if record.dresses.size:
        depth.legend(loc="lower left", frameon=False, fontsize=9)
    last = strokes[-1]
    heat.set_xlim(strokes["time"][0], last["time"] + last["seconds"])


def _dots(axes: "Axes", time: Any, values: Any, pauses: Any, color: str) -> None:
    """A dot per stroke, joined by a thin line that breaks where a dress or a new part comes between."""
    axes.plot(np.insert(time, pauses, np.nan), np.insert(values, pauses, np.nan), color=color, lw=0.7, alpha=0.5)
    axes.plot(time, values, "o", color=color, ms=3.0, mew=0.0)


def _limit(axes: "Axes", value: float, text: str, color: str, top: "Axes", side: float) -> None:
    """A dashed line with its text above it, on the topmost axes, at the left (0) or the right (1) end."""
    axes.axhline(value, color=color, lw=0.8, ls="--")
    axes.set_ylim(top=max(axes.get_ylim()[1], 1.2 * value))
    top.annotate(
        text,
        (side, value),
        (4.0 - 8.0 * side, 2.0),
        xycoords=("axes fraction", axes.transData),
        textcoords="offset points",
        ha="right" if side else "left",
        va="bottom",
        fontsize=8,
        color=color,
        bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8},
    )


def _label(axes: "Axes", text: str, color: str = "black") -> None:
    axes.set_ylabel(text, color=color)
    axes.tick_params(axis="y", colors=color)
    axes.grid(True, color="#e3e3e3", lw=0.6)
    axes.set_axisbelow(True)
    axes.spines["top"].set_visible(False)


def _mark_dresses(axes: "Axes", record: GrindingRecord) -> None:
    for k, dress in enumerate(record.dresses):
        label = "dress" if k == 0 else None
        axes.axvspan(dress["time"], dress["time"] + dress["seconds"], color=ORANGE, alpha=0.16, lw=0, label=label)


def labelled_every(parts: int) -> int:
    """Of that many parts every k-th is numbered: 1, 2 or 5 times a power of ten."""
    least, decade = max(math.ceil(parts / MOST_LABELS), 1), 1
    while 5 * decade < least:
        decade *= 10
    return next(step * decade for step in (1, 2, 5) if step * decade >= least)


def _mark_parts(axes: "Axes", record: GrindingRecord, numbered: bool) -> None:
    if len(record.parts) < 2:
        return
    first = np.searchsorted(record.strokes["part"], record.parts["part"])
    every = labelled_every(len(first))
    for k, (part, start) in enumerate(zip(record.parts["part"], record.strokes["time"][first], strict=True)):
        if len(first) <= MOST_LABELS:
            axes.axvline(start, color=GREY, lw=0.8, ls=":")
        if numbered and k % every == 0:
            axes.annotate(
                f"part {part}" if k == 0 or len(first) <= SHORT_LABELS else f"{part}",
                (start, 1.0),
                (3, 3),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                fontsize=9,
            )
