"""Graphs of a few series over one pair of axes for any drawing library; here drawn by matplotlib."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from grind_env.array_types import Array
from grind_env.render.curve_data import GRID, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Series:
    """Points of a graph, distinguished by more than their colour."""

    name: str  #: name in the legend
    x: Sequence[float] | Array  #: coordinates, in the unit of the axis, shape (N,)
    # coordinates, in the unit of the axis, shape (N,); in a graph with rows the numbers of the rows, from 0
    y: Sequence[float] | Array
    color: str  #: colour of all points
    mark: str = "o"  #: marker of matplotlib; empty for a line alone
    size: float = 4.0  #: size of a mark, pt
    hollow: bool = False  #: whether marks are rings
    joined: bool = False  #: whether a line joins the points


class RuleLine(NamedTuple):
    """A dashed line across a graph."""

    axis: Literal["x", "y"]  #: axis of the coordinate `at`
    at: float
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Graph:
    """Graph over one pair of axes."""

    x: str  #: heading of the axis, with its unit
    y: str  #: heading of the axis, with its unit
    series: tuple[Series, ...]  #: series; later ones are drawn over earlier ones
    rules: tuple[RuleLine, ...] = ()  #: dashed lines
    rows: tuple[str, ...] = ()  #: names in place of numbers along y, from top to bottom
    whole: bool = False  #: whether x has whole numbers only
    height: int = 380  #: height of the figure in a page, px


def draw_graph(axes: "Axes", graph: Graph) -> None:
    """Draw a graph into axes of matplotlib."""
    from matplotlib.ticker import MaxNLocator

    for each in graph.series:
        shape: dict[str, Any] = {"marker": each.mark, "ms": each.size, "mew": 2.0 if each.mark == "|" else 1.0}
        fill = "none" if each.hollow else each.color
        line: dict[str, Any] = {"color": each.color, "ls": "-" if each.joined else "", "lw": 1.2 if each.mark else 0.8}
        axes.plot(each.x, each.y, mfc=fill, label=each.name if len(each.x) else "", **shape, **line)
    for rule in graph.rules:
        across = axes.axvline if rule.axis == "x" else axes.axhline
        across(rule.at, color=INK, ls="--", lw=1.0, label=rule.text)
    axes.set(xlabel=graph.x, ylabel=graph.y)
    axes.grid(True, color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    if graph.rows:
        axes.set_yticks(range(len(graph.rows)), graph.rows)
        axes.set_ylim(len(graph.rows) - 0.5, -0.5)
        axes.set_xlim(left=0.0)
    if graph.whole:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    if any(axes.get_legend_handles_labels()[1]):
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, frameon=False)
