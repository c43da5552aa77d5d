"""Hindsight, the measure of all scores: what it scores over how long it searches."""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from glob import escape
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console

from agents.cells import RUNS, Advance, kept_evaluation
from agents.pool import work_on_all
from agents.provenance import provenance
from grind_env.arrays import Array
from grind_env.errors import GrindError
from grind_env.files import read_text
from grind_env.policies.evaluation import Evaluation, episode_seeds, run_seeds
from grind_env.policies.planners.hindsight import SWEEPS, Hindsight
from grind_env.policies.problem import Problem
from grind_env.policies.registry import FIXED_PLANS, make_policy, policy_names
from grind_env.policies.statistics import Interval, bootstrap
from grind_env.policies.tuned import write_whole
from grind_env.targets import Own

EFFORTS = ((0, 1), (1, 1), (SWEEPS, 1), (2 * SWEEPS, 1), (4 * SWEEPS, 1), (2 * SWEEPS, 4))
"""Sweeps over an episode, and searches with other random moves, of which the cheapest plan of each episode counts."""
TODAY = (SWEEPS, 1)
EPISODES = 32
CSV = "hindsight.csv"
COLUMNS = ("task", "sweeps", "searches", "episodes", "score", "low", "high")
OWNED = Own("table of `python -m agents hindsight`", re.compile(",".join(COLUMNS).encode()).match)


class Cell(NamedTuple):
    """One search of a problem."""

    problem: Problem
    sweeps: int
    seed: int

    def __str__(self) -> str:
        return f"{self.problem.name}, {self.sweeps} sweeps, search {self.seed}"

    @property
    def files(self) -> tuple[str, ...]:
        """Pattern of what is kept of it."""
        return (f"{self.place}/{escape(self.problem.name)}/**/*",)

    @property
    def place(self) -> str:
        """Where it is kept, apart from the hindsight of the scores."""
        return f"hindsight/{self.sweeps}-{self.seed}"


@dataclass(frozen=True, slots=True)
class Request:
    """How many evaluation episodes, and where it is kept."""

    episodes: int = EPISODES
    runs: Path = RUNS

    @property
    def size(self) -> int:
        """Episodes of a cell."""
        return self.episodes


class Point(NamedTuple):
    """A point of the curve: the score by the best fixed plan and the hindsight of today, which scores 100."""

    task: str
    sweeps: int
    searches: int
    episodes: int
    score: Interval


def searches(problems: Sequence[Problem]) -> list[Cell]:
    """All searches of the curves, those that take long first."""
    each = {(sweeps, seed) for sweeps, count in EFFORTS for seed in range(count)}
    return [Cell(problem, *one) for one in sorted(each, reverse=True) for problem in problems]


def search(cell: Cell, request: Request, advance: Advance) -> Evaluation:
    """The episodes under the plans of a search."""
    seeds, place = episode_seeds("evaluation", request.episodes), request.runs / cell.place
    return kept_evaluation(Hindsight(cell.sweeps, cell.seed), cell.problem, seeds, place, advance=advance)


def curves(problems: Sequence[Problem], request: Request, jobs: int, console: Console) -> list[Point]:
    """Search with every effort; what the same code has found before is taken up again.

    Raises:
        GrindError: a search failed.
    """
    cells = searches(problems)
    found, failed = work_on_all(cells, request, jobs, console, search)
    if failed:
        raise GrindError(f"{len(failed)} of {len(cells)} searches failed: {next(iter(failed.values()))}")
    costs = {cell: run.cost for cell, run in zip(cells, found, strict=True)}
    return [point for problem in problems for point in curve(problem, costs, request.episodes)]


def curve(problem: Problem, costs: Mapping[Cell, Array], episodes: int) -> list[Point]:
    """The curve of a problem, from the costs of all searches, each shape (episodes,)."""
    simulation, seeds = problem.simulation(), episode_seeds("evaluation", episodes)
    plans = [make_policy(name, simulation) for name in policy_names(simulation) if name in FIXED_PLANS]
    fixed = min((run_seeds(plan, simulation, seeds).cost for plan in plans), key=lambda cost: float(cost.mean()))
    cheapest = {
        effort: np.min([costs[Cell(problem, effort[0], seed)] for seed in range(effort[1])], axis=0)
        for effort in EFFORTS
    }
    today = cheapest[TODAY]
    return [Point(problem.name, *effort, episodes, paired(cost, fixed, today)) for effort, cost in cheapest.items()]


def paired(cost: Array, fixed: Array, today: Array) -> Interval:
    """Score with an interval of the saving over the search of today, the scale taken for known."""
    scale = 100.0 / (fixed - today).mean()
    return bootstrap(lambda saved: 100.0 + scale * saved.mean(axis=-1), today - cost)


def write_curves(points: Sequence[Point], folder: Path) -> None:
    """Write hindsight.csv, whole or not at all."""
    text, facts = io.StringIO(newline=""), provenance(episode_seeds("evaluation", points[0].episodes))
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*COLUMNS, *facts])
    writer.writerows([*point[:-1], *point.score, *facts.values()] for point in points)
    write_whole(folder / CSV, text.getvalue())


def read_curves(folder: Path) -> list[Point]:
    """The points of a folder; none if it holds no table."""
    if not (folder / CSV).exists():
        return []
    rows = csv.DictReader(io.StringIO(read_text(folder / CSV)))
    return [
        Point(
            row["task"],
            int(row["sweeps"]),
            int(row["searches"]),
            int(row["episodes"]),
            Interval(*(float(row[name]) for name in ("score", "low", "high"))),
        )
        for row in rows
    ]
