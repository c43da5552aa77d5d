"""The report of a calibration: what `grind calibrate --report` writes."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grind_env.extras import needing
from grind_env.shop.calibrate.figure import UNITS
from grind_env.shop.calibrate.result import Calibration, catalogue_text
from grind_env.shop.calibrate.show import error_sentences, kept_sentences, meter_sentences
from grind_env.shop.calibrate.solver import ABSOLUTE, LINEAR, YES_OR_NO
from grind_env.shop.report.document import (
    Cell,
    Line,
    Section,
    figure,
    items,
    listing,
    page,
    paragraph,
    plotly_text,
    table,
    verdict,
)
from grind_env.shop.report.foundations import foundations, revisions

if TYPE_CHECKING:
    from markupsafe import Markup


BEFORE, AFTER, LEFT_OUT = "#9aa5b1", "#1f5f8b", "#b3261e"
OTHER_PART = "#d9822b"
"""Of every second part."""
FEW, MOST_TICKS = 5, 12
"""Measurements of a kind from which on they are drawn; parts up to which each has its number at the axis."""


def calibrated_report(found: Calibration, files: Mapping[str, Path]) -> str:
    """The page of a calibration, HTML.

    Args:
        found: what it has found.
        files: by what they are, such as log and job; the page states their revisions.

    Raises:
        MissingExtra: Jinja2 or plotly is not installed.
    """
    sections = [
        Section("Verdict", [_verdict(found)]),
        Section("Constants", [_constants(found)]),
        Section("Measured and modelled", _figures(found)),
        Section("Reading of the measurements", [items(_reading(found))]),
        Section("Catalogue file", _catalogue(found)),
        Section("What the numbers rest on", [items(_rests_on(found)), *foundations(found.fitted)]),
    ]
    return page(f"Calibrated: {found.source}", sections, revisions(files))


def _verdict(found: Calibration) -> "Markup":
    count = len(found.estimates)
    told = count - len(found.not_told)
    headline = f"The measurements tell {told} of {count} constants."
    judged = [] if found.held_out is not None else ["There is too little to hold any of it out as a test."]
    return verdict("good" if told else "poor", headline, [*error_sentences(found), *judged, *kept_sentences(found)])


def _constants(found: Calibration) -> "Markup":
    rows = [
        [
            f"{each.parameter.kind} {each.parameter.entry}",
            each.parameter.key,
            each.parameter.unit,
            f"{each.parameter.prior:.4g}",
            f"{each.value:.4g}",
            f"{each.low:.3g} to {each.high:.3g}",
            f"{100.0 * each.share:.0f}",
            Cell("told", "good") if each.told else "kept",
        ]
        for each in found.estimates
    ]
    headings = ("entry", "constant", "unit", "catalogue", "estimate", "90 % interval", "spread left, %", "state")
    caption = (
        "A constant is kept at the value of the catalogue where the measurements do not tell it. The spread left is "
        "that after measuring over that before."
    )
    return table(headings, rows, caption, left=3)


def _figures(found: Calibration) -> "list[Markup]":
    whole = "part" if found.program else "setting"
    said = [
        "Grey points are the catalogue as it was, blue ones the fit, red crosses were left out; on the line the model "
        f"is right. Residuals are measured less modelled, each {whole}'s in order of time, every second {whole} orange."
    ]
    if YES_OR_NO in found.data.kinds:
        said.append("Burn, which is yes or no, is not drawn.")
    drawn, few = [paragraph(" ".join(said))], np.zeros(found.data.value.size, np.bool_)
    for kind in found.data.kinds:
        chosen = (found.data.kind == kind) & np.isfinite(found.data.value) & np.isfinite(found.fit.predicted)
        if kind != YES_OR_NO and chosen.sum() < FEW:
            few |= chosen
        elif kind != YES_OR_NO:
            drawn.append(figure(_comparison(found, kind, chosen), f"Measured over modelled {kind}", 400))
            drawn.append(figure(_residuals(found, kind, chosen, whole), f"Residuals of {kind} over {whole}s", 300))
    return [*drawn, _table(found, few)] if few.any() else drawn


def _table(found: Calibration, chosen: NDArray[np.bool_]) -> "Markup":
    """Measurements that are too few for a figure."""
    rows = [
        [
            f"{_named(str(found.data.kind[k]))}, {found.label[k]}",
            f"{found.data.value[k]:.3g}",
            f"{found.fit.predicted[k]:.3g}",
            f"{found.fit.nominal[k]:.3g}",
            "" if found.fit.used[k] else Cell("left out", "poor"),
        ]
        for k in np.flatnonzero(chosen).tolist()
    ]
    return table(("measurement", "measured", "fit", "catalogue", ""), rows)


def _comparison(found: Calibration, kind: str, chosen: NDArray[np.bool_]) -> Any:
    from plotly.graph_objects import Scatter

    measured, fit, used = found.data.value, found.fit, found.fit.used
    ends = [float(each(np.append(measured[chosen], fit.predicted[chosen]))) for each in (np.min, np.max)]
    drawn = _empty(f"modelled {_named(kind)}", f"measured {_named(kind)}")
    for name, modelled, which, marker in (
        ("catalogue", fit.nominal, chosen & np.isfinite(fit.nominal), {"color": BEFORE, "size": 4}),
        ("fit", fit.predicted, chosen & used, {"color": AFTER, "size": 5}),
        ("left out", fit.predicted, chosen & ~used, {"color": LEFT_OUT, "size": 8, "symbol": "x"}),
    ):
        drawn.add_trace(_points(found, name, modelled, measured, which, marker))
    drawn.add_trace(Scatter(x=ends, y=ends, mode="lines", line={"color": "#444", "width": 1}, hoverinfo="skip"))
    return drawn


def _residuals(found: Calibration, kind: str, chosen: NDArray[np.bool_], whole: str) -> Any:
    measured, modelled, used = found.data.value, found.fit.predicted, found.fit.used
    plain = kind in LINEAR or kind in ABSOLUTE
    with np.errstate(divide="ignore", invalid="ignore"):
        residual = measured - modelled if plain else 100.0 * (measured / modelled - 1.0)
    place, odd = _places(found, chosen), found.part % 2 == 1
    drawn = _empty(whole, f"residual, {UNITS.get(kind, '') if plain else '%'}")
    for which, marker in (
        (chosen & used & odd, {"color": AFTER, "size": 5}),
        (chosen & used & ~odd, {"color": OTHER_PART, "size": 5}),
        (chosen & ~used, {"color": LEFT_OUT, "size": 8, "symbol": "x"}),
    ):
        drawn.add_trace(_points(found, "residual", place, residual, which, marker))
    drawn.add_hline(0.0, line={"color": "#444", "width": 1})
    if int(np.ptp(found.part)) < MOST_TICKS:
        drawn.update_xaxes(dtick=1)
    return drawn


def _places(found: Calibration, chosen: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Where measurements stand over the numbers of their parts: those of one in order of time around its number."""
    place = found.part.astype(np.float64)
    for part in np.unique(found.part[chosen]).tolist():
        mine = np.flatnonzero(chosen & (found.part == part))
        order = mine[np.argsort(found.time[mine], kind="stable")]
        place[order] += (np.arange(order.size) + 0.5) / order.size - 0.5
    return place


