"""The safe track: what agents and rules earn, and what they violate, beside a budget of scrap."""

import hashlib
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from itertools import groupby
from pathlib import Path
from statistics import mean
from typing import NamedTuple

import numpy as np
from rich.console import Console

from agents.cells import RESULTS, RUNS, behaviour, sources
from agents.pool import find_all
from agents.provenance import installed, provenance
from agents.tables import check_tables, csv_of
from grind_env.arrays import Table
from grind_env.envs.simulation import Simulation, advance
from grind_env.envs.tables import KindRow, Outcome
from grind_env.files import read_text
from grind_env.pages.markdown import table
from grind_env.policies.evaluation import episode_seeds, run_seeds, start_episodes
from grind_env.policies.naming import named_policy
from grind_env.policies.policy import Policy, reveal
from grind_env.policies.problem import Problem
from grind_env.policies.registry import FIXED_PLANS, make_policy, policy_names
from grind_env.policies.statistics import Interval, bootstrap
from grind_env.policies.tuned import write_whole
from grind_env.process.cost import NO_LIMIT, STALL
from grind_env.training import gru_ppo
from grind_env.training.gru_ppo import Settings, policy_of

SHARE, DIGITS = 0.5, 4
"""Of the scrap of the best fixed plan, the budget of a task: who decides block by block is to spoil fewer parts than a
program without sensors, by enough to be told apart in some hundred episodes. It is measured, and so fits any task."""
VALIDATED = 128
"""Validation episodes on which the fixed plan is run."""
STEP, EPISODE = 8e-5, 0.1
"""CPU-seconds, by measurement: of a step of a training, and of an episode of a rule, which looks ahead."""
UNCONSTRAINED, LAGRANGIAN, RULES = "ppo_gru", "ppo_gru, Lagrangian", ("look_ahead", "guarded:look_ahead")
LIMITS = ("power", "stall", "size", "Ra", "burn")
"""What a block can violate: the load is over the power limit, which costs time; and what condemns a part, as
`process.cost.passed_limits` has it: the spindle stalls, or size, Ra or temperature rise are beyond their limits."""
CSV, PAGE, TITLE = "safety.csv", "safety.md", "# The safe track"

COST, FINISHED, GOOD = (Outcome._fields.index(name) for name in ("cost", "finished", "good"))
POWER, TORQUE, SIZE, ROUGHNESS, RISE = (
    Outcome._fields.index(name) for name in ("power_ratio", "peak_torque", "size_error", "roughness_ratio", "rise")
)
SIZE_LIMIT, RISE_LIMIT = KindRow._fields.index("size"), KindRow._fields.index("rise")


class Cell(NamedTuple):
    """Who decides in a problem, and the seed of the training."""

    problem: Problem
    who: str
    seed: int

    def __str__(self) -> str:
        return f"{self.problem.name}, {self.who}, seed {self.seed}"


@dataclass(frozen=True, slots=True)
class Request:
    """How cells are worked on: steps of a training, evaluation episodes, and the folder of what is kept."""

    steps: int
    episodes: int
    folder: Path

    @property
    def size(self) -> int:
        """A cell tells nothing on the way."""
        return 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """What came of a cell on evaluation episodes; intervals are 95 %, over these."""

    task: str
    who: str
    seed: int
    steps: int
    episodes: int
    budget: float
    """Share of the parts."""
    episode_return: float
    return_low: float
    return_high: float
    scrap: float
    """Share of the parts."""
    scrap_low: float
    scrap_high: float
    power: float
    """Share of the blocks, like those that follow."""
    stall: float
    size: float
    Ra: float
    burn: float


BEGINS = {CSV: ",".join(each.name for each in fields(Judged)), PAGE: TITLE}


def budget_of(problem: Problem) -> float:
    """Share of the parts that may be scrap.

    Raises:
        GrindError: no fixed plan is tuned for the problem.
    """
    simulation, seeds = problem.simulation(), episode_seeds("validation", VALIDATED)
    plans = [make_policy(name, simulation) for name in policy_names(simulation) if name in FIXED_PLANS]
    best = min((run_seeds(plan, simulation, seeds) for plan in plans), key=lambda run: float(run.cost.mean()))
    return round(SHARE * best.scrap, DIGITS)


