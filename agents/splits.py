"""Policies on contexts that the task does not draw, beside those that it does."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from glob import escape
from pathlib import Path
from typing import NamedTuple

from rich.console import Console

from agents.cells import RESULTS, RUNS, kept_evaluation
from agents.pool import find_all
from agents.provenance import provenance
from agents.reference.table import best_plan
from agents.tables import check_tables, csv_of
from grind_env.envs.splits import EVERY
from grind_env.errors import GrindError
from grind_env.pages.markdown import table
from grind_env.policies.evaluation import Evaluation, episode_seeds
from grind_env.policies.naming import named_policy
from grind_env.policies.problem import Problem
from grind_env.policies.registry import FIXED_PLANS, REFERENCE, policy_names
from grind_env.policies.tuned import write_whole

SHOWN = (EVERY, "interpolation", "extrapolation")
MEASURED = ("empirical_rule", "look_ahead", "belief_planner", "shipped", "robust")
WHO = (*MEASURED, "mpc")
CSV, PAGE, TITLE = "splits.csv", "splits.md", "# Contexts that were held out, and some beyond the task"
COLUMNS = ("task", "split", "who", "score", "score_low", "score_high", "cost", "cost_low", "cost_high", "scrap")
BEGINS = {CSV: ",".join(COLUMNS), PAGE: TITLE}


class Cell(NamedTuple):
    """A policy on the contexts of a split."""

    problem: Problem
    split: str
    who: str

    def __str__(self) -> str:
        return f"{self.problem.name}, {self.split}: {self.who}"

    @property
    def files(self) -> tuple[str, ...]:
        """Pattern of what is kept of it."""
        return (f"{escape(self.problem.name)}/cells/**/*.npz",)

    @property
    def trains(self) -> bool:
        """No agent is trained."""
        return False


class Request(NamedTuple):
    """How cells are worked on."""

    episodes: int
    """Evaluation episodes."""
    runs: Path
    """Folder of what is kept."""

    @property
    def size(self) -> int:
        """Of the bar of a cell."""
        return self.episodes


class Line(NamedTuple):
    """What a policy comes to in a split of a task, each number with the ends of its 95 % over episodes."""

    task: str
    split: str
    who: str
    score: tuple[float, float, float]
    """0 is the fixed plan that is best on all contexts, 100 hindsight."""
    cost: tuple[float, float, float]
    """$ per good part."""
    scrap: float
    """Share of the parts."""


def work(cell: Cell, request: Request, tell: Callable[[int], object]) -> Evaluation:
    """The evaluation of a cell, kept by its policy and code."""
    policy = named_policy(cell.who, cell.problem.simulation())
    seeds = episode_seeds("evaluation", request.episodes)
    return kept_evaluation(policy, cell.problem, seeds, request.runs, split=cell.split, advance=tell)


def run_splits(
    problems: Sequence[Problem],
    episodes: int,
    *,
    jobs: int,
    console: Console,
    runs: Path = RUNS,
    results: Path = RESULTS,
) -> list[Line]:
    """Run every policy on every split, and write the table.

    Args:
        problems: environments whose steps are blocks.
        episodes: evaluation episodes.
        jobs: processes.
        console: shows how far it is.
        runs: folder of what is kept.
        results: folder of the table.

    Raises:
        FileError: another table has the name of one that is to be written.
        GrindError: a cell failed.
    """
    results.mkdir(parents=True, exist_ok=True)
    check_tables(results, "splits", BEGINS)
    cells = [
        Cell(problem, split, who)
        for problem in problems
        for who in (*plans_of(problem), *judged(problem), REFERENCE)
        for split in SHOWN
    ]
    found = dict(zip(cells, find_all(cells, Request(episodes, runs), jobs, console, work), strict=True))
    lines = [line for problem in problems for line in lines_of(problem, found)]
    made_with = provenance(episode_seeds("evaluation", episodes))
    rows = [
        (each.task, each.split, each.who, *each.score, *each.cost, each.scrap, *made_with.values()) for each in lines
    ]
    for name, content in ((CSV, csv_of([*COLUMNS, *made_with], rows)), (PAGE, page(lines, episodes))):
        write_whole(results / name, content)
    return lines


def plans_of(problem: Problem) -> list[str]:
    """Names of the fixed plans of a task."""
    return [name for name in policy_names(problem.simulation()) if name in FIXED_PLANS]


def judged(problem: Problem) -> list[str]:
    """Those of `WHO` that there are for a task: agents come with some, and rules have to be tuned."""
    found = []
    for who in WHO:
        with suppress(GrindError):
            named_policy(who, problem.simulation())
            found.append(who)
    return found


def lines_of(problem: Problem, found: Mapping[Cell, Evaluation]) -> list[Line]:
    """What every policy comes to in the splits of a task."""
    by_split = {
        split: {cell.who: run for cell, run in found.items() if (cell.problem, cell.split) == (problem, split)}
        for split in SHOWN
    }
    plan = best_plan(by_split[EVERY])
    lines = []
    for split, runs in by_split.items():
        for who in (plan, *(who for who in WHO if who in runs), REFERENCE):
            score, cost = runs[who].score(runs[plan], runs[REFERENCE]), runs[who].cost_per_good_part
            ends = (score.value, score.low, score.high), (cost.value, cost.low, cost.high)
            lines.append(Line(problem.name, split, who, *ends, runs[who].scrap))
    return lines


def page(lines: Sequence[Line], episodes: int) -> str:
    """The tables, Markdown."""
    scores, costs = [], []
    for task, split in dict.fromkeys((each.task, each.split) for each in lines):
        of = {each.who: each for each in lines if (each.task, each.split) == (task, split)}
        plan = next(iter(of))
        scores.append((task, split, *(_score(of.get(who)) for who in WHO)))
        costs.append((task, split, plan, *(_cost(of.get(who)) for who in (plan, *WHO, REFERENCE))))
    return (
        f"{TITLE}\n\n`python -m agents splits`: {episodes} evaluation episodes, the same seeds in every split. `all` is"
        " what a task draws, and what rules are tuned on; `interpolation` are contexts that no agent was trained on;"
        " `extrapolation` has wear and pressure beyond all that a task draws, another wheel and another material, half"
        " as much stock again and readings that are three times as noisy. Score (95 % over episodes): 0 is the fixed"
        " plan that is best on all contexts, 100 is hindsight; `mpc` knows the state.\n\n"
        + "".join(f"In `{split}`, of those that see measurements, {leading(lines, split)}. " for split in SHOWN).strip()
        + "\n\n"
        + table(("task", "split", *WHO), scores)
        + "\n\n$ per good part, and scrap:\n\n"
        + table(("task", "split", "fixed plan", "of it", *WHO, REFERENCE), costs)
        + "\n"
    )


def leading(lines: Sequence[Line], split: str) -> str:
    """Who scores best on measurements in how many tasks, and in how many of these clear of the intervals of others."""
    first, clear = Counter[str](), Counter[str]()
    for task in dict.fromkeys(each.task for each in lines):
        of = [each for each in lines if (each.task, each.split) == (task, split) and each.who in MEASURED]
        if not of:
            continue
        best = max(of, key=lambda each: each.score[0])
        first[best.who] += 1
        clear[best.who] += all(best.score[1] > each.score[2] for each in of if each is not best)
    said = [
        f"`{who}` leads in {count} of {first.total()} tasks"
        + (f" ({clear[who]} clear of all others)" if clear[who] else "")
        for who, count in first.most_common()
    ]
    return ", ".join(said) or "nobody was run"


def _score(line: Line | None) -> str:
    return "–" if line is None else "{:.1f} ({:.1f} to {:.1f})".format(*line.score)


def _cost(line: Line | None) -> str:
    return "–" if line is None else f"{line.cost[0]:.2f}, {100.0 * line.scrap:.1f} %"
