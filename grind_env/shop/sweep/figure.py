"""The picture of a sweep: cost and limits over the dress interval, over E, and over lead and depth of the dress."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from grind_env.render.figures import new_figure
from grind_env.render.plots import BLUE, GREEN, GREY, ORANGE, RED
from grind_env.shop.dress_interval import DressInterval
from grind_env.shop.sweep.study import RISK, Sweep, SweepPoint, cheapest
from grind_env.shop.trials import LIMITS, lots_said

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Look(NamedTuple):
    """Of a line: its dashes and marks tell it from others in grey, too."""

    color: str
    dash: str = "-"
    mark: str = "o"


LINES = (
    Look(BLUE, "-", "s"),
    Look(ORANGE, "--", "^"),
    Look("#6a51a3", "-.", "D"),
    Look(RED, ":", "v"),
    Look("#8c564b", "-", "P"),
    Look("#5aa0d0", "--", "<"),
    Look("#444444", "-.", ">"),
)
"""Of the dress intervals that are shown over E, beside the best one."""
BEST = Look(GREEN)
LOOKS = dict(zip((*LIMITS, RISK), LINES, strict=False))
DEAREST = 4.0
"""Times the best cost above which a cost is drawn as that."""


def draw_sweep(found: Sweep) -> "Figure":
    """Draw a sweep.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    panels = _panels(found)
    figure = new_figure(5.4 * max(len(panels), 1), 7.4)
    from matplotlib.ticker import MaxNLocator

    figure.suptitle(
        f"{found.program}: $ a part, batches of {found.parts} runs, {lots_said(found.lots)}"
    ).set_parse_math(False)
    grid = figure.subplots(2, len(panels), squeeze=False, height_ratios=(1.5, 1.0))
    for (draw_cost, draw_limits), upper, lower in zip(panels, grid[0], grid[1], strict=True):
        draw_cost(upper)
        draw_limits(lower)
        for axes in (upper, lower):
            if "from dress to dress" in axes.get_xlabel():
                axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    return figure


Draw = Callable[["Axes"], None]


def _panels(found: Sweep) -> list[tuple[Draw, Draw]]:
    panels: list[tuple[Draw, Draw]] = []
    if len(found.intervals) > 1:
        points = found.intervals
        every = [float(point.every) for point in points]
        label = f"{found.counted}s from dress to dress, each with its best E"
        panels.append((lambda axes: _intervals(axes, found, points), lambda axes: _shares(axes, every, points, label)))
    if len({point.E for point in found.speeds}) > 1:
        best = cheapest(found.speeds)
        row = [point for point in found.speeds if point.every == best.every]
        at = [point.E / 1000.0 for point in row]
        which = f", a dress {DressInterval(best.every, found.counted)}" if best.every > 1 else ""
        name = f"E of the first cycle block, m/min{which}"
        panels.append((lambda axes: _speeds(axes, found), lambda axes: _shares(axes, at, row, name)))
    if found.dresses:
        points_of_dress = found.dresses
        panels.append((lambda axes: _dresses(axes, found), lambda axes: _dress_shares(axes, points_of_dress)))
    return panels


def _intervals(axes: "Axes", found: Sweep, points: Sequence[SweepPoint]) -> None:
    """Cost over the dress interval; the valley around the best one is shaded."""
    best = cheapest(points)
    every = np.array([point.every for point in points])
    first, last = found.valley
    axes.axvspan(
        first - 0.4, last + 0.4, color=GREEN, alpha=0.15, lw=0, label=f"valley, up to 2 % dearer: {_span(found)}"
    )
    _cost(axes, every, points, Look(BLUE), "with the best E of each")
    axes.plot(
        best.every, best.cost.value, "*", ms=15, color=GREEN, zorder=5, label=f"best: {best.every}, E{best.E:.0f}"
    )
    axes.axhline(found.own.cost.value, color=GREY, ls="--", lw=1.2, label="the program as it is")
    _finish(axes, best, found, points)
    axes.set(xlabel=f"{found.counted}s from dress to dress", ylabel="$ a part")


