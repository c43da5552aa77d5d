"""The results section of the README, from the checked-in results, and the page of all of them."""

from collections.abc import Sequence
from pathlib import Path

from agents.benchmark.judge import is_ratio
from agents.benchmark.page import page, table
from agents.benchmark.plan import EMPIRICAL, FLAGSHIP, LONG, ROBUST
from agents.benchmark.results import Result
from agents.benchmark.summary import KNOWLEDGE, NONE, Summary, shown, summaries
from agents.provenance import ROOT
from grind_env.files import read_text
from grind_env.policies.statistics import Interval
from grind_env.policies.tuned import ConfigError, write_whole

README = ROOT / "README.md"
BEGIN, END = "<!-- results: written by `python -m agents benchmark --report` -->", "<!-- end of results -->"
PAGE = "agents/results/README.md"
WITHOUT_SENSORS = ("handbook", "constant")
AGENTS, RECIPE = 2, "ppo"
"""Agents in the table of the README at most, and the one of its recipe."""


def section(results: Sequence[Result], task: str = FLAGSHIP) -> str:
    """The text between the markers of the README: what a task costs with the policies that say most of it.

    Beside them stands what a good part costs on machines that are not the model.
    """
    headings = ("policy", "score (95 %)", "sees", "$ per good part", "on other machines, $", "scrap there, %")
    rows = [
        [
            line.policy,
            shown(line.ratio if is_ratio(task) else line.score, is_ratio(task)),
            line.sees,
            dollars(line.cost),
            NONE if line.plants_cost is None else dollars(line.plants_cost),
            NONE if line.plants_scrap is None else f"{100.0 * line.plants_scrap:.1f}",
        ]
        for line in telling(summaries(results, task))
    ]
    return table(headings, rows)


def dollars(cost: Interval) -> str:
    """A cost with half its interval."""
    return f"{cost.value:.2f} ± {cost.half_width:.2f}"


def telling(lines: Sequence[Summary]) -> list[Summary]:
    """Those without sensors, the best rule and agents on measurements, the agent of the recipe, and the planners."""
    plans = [line for line in lines if line.policy in WITHOUT_SENSORS]
    measured = [line for line in reversed(lines) if line.sees == KNOWLEDGE[0] and line not in plans]
    rules, agents = ([line for line in measured if line.kind == kind] for kind in ("scripted", "learned"))
    kept = [*plans, *rules[:1], *agents[:AGENTS]]
    return [line for line in lines if line in kept or line.policy in (*LONG, RECIPE, ROBUST, EMPIRICAL)]


def replaced(text: str, results: Sequence[Result]) -> str:
    """The text of a page with the section between its markers."""
    return between(text, BEGIN, END, section(results))


def between(text: str, begin: str, end: str, results: str) -> str:
    """The text of a page with other results between two lines.

    Raises:
        ConfigError: if the page has no such lines.
    """
    before, first, rest = text.partition(begin)
    _, last, after = rest.partition(end)
    if not (first and last):
        raise ConfigError(f"the page has no lines {begin!r} and {end!r} between which the results go: put them in")
    return f"{before}{begin}\n\n{results}\n\n{end}{after}"


def write_readme(results: Sequence[Result], path: Path = README) -> None:
    """Put the section into a page, and write that of all results beside the checked-in ones."""
    write_whole(path, replaced(read_text(path), results))
    write_whole(ROOT / PAGE, page(results))