def _points(
    found: Calibration,
    name: str,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    which: NDArray[np.bool_],
    marker: Mapping[str, Any],
) -> Any:
    from plotly.graph_objects import Scatter

    labels = [plotly_text(found.label[k]) for k in np.flatnonzero(which).tolist()]
    said = f"%{{text}}<br>%{{x:.4~g}}, %{{y:.4~g}}<extra>{name}</extra>"
    return Scatter(x=x[which], y=y[which], text=labels, name=name, mode="markers", marker=marker, hovertemplate=said)


def _empty(x: str, y: str) -> Any:
    with needing("shop", "reports need"):
        from plotly.graph_objects import Figure
    drawn = Figure()
    drawn.update_xaxes(title_text=x, gridcolor="#e3e3e3", zeroline=False)
    drawn.update_yaxes(title_text=y, gridcolor="#e3e3e3", zeroline=False)
    drawn.update_layout(
        plot_bgcolor="white",
        showlegend=False,
        dragmode=False,
        margin={"l": 60, "r": 10, "t": 20, "b": 45},
        font={"family": "system-ui, Segoe UI, Roboto, DejaVu Sans, sans-serif", "size": 11},
    )
    return drawn


def _named(kind: str) -> str:
    return f"{kind}, {UNITS[kind]}" if kind in UNITS else kind


def _reading(found: Calibration) -> list[str]:
    said = []
    if not math.isnan(found.quality):
        said.append(
            f"The strokes of {found.program} stand in the log with a median correlation of {found.quality:.3f}."
        )
        said.append("Strokes have means of their own." if found.by_stroke else "Strokes have no means of their own.")
    return [*said, *meter_sentences(found), *found.remarks]


def _catalogue(found: Calibration) -> "list[Markup]":
    if found.tells_nothing:
        return [paragraph("There is none: nothing was found that could stand in it.")]
    return [listing([Line(str(k), text) for k, text in enumerate(catalogue_text(found).splitlines(), 1)])]


def _rests_on(found: Calibration) -> list[str]:
    out = int((~found.fit.used).sum())
    enlarged = [f"{kind} by {factor:.2g}" for kind, factor in found.fit.factors.items() if factor > 1.0]
    return [
        "Constants are the most probable ones, given the measurements and how uncertain the catalogue is before them; "
        "intervals take the posterior for normal around these.",
        f"{found.data.value.size} measurements, of which {out} were left out as outliers or without a value.",
        "Errors of measurements were enlarged until residuals agree with them: " + ", ".join(enlarged) + "."
        if enlarged
        else "Residuals agree with the errors of the measurements.",
    ]
