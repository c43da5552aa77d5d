"""A line of a table for each dress study, from the checked-in ones."""

from collections.abc import Sequence
from csv import DictReader
from csv import Error as CsvError
from dataclasses import fields
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

from agents.benchmark.summary import NONE
from agents.dressing.study import Finding, about
from grind_env.errors import reason
from grind_env.files import read_text
from grind_env.policies.tuned import ConfigError
from grind_env.task_version import TASK_VERSION

THRESHOLD, LEARNED, KNOWS_ALL = "power_threshold", "learned", "hindsight"
HEADINGS = (
    "task",
    "episodes",
    "best N",
    "fixed plan, $",
    "power threshold, $",
    "learned, $",
    "hindsight, $",
    "best lead, mm",
    "depth, mm",
    "overlap",
    "N",
    "fixed plan with it, $",
    "best passes",
)


class Study(NamedTuple):
    """What was found for one task, on how many episodes, and in which version of the tasks."""

    found: Sequence[Finding]
    episodes: int
    task_version: int = TASK_VERSION


def read_study(path: Path) -> Study:
    """The study of a task, from the table that the command wrote.

    Raises:
        ConfigError: if the file is damaged.
    """
    try:
        rows = list(DictReader(StringIO(read_text(path), newline="")))
        found = [Finding(**{each.name: _value(each.type, row[each.name]) for each in fields(Finding)}) for row in rows]
        first, last = map(int, rows[0]["seeds"].split(".."))
        # the first version was written down nowhere
        version = int(rows[0].get("task_version", 1))
        if missing := {"plan", "decision"} - {each.question for each in found}:
            raise ValueError(f"it does not answer {min(missing)!r}")
    except (KeyError, IndexError, TypeError, ValueError, CsvError) as error:
        task = path.stem
        raise ConfigError(
            f"{path} is damaged ({reason(error)}): run `python -m agents dress-study --task {task}` again"
        ) from None
    return Study(found, last - first + 1, version)


def _value(kind: Any, text: str) -> Any:
    return kind(text)


def read_studies(folder: Path) -> list[Study]:
    """The studies in a folder that are of the present task version.

    Raises:
        ConfigError: if a file is damaged.
    """
    studies = [read_study(each) for each in sorted(folder.glob("*.csv"))]
    return [each for each in studies if each.task_version == TASK_VERSION]


def line(study: Study) -> list[str]:
    """The cells of a task: costs are $ per good part, with how much more they are than those of the planner."""
    deciders = {each.policy: each for each in about(study.found, "decision")}
    least = deciders[KNOWS_ALL].cost

    def cost(each: Finding | None) -> str:
        return NONE if each is None else f"{each.cost:.2f} ({100.0 * (each.cost / least - 1.0):+.0f} %)"

    (plan,) = about(study.found, "plan")
    cells = [
        plan.task,
        str(study.episodes),
        str(plan.every),
        cost(plan),
        cost(deciders[THRESHOLD]),
        cost(deciders.get(LEARNED)),
        f"{least:.2f}",
    ]
    dressers, passes = (about(study.found, question) for question in ("dresser", "passes"))
    if not dressers:
        # a program says itself how it dresses
        return [*cells, *[NONE] * (len(HEADINGS) - len(cells))]
    dresser, often = (min(each, key=lambda one: one.cost) for each in (dressers, passes))
    return [
        *cells,
        f"{dresser.lead:g}",
        f"{dresser.depth:g}",
        f"{dresser.overlap:.1f}",
        str(dresser.every),
        cost(dresser),
        f"{often.passes} {cost(often)}",
    ]
