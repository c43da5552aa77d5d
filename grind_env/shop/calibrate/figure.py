"""The graphs of a calibration: measured over modelled values, and residuals in order of time."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats
from grind_env.render.curve_data import BLUE, GREY, INK, ORANGE, RED
from grind_env.render.figures import new_figure
from grind_env.render.series_graphs import Graph, RuleLine, Series, draw_graph
from grind_env.shop.calibrate.least_squares import ABSOLUTE, LINEAR, YES_OR_NO
from grind_env.shop.calibrate.result import Calibration

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: units of the kinds of measurement; forces and other kinds in a table have the units of the table
UNITS = {"power": "W", "size": "µm", "Ra": "µm", "diameter": "mm"}
MOST_TICKS = 12  #: greatest number of parts that all have their number at the axis


def draw_calibration(found: Calibration) -> "Figure":
    """Draw a calibration, a panel for each kind of measurement; burn, which is yes or no, is not drawn."""
    kinds = [kind for kind in found.data.kinds if kind != YES_OR_NO and comparable(found, kind).any()]
    figure = new_figure(4.6 * max(len(kinds), 1), 4.6)
    figure.suptitle(f"Calibrated from {found.source}").set_parse_math(False)
    for axes, kind in zip(figure.subplots(1, max(len(kinds), 1), squeeze=False)[0], kinds, strict=False):
        draw_graph(axes, comparison(found, kind))
    return figure


def comparable(found: Calibration, kind: str) -> NDArray[np.bool_]:
    """Return which measurements are of a kind and can be drawn, shape (measurements,)."""
    chosen: NDArray[np.bool_] = (found.data.kind == kind) & np.isfinite(found.data.value + found.fit.predicted)
    return chosen


def comparison(found: Calibration, kind: str) -> Graph:
    """Return the graph of measured over modelled values of a kind."""
    chosen, measured, fit = comparable(found, kind), found.data.value, found.fit
    ends = [float(each(np.append(measured[chosen], fit.predicted[chosen]))) for each in (np.min, np.max)]
    catalogue = chosen & np.isfinite(fit.nominal)
    return Graph(
        x=f"modelled {named(kind)}",
        y=f"measured {named(kind)}",
        series=(
            _points(catalogue, fit.nominal, measured, name="catalogue", color=GREY, size=6.0, hollow=True),
            _points(chosen & fit.used, fit.predicted, measured, name="fit", color=BLUE),
            _points(chosen & ~fit.used, fit.predicted, measured, name="left out", color=RED, mark="x", size=6.0),
            Series(name="as measured", x=ends, y=ends, color=INK, mark="", joined=True),
        ),
        height=400,
    )


def residuals(found: Calibration, kind: str) -> Graph:
    """Return the graph of residuals of a kind in order of time: differences, or relative errors in %."""
    chosen, measured, modelled = comparable(found, kind), found.data.value, found.fit.predicted
    plain = kind in LINEAR or kind in ABSOLUTE
    with np.errstate(divide="ignore", invalid="ignore"):
        residual = measured - modelled if plain else 100.0 * (measured / modelled - 1.0)
    place, odd, used = _places(found, chosen), found.data.part % 2 == 1, found.fit.used
    whole = "part" if found.program else "setting"
    return Graph(
        x=whole,
        y=f"residual, {UNITS.get(kind, '') if plain else '%'}",
        series=(
            _points(chosen & used & odd, place, residual, name=f"{whole} 1, 3 ...", color=BLUE),
            _points(chosen & used & ~odd, place, residual, name=f"{whole} 2, 4 ...", color=ORANGE, mark="s"),
            _points(chosen & ~used, place, residual, name="left out", color=RED, mark="x", size=6.0),
        ),
        rules=(RuleLine("y", 0.0),),
        whole=int(np.ptp(found.data.part)) < MOST_TICKS,
        height=300,
    )


def named(kind: str) -> str:
    """Return a kind of measurement with its unit."""
    return f"{kind}, {UNITS[kind]}" if kind in UNITS else kind


def _places(found: Calibration, chosen: NDArray[np.bool_]) -> Floats:
    """Return the places of measurements along the axis of part numbers: around each number, in order of time."""
    place = found.data.part.astype(np.float64)
    for part in np.unique(found.data.part[chosen]).tolist():
        mine = np.flatnonzero(chosen & (found.data.part == part))
        order = mine[np.argsort(found.time[mine], kind="stable")]
        place[order] += (np.arange(order.size) + 0.5) / order.size - 0.5
    return place


def _points(which: NDArray[np.bool_], x: Floats, y: Floats, **look: Any) -> Series:
    return Series(x=x[which], y=y[which], **look)
