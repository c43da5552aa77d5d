"""Figure of a dress study."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator, NullLocator

from agents.dressing.findings import DressFinding, about
from grind_env.render.curve_data import BLUE, GREEN, GREY, ORANGE

COLOURS = {"measurements": BLUE, "state": ORANGE, "future": GREEN}
TITLE = 10
WIDTH = 9.0  #: width of the figure, inches; at 90 dots per inch about the width of a page of the site
#: ratio of the cost to the best plan above which the figure leaves out an interval; the table has all intervals
DEAREST = 20.0


def dress_figure(found: Sequence[DressFinding], title: str) -> Figure:
    """Draw the answers for one problem; a part program sets its own dresser, so its figure has no dresser panels."""
    (own,) = about(found, "plan")
    shown = [each for each in about(found, "interval") if each.cost <= DEAREST * own.cost]
    drawn = [partial(draw_intervals, found=shown), partial(draw_deciders, found=about(found, "decision"), fixed=own)]
    if dressers := about(found, "dresser"):
        drawn += [partial(draw_dresser, found=dressers, own=own), partial(draw_passes, found=about(found, "passes"))]
    rows = len(drawn) // 2
    figure = Figure(figsize=(WIDTH, 4.0 * rows), dpi=90, layout="constrained")
    figure.suptitle(title)
    panels = figure.subplots(rows, 2, width_ratios=(1.3, 1.0))
    for draw, axes in zip(drawn, panels.flat, strict=True):
        draw(axes)
    figure.legend(fontsize=8, loc="outside lower right", ncols=1 + len(COLOURS))
    return figure


def draw_intervals(axes: Axes, found: Sequence[DressFinding]) -> None:
    """Draw the cost against the blocks from dress to dress, at equal distances."""
    draw_costs(axes, found, [f"{each.every}: {each.E:.0f}" for each in found])
    axes.tick_params("x", rotation=90)
    axes.set_title("one dress every N blocks", fontsize=TITLE)
    axes.set(xlabel="N, blocks: best E, mm/min", ylabel="$ per good part")


def draw_passes(axes: Axes, found: Sequence[DressFinding]) -> None:
    """Draw the cost against the passes of an execution, with the best interval for each number of passes."""
    draw_costs(axes, found, [f"{each.passes}\n{each.every}" for each in found])
    axes.set_title("passes of a dress", fontsize=TITLE)
    axes.set_xlabel("passes, and the best N")


def draw_costs(axes: Axes, found: Sequence[DressFinding], labels: Sequence[str]) -> None:
    """Draw costs and their 95 % intervals, side by side."""
    at, cost = np.arange(len(found)), np.array([each.cost for each in found])
    low, high = np.array([each.cost_low for each in found]), np.array([each.cost_high for each in found])
    axes.errorbar(at, cost, np.stack([cost - low, high - cost]), color=BLUE, marker="o", capsize=3, lw=1.2)
    axes.set_xticks(at, labels, fontsize=8)
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter("{x:g}")
    axes.grid(alpha=0.3)


def draw_dresser(axes: Axes, found: Sequence[DressFinding], own: DressFinding) -> None:
    """Draw the cost of the best fixed plan over dress lead and dress depth; the task's own dress has a frame.

    Overlap ratio and interval are below each cost.
    """
    leads, depths = (sorted({getattr(each, name) for each in found}) for name in ("lead", "depth"))
    cost = np.full((len(depths), len(leads)), np.nan)
    for each in found:
        cost[depths.index(each.depth), leads.index(each.lead)] = each.cost
    least = np.nanmin(cost)
    image = axes.imshow(cost, origin="lower", aspect="auto", cmap="cividis_r", vmin=least, vmax=1.6 * least)
    for each in found:
        at = leads.index(each.lead), depths.index(each.depth)
        dark = each.cost > 1.3 * least
        axes.text(
            *at,
            f"{each.cost:.2f}\n{each.overlap:.1f} / {each.every}",
            ha="center",
            va="center",
            fontsize=7,
            color="white" if dark else "black",
        )
    axes.set_xticks(range(len(leads)), [f"{value:g}" for value in leads])
    axes.set_yticks(range(len(depths)), [f"{value:g}" for value in depths])
    corner = leads.index(own.lead) - 0.5, depths.index(own.depth) - 0.5
    axes.add_patch(Rectangle(corner, 1.0, 1.0, fill=False, edgecolor=ORANGE, lw=2.5))
    axes.set_title("the dresser: $ per good part, overlap / best N", fontsize=TITLE)
    axes.set(xlabel="dress lead, mm per revolution", ylabel="dress depth, mm a pass")
    axes.figure.colorbar(image, ax=axes, extend="max")


def draw_deciders(axes: Axes, found: Sequence[DressFinding], fixed: DressFinding) -> None:
    """Draw the cost of the policies that decide when to dress, the cheapest on top, and of the best fixed plan."""
    ordered = sorted(found, key=lambda each: -each.cost)
    for row, each in enumerate(ordered):
        axes.plot([each.cost_low, each.cost_high], [row, row], color=COLOURS[each.sees], lw=3, alpha=0.6)
        axes.plot(each.cost, row, "o", color=COLOURS[each.sees])
        axes.annotate(
            f"{each.D:.2f}",
            (each.cost_high, row),
            (6, 0),
            textcoords="offset points",
            va="center",
            fontsize=8,
            color=GREY,
        )
    axes.set_yticks(range(len(ordered)), [each.policy for each in ordered])
    axes.axvline(fixed.cost, color=GREY, ls="--", lw=1.2, label=f"best fixed plan, N = {fixed.every}")
    axes.set_title("what decides when to dress", fontsize=TITLE)
    axes.set_xlabel("$ per good part; grey: D a block")
    for sees, colour in COLOURS.items():
        axes.plot([], [], "o", color=colour, label=f"sees {sees}")
    axes.margins(x=0.18)
    axes.grid(alpha=0.3, axis="x")
