"""What a part costs over the dress interval."""

from typing import TYPE_CHECKING

import numpy as np

from grind_env.errors import GrindError
from grind_env.render.figures import new_figure
from grind_env.render.style import COLOURS, COLUMN, paper_style
from grind_env.shop.sweep.study import Sweep, cheapest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 2.9
"""in."""
VALLEY = "#dddddd"


def interval_figure(found: Sweep) -> "Figure":
    """Cost of a part with its 95 % interval over the parts from dress to dress, each with the best E that was swept.

    Args:
        found: of `grind_env.sweep`, which has swept dress intervals.

    Raises:
        GrindError: it has not.
        MissingExtra: matplotlib is not installed.
    """
    points = found.intervals
    if not any(point.every for point in points):
        raise GrindError(f"no dress interval was swept for {found.program}: sweep dress_every, as (1, 20)")
    every, best = np.array([point.every for point in points]), cheapest(points)
    cost, low, high = np.array([point.cost for point in points]).T
    keeps = np.array([point.keeps_limits for point in points])
    first, last = found.valley
    with paper_style():
        from matplotlib.ticker import MaxNLocator

        figure = new_figure(COLUMN, HEIGHT)
        axes = figure.subplots()
        axes.axvspan(first - 0.4, last + 0.4, color=VALLEY, lw=0, label="at most 2 % above the best")
        axes.vlines(every, low, high, color=COLOURS[1], lw=1.2)
        axes.plot(every, cost, color=COLOURS[1], lw=0.8)
        axes.plot(every[keeps], cost[keeps], "o", color=COLOURS[1], label="keeps all limits")
        if not keeps.all():
            axes.plot(every[~keeps], cost[~keeps], "o", mfc="white", color=COLOURS[1], label="beyond a limit")
        axes.plot(best.every, best.cost.value, "*", ms=10, mfc="white", color=COLOURS[0], label="best")
        axes.axhline(found.own.cost.value, color=COLOURS[0], ls="--", lw=0.8, label="program as it is")
        each = ", each with its best E" if len({point.E for point in found.speeds}) > 1 else ""
        axes.set(xlabel=f"parts from dress to dress{each}", ylabel="cost, $ a part")
        axes.set_ylim(0.0, min(axes.get_ylim()[1], 4.0 * best.cost.value))
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.grid(True)
        figure.legend(loc="outside upper left", ncols=2)
    return figure
