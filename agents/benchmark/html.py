"""The results of the benchmark as one HTML page."""

from collections.abc import Sequence

from agents.benchmark.page import made_by
from agents.benchmark.results import Result
from agents.benchmark.summary import PolicySummary, summaries, table_of_task, tasks_of
from grind_env.render.curves import BLUE
from grind_env.render.graphs import Graph, Series
from grind_env.shop.report.document import Section, figure, listing, page, table

HEIGHT = 80
"""px; of a figure without its rows."""
ROW = 22


def html_page(results: Sequence[Result]) -> str:
    """Return a page with a section for each task, with its table and the costs as a picture."""
    sections = [_section(results, task) for task in tasks_of(results)]
    command = [text for text in made_by(results) if not text.startswith("```")]
    return page("Benchmark", [*sections, Section("Made by", listing(command, numbered=False))])


def _section(results: Sequence[Result], task: str) -> Section:
    costs = figure(_costs(summaries(results, task)), "$ per good part, 95 %")
    return Section(task, [table(table_of_task(results, task)), costs])


def _costs(lines: Sequence[PolicySummary]) -> Graph:
    """A point for each policy."""
    costs = Series(
        name="",
        x=[line.cost.value for line in lines],
        y=range(len(lines)),
        half_widths=[line.cost.half_width for line in lines],
        color=BLUE,
    )
    rows = tuple(line.policy for line in lines)
    return Graph(x="$ per good part", y="", series=(costs,), rows=rows, log=True, height=HEIGHT + ROW * len(lines))
