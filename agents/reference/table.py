"""Table of reference scores of a task, for the terminal and files."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import Any

from grind_env.data_table import Column
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.registry import FIXED_PLANS, REFERENCE
from grind_env.policies.score_statistics import Interval

COLUMNS = (
    Column("policy", "policy"),
    Column("sees", "sees"),
    Column("$/good part", "cost", "±.3f"),
    Column("scrap %", "scrap", ".2f", factor=100.0),
    Column("E mm/min", "speed", ".0f"),
    Column("D", "executions", ".2f"),
    Column("score (95 % interval)", "score", ".1f"),
)


@dataclass(frozen=True, slots=True)
class ScoreRow:
    """One line of the table."""

    policy: str
    sees: Sees
    cost: Interval  #: cost per good part, $
    scrap: float  #: share of the parts that are scrap
    speed: float  #: mean E, mm/min
    executions: float  #: mean D, dress executions per step
    score: Interval  #: score: 0 is the best fixed plan, 100 the hindsight planner


def table_rows(policies: Sequence[Policy], results: Mapping[str, Evaluation]) -> list[ScoreRow]:
    """Return the rows of the table; the fixed plan of least mean cost on these episodes scores 0, the planner 100."""
    fixed, planner = results[best_plan(results)], results[REFERENCE]
    rows = []
    for policy in policies:
        run = results[policy.name]
        score = run.score(fixed, planner)
        speed, executions = run.speed, run.dresses
        rows.append(ScoreRow(policy.name, policy.sees, run.cost_per_good_part, run.scrap, speed, executions, score))
    return rows


def best_plan(results: Mapping[str, Evaluation]) -> str:
    """Return the name of the fixed plan of least mean cost."""
    return min((name for name in FIXED_PLANS if name in results), key=lambda name: float(results[name].cost.mean()))


def spread_names(name: str) -> list[str]:
    """Return the names of the columns of an interval."""
    return [name, f"{name}_low", f"{name}_high"]


def flat(row: Any) -> Iterator[object]:
    """Return the values of a row, a dataclass, with intervals spread out."""
    for value in astuple(row):
        yield from value if isinstance(value, tuple) else (value,)
