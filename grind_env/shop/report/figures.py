"""The pictures of `render.curves` as figures of plotly, to look into with the mouse."""

from typing import Any

import numpy as np

from grind_env.extras import needing
from grind_env.render.curves import GREY, ORANGE, Curve, Picture, joined_runs, labelled_every

PANEL = 130
"""px; height of a panel."""
EDGES = 110
"""px; above and below all panels."""
MOST_LABELS = 14
MOST_MARKS = 100
"""Dresses, blocks or spark-outs up to which each has its line or shade."""
SHADE = "#efe7da"
FEW = 10
"""Strokes or parts that are all numbered."""


def run_figure(shown: Picture) -> Any:
    """A panel for each curve over one axis, a `plotly.graph_objects.Figure`; its height is that of `run_height`.

    Raises:
        MissingExtra: plotly is not installed.
    """
    with needing("shop", "reports need"):
        from plotly.subplots import make_subplots
    rows = len(shown.curves)
    titles = [_heading(curve) for curve in shown.curves]
    figure = make_subplots(rows=rows, cols=1, shared_xaxes=True, vertical_spacing=0.3 / rows, subplot_titles=titles)
    figure.update_annotations(x=0.0, xanchor="left", font_size=12)
    for row, curve in enumerate(shown.curves, 1):
        for trace in _traces(curve, shown):
            figure.add_trace(trace, row=row, col=1)
        for limit in curve.limits:
            figure.add_hline(
                limit.value,
                row=row,
                col=1,
                line={"dash": "dash", "width": 1, "color": curve.color},
                annotation={"text": limit.text, "font": {"size": 10, "color": curve.color}},
                annotation_position="top right" if limit.value > 0.0 else "bottom right",
            )
        low, high = curve.span
        figure.update_yaxes(range=[high, low] if curve.downwards else [low, high], row=row, col=1)
    _mark(figure, shown)
    figure.update_xaxes(range=[float(shown.edges[0]), float(shown.edges[-1])], gridcolor="#e3e3e3", zeroline=False)
    figure.update_xaxes(title_text=shown.axis, row=rows, col=1)
    if len(shown.at) < FEW:
        figure.update_xaxes(dtick=1)
    figure.update_yaxes(gridcolor="#e3e3e3", zeroline=False)
    figure.update_layout(
        plot_bgcolor="white",
        showlegend=False,
        hovermode="x",
        dragmode=False,  # a finger scrolls the page; the bar above the plot has zooming
        margin={"l": 55, "r": 10, "t": 65, "b": 40},
        font={"family": "system-ui, Segoe UI, Roboto, DejaVu Sans, sans-serif", "size": 11},
    )
    return figure


def run_height(shown: Picture) -> int:
    """Height of `run_figure`, px."""
    return EDGES + PANEL * len(shown.curves)


def _heading(curve: Curve) -> str:
    return curve.title if curve.unit == "-" else f"{curve.title}, {curve.unit}"


def _traces(curve: Curve, shown: Picture) -> list[Any]:
    from plotly.graph_objects import Scatter

    unit = "" if curve.unit == "-" else f" {curve.unit}"
    said = f"%{{x}}: %{{y:.4~g}}{unit}<extra></extra>"
    line = {"color": curve.color, "width": 1}
    at = shown.at.astype(np.float32)
    low, mean, high = (side.astype(np.float32) for side in (curve.low, curve.mean, curve.high))
    if curve.downwards:
        steps = line | {"shape": "hvh", "width": 2}
        return [Scatter(x=at, y=mean, mode="lines+markers", line=steps, marker={"size": 3}, hovertemplate=said)]
    if shown.banded:
        edge: dict[str, Any] = {"x": at, "mode": "lines", "line": {"width": 0, "color": curve.color}}
        return [
            Scatter(y=low, hoverinfo="skip", **edge),
            Scatter(y=high, hoverinfo="skip", fill="tonexty", **edge),
            Scatter(x=at, y=mean, mode="lines", line=line, hovertemplate=said),
        ]
    at, mean = np.insert(at, shown.breaks, np.nan), np.insert(mean, shown.breaks, np.nan)
    return [Scatter(x=at, y=mean, mode="lines+markers", line=line, marker={"size": 4}, hovertemplate=said)]


def _mark(figure: Any, shown: Picture) -> None:
    """Dresses as lines, spark-out strokes as shades, blocks and parts with their numbers."""
    every_panel: dict[str, Any] = {"yref": "paper", "y0": 0.0, "y1": 1.0, "layer": "below"}
    shapes = [
        dict(type="line", x0=at, x1=at, line={"color": ORANGE, "width": 1.2}, **every_panel)
        for at, _ in shown.dresses[:MOST_MARKS]
    ]
    sparks = joined_runs(() if shown.spark_out is None else shown.spark_out)
    shapes += [
        dict(
            type="rect",
            x0=float(shown.edges[first]),
            x1=float(shown.edges[after]),
            fillcolor=SHADE,
            line={"width": 0},
            **every_panel,
        )
        for first, after in sparks[:MOST_MARKS]
    ]
    shapes += [
        dict(
            type="line",
            x0=float(shown.edges[span.first]),
            x1=float(shown.edges[span.first]),
            line={"color": GREY, "width": 1, "dash": "dot"},
            **every_panel,
        )
        for span in shown.spans[1 : MOST_MARKS + 1]
    ]
    for shape in shapes:
        figure.add_shape(shape)
    labels = [(span.first, span.label) for span in shown.spans]
    if len(shown.parts) > 1:
        labels = [(first, f"part {number}") for first, number in shown.parts]
    for first, label in labels[:: labelled_every(len(labels), MOST_LABELS)] if labels else ():
        figure.add_annotation(
            x=float(shown.edges[first]),
            y=1.0,
            yref="paper",
            yshift=38,
            text=label,
            showarrow=False,
            xanchor="left",
            font={"size": 11, "color": "#444"},
        )