def violations(policy: Policy, simulation: Simulation, seeds: Sequence[int]) -> tuple[Table, Table]:
    """Run a policy.

    Returns:
        Cost in $, finished parts and good ones of every episode, shape (N, 3), and how many of its blocks violate each
        of `LIMITS`, shape (N, limits).
    """
    state, n = start_episodes(simulation, seeds), len(seeds)
    totals, found = np.zeros((n, 3)), np.zeros((n, len(LIMITS)))
    policy.begin(simulation, n)
    while not simulation.over(state).all():
        kind = simulation.kinds[simulation.branches.rows_of(state.coming())]
        outcomes, _ = advance(
            simulation, state, *policy.act(simulation.observe(state), reveal(policy.sees, simulation, state))
        )
        totals += outcomes[:, [COST, FINISHED, GOOD]]
        limited = kind[:, SIZE_LIMIT] > NO_LIMIT
        over = (
            outcomes[:, POWER] > 1.0,
            outcomes[:, TORQUE] >= STALL,
            limited & (np.abs(outcomes[:, SIZE]) > kind[:, SIZE_LIMIT]),
            outcomes[:, ROUGHNESS] > 1.0,
            outcomes[:, RISE] > kind[:, RISE_LIMIT],
        )
        found += np.stack(over, axis=1)
    return totals, found


def work(cell: Cell, request: Request, tell: Callable[[int], object]) -> Judged:
    """Train, if it is an agent, and judge; what was found by the same code is taken up again."""
    problem, simulation = cell.problem, cell.problem.simulation()
    budget = budget_of(problem)
    settings = Settings(steps=request.steps, budget=budget if cell.who == LAGRANGIAN else None)
    rule = named_policy(cell.who, simulation) if cell.who in RULES else None
    decides = [
        sources(__name__),
        sources(gru_ppo.__name__ if rule is None else type(rule).__module__),
        repr(settings if rule is None else rule),
        behaviour(simulation),
        *map(installed, ("numpy", "torch")),
        *(cell.who, cell.seed, request.episodes, budget),
    ]
    digest = hashlib.sha256("\0".join(map(str, decides)).encode()).hexdigest()[:12]
    path = request.folder / f"{problem.name}-{re.sub(r'[^a-z_]+', '-', cell.who.lower())}-{cell.seed}-{digest}.json"
    if path.exists():
        return Judged(**json.loads(read_text(path)))
    policy = policy_of(*gru_ppo.train(problem, settings, cell.seed), problem, "gru") if rule is None else rule
    totals, found = violations(policy, simulation, episode_seeds("evaluation", request.episodes))
    cost, finished, good = totals.T
    earned = bootstrap(lambda spent: -spent.mean(axis=-1) / simulation.task.reference_cost, cost)
    scrap = bootstrap(lambda parts, kept: 1.0 - kept.sum(axis=-1) / parts.sum(axis=-1), finished, good)
    shares = found.sum(axis=0) / (request.episodes * simulation.task.blocks)
    done = Judged(
        task=problem.name,
        who=cell.who,
        seed=cell.seed,
        steps=request.steps if rule is None else 0,
        episodes=request.episodes,
        budget=budget,
        **_interval("episode_return", "return", earned),
        **_interval("scrap", "scrap", scrap),
        **dict(zip(LIMITS, map(float, shares), strict=True)),
    )
    write_whole(path, json.dumps(asdict(done)))
    tell(1)
    return done


def _interval(name: str, ends: str, found: Interval) -> dict[str, float]:
    return {name: found.value, f"{ends}_low": found.low, f"{ends}_high": found.high}


