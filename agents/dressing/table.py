"""Table with a line for each checked-in dress study."""

from collections.abc import Sequence
from csv import Error as CsvError
from pathlib import Path
from typing import NamedTuple

from agents.csv_tables import csv_rows, typed
from agents.dressing.findings import DressFinding, about
from grind_env.data_table import Column
from grind_env.message_text import reason
from grind_env.policies.tuned_parameters import ConfigError
from grind_env.task_version import TASK_VERSION

THRESHOLD, LEARNED, KNOWS_ALL = "power_threshold", "plain_gru", "hindsight"


class DressStudy(NamedTuple):
    """Findings for one task, with the number of episodes and the task version."""

    found: Sequence[DressFinding]
    episodes: int
    task_version: int = TASK_VERSION

    @property
    def plan(self) -> DressFinding:
        (plan,) = about(self.found, "plan")
        return plan

    @property
    def dresser(self) -> DressFinding | None:
        """Finding with the best dresser settings; None for a part program, which sets its own dresser."""
        return min(about(self.found, "dresser"), key=lambda each: each.cost, default=None)

    @property
    def often(self) -> DressFinding | None:
        """Finding with the best number of passes; None for a part program."""
        return min(about(self.found, "passes"), key=lambda each: each.cost, default=None)

    def decider(self, name: str) -> DressFinding | None:
        return next((each for each in about(self.found, "decision") if each.policy == name), None)

    def cost(self, found: DressFinding | None) -> str | None:
        """Return a cost as text, $ per good part, with its excess over the hindsight planner, %."""
        least = self.decider(KNOWS_ALL)
        if found is None or least is None:
            return None
        return f"{found.cost:.2f} ({100.0 * (found.cost / least.cost - 1.0):+.0f} %)"


def read_study(path: Path) -> DressStudy:
    """Return the study of a task from the table that the command wrote; a damaged table raises a ConfigError."""
    try:
        rows = csv_rows(path)
        found = [typed(DressFinding, row) for row in rows]
        first, last = map(int, rows[0]["seeds"].split(".."))
        # tables of the first task version do not name their version
        version = int(rows[0].get("task_version", 1))
        if missing := {"plan", "decision"} - {each.question for each in found}:
            raise ValueError(f"it does not answer {min(missing)!r}")
    except (KeyError, IndexError, TypeError, ValueError, CsvError) as error:
        task = path.stem
        raise ConfigError(
            f"{path} is damaged ({reason(error)}): run `python -m agents dress-study --task {task}` again"
        ) from None
    return DressStudy(found, last - first + 1, version)


def read_studies(folder: Path) -> list[DressStudy]:
    """Return the studies in a folder that are of the present task version."""
    studies = [read_study(each) for each in sorted(folder.glob("*.csv"))]
    return [each for each in studies if each.task_version == TASK_VERSION]


#: columns of the page, with a row per study
COLUMNS = (
    Column("task", "plan.task"),
    Column("episodes", "episodes"),
    Column("best N", "plan.every"),
    Column("fixed plan, $", lambda study: study.cost(study.plan)),
    Column("power threshold, $", lambda study: study.cost(study.decider(THRESHOLD))),
    Column(f"{LEARNED}, $", lambda study: study.cost(study.decider(LEARNED))),
    Column("hindsight, $", lambda study: study.decider(KNOWS_ALL).cost, ".2f"),
    Column("best lead, mm", "dresser.lead", "g"),
    Column("depth, mm", "dresser.depth", "g"),
    Column("overlap", "dresser.overlap", ".1f"),
    Column("N", "dresser.every"),
    Column("fixed plan with it, $", lambda study: study.cost(study.dresser)),
    Column("best passes", lambda study: study.often and f"{study.often.passes} {study.cost(study.often)}"),
)
