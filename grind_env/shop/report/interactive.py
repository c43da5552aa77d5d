"""Figures of plotly, to look into with the mouse."""

from html import escape
from typing import Any

import numpy as np

from grind_env.errors import printable
from grind_env.extras import needing
from grind_env.render.curves import GREY, GRID, INK, ORANGE, SHADE, Curve, Picture, joined_runs, labelled_every
from grind_env.render.graphs import MARKS, Graph, Series

PANEL = 130
"""px; height of a panel."""
EDGES = 110
"""px; above and below all panels."""
MOST_LABELS = 14
MOST_MARKS = 100
"""Dresses, blocks or spark-outs up to which each has its line or shade."""
FEW = 10
"""Strokes or parts that are all numbered."""
LAYOUT: dict[str, Any] = {
    "plot_bgcolor": "white",
    "dragmode": False,  # a finger scrolls the page; the bar above the plot has zooming
    "font": {"family": "system-ui, Segoe UI, Roboto, DejaVu Sans, sans-serif", "size": 11},
}


def drawn_by_plotly(shown: Picture | Graph) -> tuple[str, int]:
    """A figure as a JSON document, and its height, px.

    Raises:
        MissingExtra: plotly is not installed.
    """
    figure = run_figure(shown) if isinstance(shown, Picture) else graph_figure(shown)
    figure.update_xaxes(gridcolor=GRID, zeroline=False)
    figure.update_yaxes(gridcolor=GRID, zeroline=False)
    figure.update_layout(**LAYOUT)
    return figure.to_json(), EDGES + PANEL * len(shown.curves) if isinstance(shown, Picture) else shown.height


def plotly_text(text: str) -> str:
    """A text as a figure of plotly shows it, which would take tags in it for its own."""
    return escape(printable(text))


def graph_figure(graph: Graph) -> Any:
    """A graph as a `plotly.graph_objects.Figure`.

    Raises:
        MissingExtra: plotly is not installed.
    """
    with needing("interactive", "interactive reports need"):
        from plotly.graph_objects import Figure
    figure = Figure([_points(each, graph) for each in graph.series])
    for rule in graph.rules:
        across = figure.add_vline if rule.axis == "x" else figure.add_hline
        note = {"annotation": {"text": plotly_text(rule.text)}} if rule.text else {}
        across(rule.at, line={"dash": "dash", "width": 1, "color": INK}, **note)
    figure.update_xaxes(title_text=plotly_text(graph.x), rangemode="tozero" if graph.rows else "normal")
    if graph.log:
        figure.update_xaxes(type="log")
    if graph.whole:
        figure.update_xaxes(dtick=1)
    figure.update_yaxes(title_text=plotly_text(graph.y))
    if graph.rows:
        names = [plotly_text(row) for row in graph.rows]
        figure.update_yaxes(tickvals=list(range(len(names))), ticktext=names, range=[len(names) - 0.5, -0.5])
        figure.update_yaxes(automargin=True)
    # below, for above the plot is the bar of its buttons
    legend = {"orientation": "h", "y": -64.0 / graph.height, "yanchor": "top", "itemsizing": "constant"}
    figure.update_layout(legend=legend, margin={"l": 60, "r": 10, "t": 30, "b": 60})
    return figure


def _points(each: Series, graph: Graph) -> Any:
    from plotly.graph_objects import Scatter

    marker = {"symbol": MARKS[each.mark] + "-open" * (each.hollow or each.mark == "|"), "color": each.color}
    text = [plotly_text(text) for text in each.texts] or [plotly_text(row) for row in graph.rows]
    spread = {"error_x": {"type": "data", "array": each.half_widths}} if len(each.half_widths) else {}
    return Scatter(
        x=np.asarray(each.x, dtype=np.float64),
        y=np.asarray(each.y, dtype=np.float64),
        text=text,
        name=plotly_text(each.name),
        mode="+".join(["markers"] * bool(each.mark) + ["lines"] * each.joined),
        marker={**marker, "size": 1.3 * each.size, "line": {"width": 2, "color": each.color}},
        line={"color": each.color, "width": 1.5},
        hovertemplate=f"{'%{text}<br>' * bool(text)}%{{x:.4~g}}, %{{y:.4~g}}<extra>%{{fullData.name}}</extra>",
        showlegend=bool(each.name) and len(each.x) > 0,
        **spread,
    )


def run_figure(shown: Picture) -> Any:
    """A panel for each curve over one axis, a `plotly.graph_objects.Figure`.

    Raises:
        MissingExtra: plotly is not installed.
    """
    with needing("interactive", "interactive reports need"):
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
    figure.update_xaxes(range=[float(shown.edges[0]), float(shown.edges[-1])])
    figure.update_xaxes(title_text=shown.axis, row=rows, col=1)
    if len(shown.at) < FEW:
        figure.update_xaxes(dtick=1)
    figure.update_layout(showlegend=False, hovermode="x", margin={"l": 55, "r": 10, "t": 65, "b": 40})
    return figure


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