def run_safety(
    problems: Sequence[Problem],
    seeds: int,
    steps: int,
    episodes: int,
    *,
    jobs: int,
    console: Console,
    runs: Path = RUNS,
    results: Path = RESULTS,
) -> list[Judged]:
    """Train and judge all cells, and write the table.

    Args:
        problems: environments whose steps are blocks.
        seeds: of each training, from 0.
        steps: of a training.
        episodes: evaluation episodes.
        jobs: processes.
        console: shows how far it is.
        runs: folder of what is kept, in its sub-folder `safety`.
        results: folder of the table.

    Raises:
        FileError: another table has the name of one that is to be written.
        GrindError: a cell failed.
    """
    results.mkdir(parents=True, exist_ok=True)
    check_tables(results, "safety", BEGINS)
    cells = [
        Cell(problem, who, seed)
        for problem in problems
        for who in (UNCONSTRAINED, LAGRANGIAN, *RULES)
        for seed in range(1 if who in RULES else seeds)
    ]
    request = Request(steps, episodes, runs.absolute() / "safety")
    hours = sum(EPISODE * episodes if cell.who in RULES else STEP * steps for cell in cells) / 3600.0
    console.print(f"{len(cells)} cells: about {hours:.1f} core-hours where none is kept")
    found = find_all(cells, request, jobs, console, work)
    rows = [asdict(each) | provenance(episode_seeds("evaluation", episodes)) for each in found]
    text = csv_of(list(rows[0]), [list(row.values()) for row in rows])
    for name, content in ((CSV, text), (PAGE, page(found))):
        write_whole(results / name, content)
    return found


HEADINGS = ("task", "who", "seeds", "return", "scrap %", "within budget", *(f"{name} %" for name in LIMITS))


def page(found: Sequence[Judged]) -> str:
    """The table, Markdown; means over seeds, and behind them what the seeds gave."""
    rows, of = [], {key: list(group) for key, group in groupby(found, lambda each: (each.task, each.who))}
    for (task, who), runs in of.items():
        scraps = ", ".join(f"{100.0 * each.scrap:.2f}" for each in runs)
        ends = min(each.return_low for each in runs), max(each.return_high for each in runs)
        rows.append(
            (
                f"{task}, budget {100.0 * runs[0].budget:.2f} %",
                who,
                str(len(runs)),
                f"{_mean(runs, 'episode_return'):.1f} ({ends[0]:.1f} to {ends[1]:.1f})",
                f"{100.0 * _mean(runs, 'scrap'):.2f} ({scraps})",
                f"{_kept(runs)} of {len(runs)}",
                *(f"{100.0 * _mean(runs, name):.2f}" for name in LIMITS),
            )
        )
    return (
        f"{TITLE}\n\n`python -m agents safety`: return of an episode (minus its cost over the reference cost of a"
        f" block; from the lowest to the highest end of the 95 % intervals of the seeds) against scrap, of the parts,"
        f" and violations, of the blocks; {found[0].episodes} evaluation episodes. The budget of scrap is {SHARE:g} of"
        f" what the best fixed plan scraps on {VALIDATED} validation episodes.\n\n"
        f"{verdict(of)}{table(HEADINGS, rows)}\n"
    )


def verdict(of: Mapping[tuple[str, str], Sequence[Judged]]) -> str:
    """Who keeps the budget, and what the multiplier costs; nothing where there is one task."""
    tasks = list(dict.fromkeys(task for task, _ in of))
    if len(tasks) < 2:
        return ""
    told = []
    for who in dict.fromkeys(who for _, who in of):
        runs = [each for task in tasks for each in of[task, who]]
        told.append(f"`{who}` {_kept(runs)} of {len(runs)}")
    more = [
        100.0 * (_mean(of[task, LAGRANGIAN], "episode_return") / _mean(of[task, UNCONSTRAINED], "episode_return") - 1.0)
        for task in tasks
    ]
    return (
        f"Runs within the budget, of all tasks: {', '.join(told)}. With its multiplier an episode of PPO costs"
        f" {min(more):.1f} to {max(more):.1f} % more than without, by task.\n\n"
    )


def _mean(runs: Sequence[Judged], name: str) -> float:
    return float(mean(getattr(each, name) for each in runs))


def _kept(runs: Sequence[Judged]) -> int:
    return sum(each.scrap <= each.budget for each in runs)
