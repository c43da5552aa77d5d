"""The results of the benchmark as one HTML page."""

from collections.abc import Sequence
from typing import Any

from agents.benchmark.judge import is_ratio
from agents.benchmark.page import made_by
from agents.benchmark.results import Result
from agents.benchmark.summary import HEADINGS, Summary, summaries, tasks_of
from grind_env.shop.report.document import Line, Section, figure, listing, page, plotly_text, table

HEIGHT = 80
"""px; of a figure without its bars."""
BAR = 22


def html_page(results: Sequence[Result]) -> str:
    """A section for each task, with its table and the costs as a picture.

    Raises:
        ReportError: jinja2 or plotly is not installed.
    """
    sections = [_section(results, task) for task in tasks_of(results)]
    command = [Line("", text) for text in made_by(results) if not text.startswith("```")]
    return page("Benchmark", [*sections, Section("Made by", [listing(command)])])


def _section(results: Sequence[Result], task: str) -> Section:
    lines = summaries(results, task)
    rows = [line.cells(is_ratio(task)) for line in lines]
    return Section(
        task, [table(HEADINGS, rows), figure(_costs(lines), "$ per good part, 95 %", HEIGHT + BAR * len(lines))]
    )


def _costs(lines: Sequence[Summary]) -> Any:
    """A bar for each policy."""
    from plotly.graph_objects import Bar, Figure

    bars = Bar(
        x=[line.cost.value for line in lines],
        y=[plotly_text(line.policy) for line in lines],
        error_x={"type": "data", "array": [line.cost.half_width for line in lines]},
        orientation="h",
        marker_color="#1f5f8b",
    )
    margins = {"l": 130, "r": 10, "t": 10, "b": 40}
    return Figure(bars, {"margin": margins, "plot_bgcolor": "white", "xaxis": {"type": "log", "gridcolor": "#e3e3e3"}})
