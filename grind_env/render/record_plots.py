"""Pictures of a grinding record, drawn by matplotlib."""

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from grind_env.machine.record import GrindingRecord
from grind_env.message_text import shortened
from grind_env.render import curve_data
from grind_env.render.figures import new_figure, write_figure
from grind_env.render.record_tables import totals

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_LABELS = 14  #: most labels of blocks, parts or dresses; of more than these every k-th is labelled

MOST_MARKS = 200  #: number of strokes up to which each has a mark; of more strokes, only points without a line have one

PANEL = 1.5  #: height of a panel, in

HEADINGS = -0.055  #: position of the headings, left of the panels, in widths of a panel

LONGEST_TITLE = 90  #: most characters of a title, which must fit the width of the picture


def plot_record(record: GrindingRecord, path: str | Path, title: str) -> None:
    """Write the picture of `draw_record` to a .png, .svg or .pdf file; arguments as there.

    Raises:
        PlotError: another suffix.
        MissingExtra: matplotlib is not installed.
        FileError: the folder does not exist or cannot be written to.
    """
    write_figure(draw_record(record, title), path)


def draw_record(record: GrindingRecord, title: str) -> "Figure":
    """Draw depth, power, heat, wheel, roughness and size of a run, a panel each.

    Strokes are drawn one by one, with marks for blocks, parts, dresses and spark-out. Many strokes are drawn as bands
    from the lowest to the highest value, by part if there are many parts.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    shown = curve_data.picture(record)
    figure = new_figure(10.0, 1.1 + PANEL * len(shown.curves))
    draw_panels(shown, figure)
    summary = figure.suptitle(f"{shortened(title, LONGEST_TITLE)}\n{totals(record)}".lstrip("\n"), fontsize=10)
    summary.set_parse_math(False)
    return figure


def draw_panels(shown: curve_data.Picture, figure: "Figure") -> None:
    """Draw all curves of a picture into an empty figure, one below the other."""
    from matplotlib.ticker import MaxNLocator

    panels: list[Axes] = list(np.atleast_1d(figure.subplots(len(shown.curves), 1, sharex=True)))
    for panel, curve in zip(panels, shown.curves, strict=True):
        _draw_curve(panel, curve, shown)
        _mark_limits(panel, curve)
        _mark_pauses(panel, shown)
        panel.yaxis.set_label_coords(HEADINGS, 0.5)  # fixed: measuring the tick labels takes half the time of a page
    if len(shown.parts) > 1:
        _name_places(panels[0], [(first, f"part {number}") for first, number in shown.parts], shown, 13.0)
    _name_places(panels[0], [(span.first, span.label) for span in shown.spans], shown, 3.0)
    _name_marks(panels[-1], shown)
    panels[-1].set_xlabel(shown.axis + (f" (bands: lowest to highest of some {shown.axis}s)" if shown.banded else ""))
    panels[-1].set_xlim(shown.edges[0], shown.edges[-1])
    panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def _draw_curve(axes: "Axes", curve: curve_data.Curve, shown: curve_data.Picture) -> None:
    if curve.downwards:
        axes.step(shown.edges, np.append(curve.mean, curve.mean[-1]), where="post", color=curve.color, lw=1.4)
    elif shown.banded:
        axes.fill_between(shown.at, curve.low, curve.high, color=curve.color, alpha=0.3, lw=0)
        axes.plot(shown.at, curve.mean, color=curve.color, lw=1.0)
    else:
        at, values = (np.insert(each, shown.breaks, np.nan) for each in (shown.at, curve.mean))
        few, known = len(at) <= MOST_MARKS, np.isfinite(np.concatenate([[np.nan], values, [np.nan]]))
        marked = known[1:-1] & (few | ~(known[:-2] | known[2:]))
        axes.plot(at, values, color=curve.color, lw=0.7, alpha=0.5 if few else 1.0)
        axes.plot(at[marked], values[marked], "o", color=curve.color, ms=3.0 if few else 1.5, mew=0.0)
    title = curve.title if curve.unit == "-" else f"{curve.title}, {curve.unit}"
    axes.set_ylabel(textwrap.fill(title, 14, break_on_hyphens=False, break_long_words=False), fontsize=9)
    axes.set_ylim(*(reversed(curve.span) if curve.downwards else curve.span))
    axes.grid(True, color=curve_data.GRID, lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _mark_limits(axes: "Axes", curve: curve_data.Curve) -> None:
    for limit in curve.limits:
        axes.axhline(limit.value, color=curve.color, lw=0.8, ls="--")
        axes.annotate(
            limit.text,
            (1.0, limit.value),
            (-4.0, 2.0 if limit.value > 0.0 else -2.0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            ha="right",
            va="bottom" if limit.value > 0.0 else "top",
            fontsize=8,
            color=curve.color,
            bbox={"boxstyle": "square,pad=0.1", "facecolor": curve_data.PAPER, "edgecolor": "none", "alpha": 0.8},
        )


def _mark_pauses(axes: "Axes", shown: curve_data.Picture) -> None:
    """Draw dresses as lines, spark-out strokes as shades, and dotted lines between blocks."""
    for at, _ in shown.dresses:
        axes.axvline(at, color=curve_data.ORANGE, lw=1.2)
    for first, after in curve_data.joined_runs(() if shown.spark_out is None else shown.spark_out):
        axes.axvspan(shown.edges[first], shown.edges[after], color=curve_data.SHADE, lw=0, zorder=0)
    if len(shown.spans) <= 2 * MOST_LABELS:
        for span in shown.spans[1:]:
            axes.axvline(shown.edges[span.first], color=curve_data.GREY, lw=0.8, ls=":")


def _name_places(axes: "Axes", places: list[tuple[int, str]], shown: curve_data.Picture, height: float) -> None:
    for first, label in places[:: curve_data.labelled_every(len(places), MOST_LABELS)]:
        axes.annotate(
            label,
            (shown.edges[first], 1.0),
            (1.0, height),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            fontsize=8,
            annotation_clip=False,
        )


def _name_marks(axes: "Axes", shown: curve_data.Picture) -> None:
    """Draw the legend of dresses and spark-out, below the numbers of the lowest panel."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    marks: list[Any] = []
    if shown.dresses:
        seconds = sorted({round(seconds) for _, seconds in shown.dresses})
        span = f"{seconds[0]}" if len(seconds) == 1 else f"{seconds[0]} to {seconds[-1]}"
        marks.append(Line2D([], [], color=curve_data.ORANGE, lw=1.2, label=f"dress, {span} s"))
    if shown.spark_out is not None and shown.spark_out.any():
        marks.append(Patch(color=curve_data.SHADE, label="spark-out"))
    if marks:
        below: Any = {"loc": "upper left", "bbox_to_anchor": (0.0, 0.0), "borderaxespad": 2.2}
        axes.legend(handles=marks, frameon=False, fontsize=8, ncols=len(marks), **below)
