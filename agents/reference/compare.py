"""Sets the measured reference costs beside the published ones (scenarios, section 5).

`python -m agents.reference.compare [FOLDER]` prints the table.
"""

import csv
import io
import sys
from collections.abc import Iterable
from math import hypot, sqrt
from pathlib import Path
from statistics import NormalDist
from typing import NamedTuple

from rich.table import Table

from grind_env.errors import reason
from grind_env.files import read_text
from grind_env.policies.statistics import COVERAGE
from grind_env.policies.tuned import ConfigError
from grind_env.task_version import TASK_VERSION
from grind_env.terminal import command, table_console
from grind_env.toml import tomllib

PUBLISHED = Path(__file__).with_name("published.toml")
MOST_ERRORS = 2.0
"""Standard errors of a difference up to which two means agree."""
NORMAL_ERRORS = NormalDist().inv_cdf(0.5 + COVERAGE / 2.0)
"""Half an interval over the standard error."""


class Comparison(NamedTuple):
    """One published cost and ours, $ per good part."""

    task: str
    policy: str
    published: float
    rounding: float
    """Standard deviation of the rounding of the published number."""
    ours: float
    error: float
    """Standard error of ours; that of the published number is taken to be the same, from as many episodes."""

    @property
    def difference(self) -> float:
        """Ours over the published cost, less one, %."""
        return 100.0 * (self.ours / self.published - 1.0)

    @property
    def errors(self) -> float:
        """The difference in standard errors of a difference."""
        return (self.ours - self.published) / max(hypot(sqrt(2.0) * self.error, self.rounding), 1e-9)


def main() -> None:
    """Print the table of all tasks."""
    from agents.cells import RESULTS
    from agents.reference.scores import scored_problems

    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else RESULTS
    table_console().print(comparison_table(compare([problem.name for problem in scored_problems()], folder)))


def compare(tasks: Iterable[str], results: Path, published: Path = PUBLISHED) -> list[Comparison]:
    """Every published cost of the tasks beside ours; tasks that have not been measured in their version are left out.

    Raises:
        ConfigError: if a table of results is damaged.
    """
    costs = tomllib.loads(published.read_text(encoding="utf-8"))
    found = []
    for task in tasks:
        path = results / f"{task}.csv"
        if task not in costs or not path.exists():
            continue
        try:
            ours = {row["policy"]: row for row in csv.DictReader(io.StringIO(read_text(path), newline=""))}
            beside = [compared(task, policy, text, ours[policy]) for policy, text in costs[task].items()]
            if all(row.get("task_version") == str(TASK_VERSION) for row in ours.values()):
                found += beside
        except (KeyError, ValueError, csv.Error) as error:
            raise ConfigError(
                f"{path} is damaged ({reason(error)}): run `python -m agents scores --task {task}`"
            ) from error
    return found


def compared(task: str, policy: str, text: str, row: dict[str, str]) -> Comparison:
    """One comparison, of the published number as printed and a row of a table of results."""
    ours, low, high = (float(row[f"cost_per_good_part{end}"]) for end in ("", "_low", "_high"))
    last_digit = 10.0 ** -len(text.partition(".")[2])
    error = 0.5 * (high - low) / NORMAL_ERRORS
    return Comparison(task, policy, float(text), last_digit / sqrt(12.0), ours, error)


def comparison_table(found: Iterable[Comparison]) -> Table:
    """The table for a terminal."""
    table = Table(title="Published and measured cost, $ per good part")
    for heading in ("task", "policy"):
        table.add_column(heading)
    for heading in ("published", "ours", "difference", "standard errors", ""):
        table.add_column(heading, justify="right")
    for each in found:
        table.add_row(
            each.task,
            each.policy,
            f"{each.published:g}",
            f"{each.ours:.3f} ± {each.error:.3f}",
            f"{each.difference:+.1f} %",
            f"{each.errors:+.1f}",
            "" if abs(each.errors) <= MOST_ERRORS else "differs",
        )
    return table


if __name__ == "__main__":
    with command("agents"):
        main()