def _speeds(axes: "Axes", found: Sweep) -> None:
    """Cost over E, a line for some dress intervals; the best one with its intervals."""
    best = cheapest(found.speeds)
    known = sorted({point.every for point in found.speeds})
    shown = sorted({known[0], known[-1], best.every, *known[:: max(len(known) // 4, 1)]})
    others = iter(LINES)
    for every in shown:
        row = [point for point in found.speeds if point.every == every]
        look = BEST if every == best.every else next(others)
        name = f"dress every {every}" if every else "D as it is"
        _cost(axes, np.array([point.E for point in row]) / 1000.0, row, look, name, band=look is BEST)
    axes.plot(best.E / 1000.0, best.cost.value, "*", ms=15, color=GREEN, zorder=5)
    axes.axhline(found.own.cost.value, color=GREY, ls="--", lw=1.2, label="the program as it is")
    _finish(axes, best, found, [point for point in found.speeds if point.every in shown])
    axes.set(xlabel="E of the first cycle block, m/min", ylabel="$ a part")


def _dresses(axes: "Axes", found: Sweep) -> None:
    """Cost over lead and depth: a map if both are swept, else a line; what is beyond a limit is crossed out."""
    points = found.dresses
    leads, depths = sorted({point.lead for point in points}), sorted({point.depth for point in points})
    best = cheapest(points)
    if min(len(leads), len(depths)) == 1:
        name = "lead" if len(leads) > 1 else "depth"
        _cost(axes, np.array([getattr(point, name) for point in points]), points, Look(BLUE), "")
        axes.plot(getattr(best, name), best.cost.value, "*", ms=15, color=GREEN, zorder=5)
        axes.axhline(found.own.cost.value, color=GREY, ls="--", lw=1.2, label="the program as it is")
        _finish(axes, best, found, points)
        axes.set(xlabel=_name(name), ylabel="$ a part")
        return
    cost = np.full((len(depths), len(leads)), np.nan)
    for point in points:
        cost[depths.index(point.depth), leads.index(point.lead)] = point.cost.value
    least = best.cost.value
    image = axes.imshow(cost, origin="lower", aspect="auto", cmap="cividis_r", vmin=least, vmax=1.6 * least)
    for point in points:
        at = leads.index(point.lead), depths.index(point.depth)
        text = f"{point.cost.value:.2f}" if point.keeps_limits else "x"
        color = "white" if point.cost.value > 1.3 * least else "black"
        axes.text(*at, text, ha="center", va="center", fontsize=7, color=color)
    axes.plot(leads.index(best.lead), depths.index(best.depth) + 0.32, "*", ms=10, color=GREEN)
    axes.set_xticks(range(len(leads)), [f"{lead:.3f}" for lead in leads], rotation=45)
    axes.set_yticks(range(len(depths)), [f"{depth:.4f}" for depth in depths])
    axes.set(xlabel=_name("lead"), ylabel=_name("depth"), title=f"$ a part; x: {_beyond(points)}")
    axes.figure.colorbar(image, ax=axes, extend="max")


def _dress_shares(axes: "Axes", points: Sequence[SweepPoint]) -> None:
    """The limits over lead, with the best depth of each, or over depth if the lead is not swept."""
    name = "lead" if len({point.lead for point in points}) > 1 else "depth"
    known = sorted({getattr(point, name) for point in points})
    best = [cheapest([point for point in points if getattr(point, name) == value]) for value in known]
    _shares(axes, known, best, _name(name))


def _cost(
    axes: "Axes",
    at: "np.typing.NDArray[np.float64]",
    points: Sequence[SweepPoint],
    look: Look,
    label: str,
    *,
    band: bool = True,
) -> None:
    """Costs, with their intervals as a band; hollow where a limit is passed."""
    cost, low, high = np.array([point.cost for point in points]).T
    color, dash, mark = look
    if band:
        axes.fill_between(at, low, high, color=color, alpha=0.15, lw=0)
    axes.plot(at, cost, dash, marker=mark, ms=4, color=color, lw=1.3, label=label or None)
    keeps = np.array([point.keeps_limits for point in points])
    axes.plot(at[~keeps], cost[~keeps], mark, ms=4, mfc="white", color=color)


def _shares(axes: "Axes", at: Sequence[float], points: Sequence[SweepPoint], label: str) -> None:
    """What 95 of 100 parts keep of each limit, and what is risked of what may be."""
    for name in (*LIMITS, RISK):
        values = [100.0 * point.of_limits[name] for point in points]
        if max(values) > 0.0:
            color, dash, mark = LOOKS[name]
            axes.plot(at, values, dash, marker=mark, ms=3.5, lw=1.2, color=color, label=name)
    axes.axhline(100.0, color=GREY, ls="--", lw=1.2)
    axes.set_ylim(0.0, min(max(130.0, 1.25 * axes.get_ylim()[1]), 250.0))
    axes.set(xlabel=label, ylabel="% of the limit, 95 of 100 parts")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=5, loc="upper left")


def _finish(axes: "Axes", best: SweepPoint, found: Sweep, points: Sequence[SweepPoint]) -> None:
    low, high = axes.get_ylim()
    most = max(DEAREST * best.cost.value, 1.1 * found.own.cost.value)
    axes.set_ylim(max(low, 0.0), min(high, most))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="upper right", title=f"hollow: {_beyond(points)}", title_fontsize=8)


def _beyond(points: Sequence[SweepPoint]) -> str:
    """What points that do not keep the limits are beyond: the limits that are passed by most."""
    passed = {point.worst_limit for point in points if not point.keeps_limits}
    named = ", ".join(name for name in LOOKS if name in passed)
    return f"beyond a limit ({named})" if named else "beyond a limit"


def _span(found: Sweep) -> str:
    first, last = found.valley
    return f"{first} to {last}" if first != last else str(first)


def _name(name: str) -> str:
    return "dress lead, mm a revolution" if name == "lead" else "dress depth, mm a pass"
