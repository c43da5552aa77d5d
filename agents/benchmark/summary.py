"""One line for each policy of a task, over its training runs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from agents.benchmark.judge import Sampled, is_ratio, over_runs, sampled_interpolation
from agents.benchmark.plan import CORE
from agents.benchmark.results import Result
from grind_env.policies.statistics import Interval

KNOWLEDGE = ("measurements", "state", "future")
"""From least to most, the order of the table."""
HEADINGS = (
    "policy",
    "sees",
    "runs",
    "$/good part",
    "scrap %",
    "E m/min",
    "dresses/part",
    "score (95 %)",
    "interpolation",
    "training s",
)
NONE = "–"


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """One line of a table: means over the runs of a policy."""

    policy: str
    sees: str
    runs: int
    cost: Interval
    """$ per good part."""
    scrap: float
    speed: float
    """E, m/min."""
    dresses: float
    """Executions a part."""
    score: Interval | None
    ratio: Interval | None
    """Cost over that of the best fixed plan."""
    interpolation_score: Interval | None
    """With contexts of the split `interpolation`, as the ratio that follows."""
    interpolation_ratio: Interval | None
    train_seconds: float | None

    def cells(self, ratio: bool) -> tuple[str, ...]:
        """The texts under `HEADINGS`; `ratio` for a task of which the ratio is reported in place of the score."""
        return (
            self.policy,
            self.sees,
            str(self.runs),
            f"{self.cost.value:.3f} ± {self.cost.half_width:.3f}",
            f"{100.0 * self.scrap:.2f}",
            f"{self.speed:.1f}",
            f"{self.dresses:.2f}",
            shown(self.ratio if ratio else self.score, ratio),
            brief(self.interpolation_ratio if ratio else self.interpolation_score, ratio),
            NONE if self.train_seconds is None else f"{self.train_seconds:.0f}",
        )


def shown(interval: Interval | None, ratio: bool) -> str:
    """A score, or a ratio of costs, with its interval."""
    if interval is None or np.isnan(interval.value):
        return NONE
    value, low, high = (f"{each:.{decimals(interval, ratio)}f}" for each in interval)
    return f"{value}{'x' if ratio else ''} ({low} to {high})"


def brief(interval: Interval | None, ratio: bool) -> str:
    """The same with half the length of the interval."""
    if interval is None or np.isnan(interval.value):
        return NONE
    digits = decimals(interval, ratio)
    return f"{interval.value:.{digits}f}{'x' if ratio else ''} ± {interval.half_width:.{digits}f}"


def decimals(interval: Interval, ratio: bool) -> int:
    """Decimals that a score, or a ratio of costs, is printed with."""
    if ratio:
        return 3
    return 1 if abs(interval.value) < 100.05 else 0


def tasks_of(results: Sequence[Result]) -> list[str]:
    """The tasks of results, those of the core set first."""
    found = dict.fromkeys(each.task for each in results)
    return [*(name for name in CORE if name in found), *(name for name in found if name not in CORE)]


def summaries(results: Sequence[Result], task: str) -> list[Summary]:
    """The lines of a task, from those that know least to those that know most, and from poor to good."""
    group = [each for each in results if each.task == task]
    sampled, between = Sampled(group), sampled_interpolation(group)
    costs, scores, ratios = sampled.costs(), sampled.scores(), sampled.ratios()
    lines = []
    for policy in dict.fromkeys(each.policy for each in group):
        runs = sampled.runs(policy)
        of_policy = [sampled.results[i] for i in runs]
        seconds = [each.train_seconds for each in of_policy if each.train_seconds is not None]
        cost = over_runs(costs, runs)
        assert cost is not None
        lines.append(
            Summary(
                policy=policy,
                sees=of_policy[0].sees,
                runs=len(runs),
                cost=cost,
                scrap=float(np.mean([each.scrap for each in of_policy])),
                speed=float(np.mean([each.E_mean for each in of_policy])),
                dresses=float(np.mean([each.dresses_per_part for each in of_policy])),
                score=over_runs(scores, runs),
                ratio=over_runs(ratios, runs),
                interpolation_score=None if between is None else over_runs(between.scores(), between.runs(policy)),
                interpolation_ratio=None if between is None else over_runs(between.ratios(), between.runs(policy)),
                train_seconds=float(np.mean(seconds)) if seconds else None,
            )
        )
    return sorted(lines, key=lambda line: (KNOWLEDGE.index(line.sees), -line.cost.value))


def rich_table(results: Sequence[Result], task: str, title: str) -> Table:
    """The table of a task for a terminal."""
    table = Table(title=title)
    for k, heading in enumerate(HEADINGS):
        table.add_column(heading, justify="left" if k < 2 else "right", no_wrap=True)
    for line in summaries(results, task):
        table.add_row(*line.cells(is_ratio(task)))
    return table
