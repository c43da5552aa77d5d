"""The figure of a sweep: cost and limits over the dress interval, over E, and over lead and depth of the dress."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from grind_env.render.curve_data import BLUE, GREEN, GREY, ORANGE, RED
from grind_env.render.figures import new_figure
from grind_env.shop.dress_interval import DressInterval
from grind_env.shop.search_options import LIMITS
from grind_env.shop.sweep.study import RISK, Sweep, SweepPoint, best_of_each, cheapest
from grind_env.shop.trials import lots_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


#: colour, dashes and mark of each line; dashes and marks also differ in grey
LINES = (
    (BLUE, "-", "s"),
    (ORANGE, "--", "^"),
    ("#6a51a3", "-.", "D"),
    (RED, ":", "v"),
    ("#8c564b", "-", "P"),
    ("#5aa0d0", "--", "<"),
    ("#444444", "-.", ">"),
)
BEST = (GREEN, "-", "o")
LOOKS = dict(zip((*LIMITS, RISK), LINES, strict=False))
DEAREST = 4.0  #: highest cost on the axis, as a multiple of the best cost
AXES = {
    "every": "{counted}s from dress to dress",
    "E": "E of the first cycle block, mm/min",
    "lead": "dress lead, mm a revolution",
    "depth": "dress depth, mm a pass",
}


class SweepPanel(NamedTuple):
    """Panel of a sweep: costs over a setting, and the limits below."""

    name: str  #: name of the setting
    lines: Mapping[str, Sequence[SweepPoint]]  #: points of each line by its name
    row: Sequence[SweepPoint]  #: points whose limits are shown


def draw_sweep(found: Sweep) -> "Figure":
    """Draw a sweep."""
    panels = _panels(found)
    figure = new_figure(5.4 * max(len(panels), 1), 7.4)
    from matplotlib.ticker import MaxNLocator

    title = f"{found.program}: $ a part, batches of {found.parts} {found.counted}s, {lots_text(found.lots)}"
    figure.suptitle(title).set_parse_math(False)
    grid = figure.subplots(2, len(panels), squeeze=False, height_ratios=(1.5, 1.0))
    for panel, upper, lower in zip(panels, grid[0], grid[1], strict=True):
        _costs(upper, panel, found)
        _limits(lower, panel, found)
        for axes in (upper, lower) if panel.name == "every" else ():
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    return figure


def _panels(found: Sweep) -> list[SweepPanel]:
    panels, speeds, intervals = list[SweepPanel](), found.speeds, found.intervals
    if len(intervals) > 1:
        panels.append(SweepPanel("every", {"with the best E of each": intervals}, intervals))
    if len({point.E for point in speeds}) > 1:
        best, known = cheapest(speeds).every, [point.every for point in intervals]
        shown = sorted({known[0], known[-1], best, *known[:: max(len(known) // 4, 1)]})
        names = {every: f"dress {DressInterval(every, found.counted)}" if every else "D as it is" for every in shown}
        lines = {name: [point for point in speeds if point.every == every] for every, name in names.items()}
        panels.append(SweepPanel("E", lines, lines[names[best]]))
    if found.dresses:
        several = [name for name in ("lead", "depth") if len({getattr(each, name) for each in found.dresses}) > 1]
        name, lines = several[-1] if several else "depth", {"cost": [*found.dresses]}
        if len(several) > 1:
            leads = {cheapest(found.dresses).lead, *sorted({each.lead for each in found.dresses})[::2]}
            lines = {f"lead {lead:.3f} mm": [p for p in found.dresses if p.lead == lead] for lead in sorted(leads)}
        panels.append(SweepPanel(name, lines, best_of_each(found.dresses, name)))
    return panels


def _costs(axes: "Axes", panel: SweepPanel, found: Sweep) -> None:
    """Draw the costs: the best line with its intervals as a band, and hollow marks beyond a limit."""
    points = [point for row in panel.lines.values() for point in row]
    best, others = cheapest(points), iter(LINES)
    if panel.name == "every":
        first, last = found.valley
        span = f"{first} to {last}" if first != last else f"{first}"
        label = f"valley, up to 2 % dearer: {span}"
        axes.axvspan(first - 0.4, last + 0.4, color=GREEN, alpha=0.15, lw=0, label=label)
    for name, row in panel.lines.items():
        is_best = best in row
        color, dash, mark = BEST if is_best else next(others)
        at, (cost, low, high) = _values(row, panel.name), np.array([point.cost for point in row]).T
        if is_best:
            axes.fill_between(at, low, high, color=color, alpha=0.15, lw=0)
        axes.plot(at, cost, dash, marker=mark, ms=4, color=color, lw=1.3, label=name)
        passed = np.array([not point.keeps_limits for point in row])
        axes.plot(at[passed], cost[passed], mark, ms=4, mfc="white", color=color)
    label = f"best: E{best.E:.0f}{f', every {best.every}' if best.every else ''}"
    axes.plot(getattr(best, panel.name), best.cost.value, "*", ms=15, color=GREEN, zorder=5, label=label)
    axes.axhline(found.own.cost.value, color=GREY, ls="--", lw=1.2, label="the program as it is")
    low, high = axes.get_ylim()
    axes.set_ylim(max(low, 0.0), min(high, max(DEAREST * best.cost.value, 1.1 * found.own.cost.value)))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="upper right", title=f"hollow: {_beyond(points)}", title_fontsize=8)
    axes.set(xlabel=AXES[panel.name].format(counted=found.counted), ylabel="$ a part")


def _limits(axes: "Axes", panel: SweepPanel, found: Sweep) -> None:
    """Draw the share of each limit that 95 of 100 parts keep, and the share of the permitted risk."""
    for name, (color, dash, mark) in LOOKS.items():
        values = [100.0 * point.of_limits[name] for point in panel.row]
        if max(values) > 0.0:
            at = _values(panel.row, panel.name)
            axes.plot(at, values, dash, marker=mark, ms=3.5, lw=1.2, color=color, label=name)
    axes.axhline(100.0, color=GREY, ls="--", lw=1.2)
    axes.set_ylim(0.0, min(max(130.0, 1.25 * axes.get_ylim()[1]), 250.0))
    axes.set(xlabel=AXES[panel.name].format(counted=found.counted), ylabel="% of the limit, 95 of 100 parts")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=5, loc="upper left")


def _values(points: Sequence[SweepPoint], name: str) -> "np.typing.NDArray[np.float64]":
    return np.array([float(getattr(point, name)) for point in points])


def _beyond(points: Sequence[SweepPoint]) -> str:
    """Return the limits that bad points exceed, of each point the worst one, as text."""
    passed = {point.worst_limit for point in points if not point.keeps_limits}
    named = ", ".join(name for name in LOOKS if name in passed)
    return f"beyond a limit ({named})" if named else "beyond a limit"
