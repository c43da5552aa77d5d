"""The results section of the README, from the checked-in results, and the page of all of them."""

from collections.abc import Sequence

from agents.benchmark.judge import is_ratio
from agents.benchmark.page import page, shipped_kind
from agents.benchmark.plan import FLAGSHIP, ROBUST
from agents.benchmark.results import Result
from agents.benchmark.summary import PolicySummary, shown, summaries
from agents.provenance import ROOT
from grind_env.files import read_text
from grind_env.policies.registry import REFERENCE
from grind_env.policies.tuned import ConfigError, write_whole
from grind_env.table import Column, table_of

README = ROOT / "README.md"
BEGIN, END = "<!-- results: written by `python -m agents benchmark --report` -->", "<!-- end of results -->"
PAGE = "agents/results/README.md"
SHIPPED = "shipped"
ROWS = ("constant", "look_ahead", "belief_planner", SHIPPED, ROBUST, REFERENCE)
"""Policies of the table in the README, by the names that `grind evaluate --policy` takes."""


def section(results: Sequence[Result], task: str = FLAGSHIP) -> str:
    """Return the results table of the README: scores, and costs on the model and on out-of-model machines.

    The bundled agents are the ones of training seed 0.
    """
    ratio, kind = is_ratio(task), shipped_kind(task)

    def name(line: PolicySummary) -> str:
        return SHIPPED if line.policy == kind else line.policy

    columns = (
        Column("policy", name),
        Column("score (95 % CI)", lambda line: shown(line.ratio if ratio else line.score, ratio), right=True),
        Column("$ per good part", "cost", "±.2f", right=True),
        Column("$ on other machines", "plants_cost", "±.2f", right=True),
    )
    lines = [line for line in summaries([each for each in results if not each.seed], task) if name(line) in ROWS]
    return table_of(columns, sorted(lines, key=lambda line: ROWS.index(name(line)))).markdown()


def replaced(text: str, results: Sequence[Result]) -> str:
    """Return the text of a page with the section between its markers.

    Raises:
        ConfigError: the page has no such lines.
    """
    before, first, rest = text.partition(BEGIN)
    _, last, after = rest.partition(END)
    if not (first and last):
        raise ConfigError(f"the page has no lines {BEGIN!r} and {END!r} between which the results go: put them in")
    return f"{before}{BEGIN}\n\n{section(results)}\n\n{END}{after}"


def write_readme(results: Sequence[Result]) -> None:
    """Put the section into the README, and write the page of all results beside the checked-in ones."""
    write_whole(README, replaced(read_text(README), results))
    write_whole(ROOT / PAGE, page(results))
