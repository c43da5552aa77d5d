"""The picture of a calibration: measured over modelled values, with the catalogue as it was and with the fit."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grind_env.render.figures import new_figure
from grind_env.render.plots import BLUE, GREY, RED
from grind_env.shop.calibrate.result import Calibration
from grind_env.shop.calibrate.sheet import Floats
from grind_env.shop.calibrate.solver import YES_OR_NO

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

UNITS = {"power": "W", "size": "µm", "Ra": "µm", "diameter": "mm"}
"""Of the kinds of measurement; forces and the others of a table have those of the table."""


def draw_calibration(found: Calibration) -> "Figure":
    """Draw a calibration, a panel for each kind of measurement; burn, which is yes or no, is not drawn.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    kinds = [kind for kind in found.data.kinds if kind != YES_OR_NO]
    figure = new_figure(4.6 * max(len(kinds), 1), 4.6)
    figure.suptitle(f"Calibrated from {found.source}").set_parse_math(False)
    for axes, kind in zip(figure.subplots(1, len(kinds), squeeze=False)[0], kinds, strict=True):
        _compare(axes, found, kind)
    return figure


def _compare(axes: "Axes", found: Calibration, kind: str) -> None:
    measured, fit = found.data.value, found.fit
    mine = (found.data.kind == kind) & np.isfinite(measured)
    styles: list[tuple[str, Floats, NDArray[np.bool_], dict[str, Any]]] = [
        ("catalogue", fit.nominal, mine, {"marker": "o", "mfc": "none", "color": GREY, "ms": 7}),
        ("fit", fit.predicted, mine & fit.used, {"marker": "o", "color": BLUE, "ms": 4}),
        ("left out", fit.predicted, mine & ~fit.used, {"marker": "x", "color": RED, "ms": 6}),
    ]
    for name, modelled, chosen, style in styles:
        if chosen.any():
            axes.plot(modelled[chosen], measured[chosen], ls="", label=name, **style)
    axes.axline((float(np.median(measured[mine])),) * 2, slope=1.0, color="black", lw=0.8, label="as measured")
    unit = f", {UNITS[kind]}" if kind in UNITS else ""
    axes.set(xlabel=f"modelled {kind}{unit}", ylabel=f"measured {kind}{unit}")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
