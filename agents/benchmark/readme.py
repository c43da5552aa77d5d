"""Results section of the README, and page of all results, made from the checked-in results."""

from collections.abc import Sequence

from agents.benchmark.page import page, room
from agents.benchmark.plan import ABOUT, FLAGSHIP
from agents.benchmark.results import Result
from agents.benchmark.scoring import Sampled
from agents.benchmark.summary import shown, summaries
from agents.provenance import ROOT
from grind_env.data_table import NONE, Column, table_of
from grind_env.envs.task_names import environment_id
from grind_env.files import read_text
from grind_env.policies.registry import REFERENCE, TRAINED
from grind_env.policies.tuned_parameters import ConfigError, write_whole

README = ROOT / "README.md"
BEGIN, END = "<!-- results -->", "<!-- end of results -->"
PAGE = "agents/results/README.md"
CORE_BEGIN, CORE_END = "<!-- core tasks -->", "<!-- end of core tasks -->"
#: policies of the table in the README, by the names that `grind evaluate --policy` takes
ROWS = ("constant", "look_ahead", "belief_planner", *TRAINED, REFERENCE)


def section(results: Sequence[Result]) -> str:
    """Return the results table of the README: scores, and costs on the model and on out-of-model machines.

    The bundled agents are the agents of training seed 0.
    """
    columns = (
        Column("policy", "policy"),
        Column("score (95 % CI)", lambda line: shown(line.score, False), right=True),
        Column("$ per good part", "cost", "±.2f", right=True),
        Column("$ on other machines", "plants_cost", "±.2f", right=True),
    )
    lines = [line for line in summaries([each for each in results if not each.seed], FLAGSHIP) if line.policy in ROWS]
    return table_of(columns, sorted(lines, key=lambda line: ROWS.index(line.policy))).markdown()


def core_tasks(results: Sequence[Result]) -> str:
    """Return the table of core tasks of the README, with the score of the best policy that sees measurements."""
    rows = []
    for task, about in ABOUT.items():
        known = room(task, Sampled(each for each in results if each.task == task))
        name = environment_id(task).removeprefix("grind/").removesuffix("-v0")
        rows.append((f"[{name}][r]", *about, NONE if known is None else f"{known.score.value:.0f}"))
    return table_of(("task", "parts", "hidden", "best score"), rows, left=3).markdown()


def replaced(text: str, results: Sequence[Result]) -> str:
    """Return the text of a page with both tables between their markers.

    Raises:
        ConfigError: the page lacks a marker.
    """
    for begin, end, table in ((BEGIN, END, section(results)), (CORE_BEGIN, CORE_END, core_tasks(results))):
        before, first, rest = text.partition(begin)
        _, last, after = rest.partition(end)
        if not (first and last):
            raise ConfigError(f"the page has no lines {begin!r} and {end!r} between which the results go: put them in")
        text = f"{before}{begin}\n\n{table}\n\n{end}{after}"
    return text


def write_readme(results: Sequence[Result]) -> None:
    """Put the section into the README, and write the page of all results beside the checked-in results."""
    write_whole(README, replaced(read_text(README), results))
    write_whole(ROOT / PAGE, page(results))
