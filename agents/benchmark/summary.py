"""One line for each policy of a task, over its training runs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from agents.benchmark.judge import Sampled, is_ratio, over_runs, sampled
from agents.benchmark.plan import CORE
from agents.benchmark.results import INTERPOLATION, PLANTS, Result
from grind_env.policies.statistics import Interval

KNOWLEDGE = ("measurements", "state", "future")
"""From least to most, the order of the table."""
HEADINGS = (
    "policy",
    "score (95 %)",
    "over best rule",
    "sees",
    "model",
    "runs",
    "episodes",
    "$/good part",
    "scrap %",
    "dresses/part",
    "on plants, $",
    "scrap there, %",
    "interpolation",
    "blocks",
    "simulated",
    "making, s",
    "decision, ms",
)
ON_SCREEN = 11
"""Columns that a terminal has room for; what a policy was made with is in the files."""
NONE = "–"
MEANS = ("blocks", "making_calls", "decision_calls", "decision_ms", "train_seconds")
"""Columns of results of which a line has the mean."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """One line of a table: means over the runs of a policy; what is not known of it is None."""

    policy: str
    kind: str
    sees: str
    model: str | None
    runs: int
    episodes: int
    cost: Interval
    """$ per good part."""
    scrap: float
    dresses: float
    """Executions a part."""
    score: Interval | None
    ratio: Interval | None
    """Cost over that of the best fixed plan."""
    over: Interval | None
    """Points more than the best rule with the same inputs, paired."""
    interpolation_score: Interval | None
    """With contexts of the split `interpolation`, as the ratio that follows."""
    interpolation_ratio: Interval | None
    plants_cost: Interval | None
    """$ per good part on machines that are held out."""
    plants_scrap: float | None
    blocks: float | None
    making_calls: float | None
    decision_calls: float | None
    decision_ms: float | None
    train_seconds: float | None

    @property
    def making_seconds(self) -> float | None:
        """Of its training; of a rule that of the blocks that it was tuned on, which are little but its decisions."""
        if self.kind == "scripted" and self.blocks is not None and self.decision_ms is not None:
            return 1e-3 * self.blocks * self.decision_ms
        return self.train_seconds

    def cells(self, ratio: bool) -> tuple[str, ...]:
        """The texts under `HEADINGS`; `ratio` for a task of which the ratio is reported in place of the score."""
        return (
            self.policy,
            shown(self.ratio if ratio else self.score, ratio),
            NONE if ratio else brief(self.over, False),
            self.sees,
            self.model or NONE,
            str(self.runs),
            str(self.episodes),
            f"{self.cost.value:.3f} ± {self.cost.half_width:.3f}",
            f"{100.0 * self.scrap:.2f}",
            f"{self.dresses:.2f}",
            NONE if self.plants_cost is None else f"{self.plants_cost.value:.2f} ± {self.plants_cost.half_width:.2f}",
            NONE if self.plants_scrap is None else f"{100.0 * self.plants_scrap:.2f}",
            brief(self.interpolation_ratio if ratio else self.interpolation_score, ratio),
            counted(self.blocks),
            self._simulated(),
            NONE if self.making_seconds is None else f"{self.making_seconds:.0f}",
            NONE if self.decision_ms is None else f"{self.decision_ms:.2f}",
        )

    def _simulated(self) -> str:
        """Blocks that it simulates for a decision, and that were simulated to make it."""
        if self.decision_calls is None:
            return NONE
        parts = [f"{self.decision_calls:,.0f} a decision"] if self.decision_calls else []
        parts += [f"{counted(self.making_calls)} in all"] if self.making_calls else []
        return " and ".join(parts) or "0"


def counted(number: float | None) -> str:
    """A number of blocks."""
    if number is None:
        return NONE
    return f"{number / 1e6:.2f} M" if number >= 5e3 else f"{number:.0f}"


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


def best(sampled: Sampled, kind: str, sees: str) -> str | None:
    """The policy of a kind with such inputs that scores best; None if there is none, or no score."""
    scores = sampled.scores()
    if scores is None:
        return None
    names = dict.fromkeys(each.policy for each in sampled.results if (each.kind, each.sees) == (kind, sees))
    return max(names, key=lambda name: float(scores[0][sampled.runs(name)].mean()), default=None)


def summaries(results: Sequence[Result], task: str) -> list[Summary]:
    """The lines of a task, from those that know least to those that know most, and from poor to good."""
    group = [each for each in results if each.task == task]
    every, between, plants = Sampled(group), sampled(group, INTERPOLATION), sampled(group, PLANTS)
    costs, scores, ratios = every.costs(), every.scores(), every.ratios()
    rules = {sees: best(every, "scripted", sees) for sees in KNOWLEDGE}
    lines = []
    for policy in dict.fromkeys(each.policy for each in group):
        runs = every.runs(policy)
        of_policy = [every.results[i] for i in runs]
        first = of_policy[0]
        cost, rule = over_runs(costs, runs), rules[first.sees]
        assert cost is not None
        lines.append(
            Summary(
                policy=policy,
                kind=first.kind,
                sees=first.sees,
                model=first.model,
                runs=len(runs),
                episodes=int(every.lengths[runs].min()),
                cost=cost,
                scrap=float(np.mean([each.scrap for each in of_policy])),
                dresses=float(np.mean([each.dresses_per_part for each in of_policy])),
                score=over_runs(scores, runs),
                ratio=over_runs(ratios, runs),
                over=None if rule in (None, policy) else every.gain(policy, str(rule)),
                interpolation_score=None if between is None else over_runs(between.scores(), between.runs(policy)),
                interpolation_ratio=None if between is None else over_runs(between.ratios(), between.runs(policy)),
                plants_cost=None if plants is None else over_runs(plants.costs(), plants.runs(policy)),
                plants_scrap=mean_of(of_policy, "plants_scrap"),
                **{name: mean_of(of_policy, name) for name in MEANS},
            )
        )
    return sorted(lines, key=lambda line: (KNOWLEDGE.index(line.sees), -line.cost.value))


def mean_of(results: Sequence[Result], name: str) -> float | None:
    """Mean of a column over runs of which it is known."""
    values = [value for each in results if (value := getattr(each, name)) is not None]
    return float(np.mean(values)) if values else None


def rich_table(results: Sequence[Result], task: str, title: str) -> Table:
    """The table of a task for a terminal."""
    table = Table(title=title)
    for k, heading in enumerate(HEADINGS[:ON_SCREEN]):
        table.add_column(heading, justify="right" if k else "left", no_wrap=True)
    for line in summaries(results, task):
        table.add_row(*line.cells(is_ratio(task))[:ON_SCREEN])
    return table
