"""Full grid of the benchmark: the cells of all results, and estimates of their CPU time."""

from collections.abc import Sequence
from pathlib import Path

from agents.benchmark.plan import AT, KINDS, LIMIT, PLAIN, BenchmarkCell, Request, planned
from agents.benchmark.policy_effort import EXACT
from agents.evaluation_cache import CHUNK
from grind_env.envs.task_names import CORE
from grind_env.policies.planners import hindsight
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.registry import REFERENCE

EPISODES, INTERPOLATION_EPISODES, PLANTS_EPISODES = 512, 256, 256
SEEDS, LONGER_SEEDS = 5, 3
"""Number of trainings of every kind in a task, and of every kind with more than a million steps."""
LONGER = {"plain_gru@3M": CORE, "plain_gru@10M": ("power_limited", "wide_plates", "blades")}
"""Longer trainings, and their tasks."""
MORE_SEARCH = f"{REFERENCE}{AT}12"
"""Hindsight with four times the search: shows whether 100 is near the optimum."""
TRAINING = {"gru": 80.0, "belief": 55.0}
RECIPE_TRAINING = 100.0
"""Measured CPU time of a million training steps, s, of plain agents by memory, and of the recipe."""
DECISION = {"hindsight": 6e-3, "belief_planner": 2.6e-3, "mpc": 1.1e-3, "look_ahead": 6e-4}
USUAL_DECISION = 6e-5
"""Measured CPU time of a decision, s, of slow policies and of all others."""


def grid(
    problems: Sequence[Problem], policies: Sequence[str] | None, kinds: Sequence[str] | None, seeds: int | None
) -> list[BenchmarkCell]:
    """Return the cells of the grid, the slowest first; by default of all policies, variants and kinds."""
    cells = dict.fromkeys(planned(problems, policies, [], 0))
    for problem in problems:
        usual = [*KINDS, *(kind for kind, tasks in LONGER.items() if problem.name in tasks)]
        for kind in usual if kinds is None else kinds:
            count = (LONGER_SEEDS if AT in kind else SEEDS) if seeds is None else seeds
            cells |= dict.fromkeys(planned([problem], [], [kind], count))
        if policies is None:
            cells[BenchmarkCell(problem, MORE_SEARCH)] = None
    return sorted(cells, key=lambda cell: (-(cell.steps or 0), -DECISION.get(cell.base, 0.0) - cell.trains))


def has_agent(cell: BenchmarkCell, runs: Path) -> bool:
    """Return whether the cache has an agent of a cell."""
    return cell.trains and any((runs / cell.task).glob(f"{cell.name}-*"))


def making(cell: BenchmarkCell, request: Request) -> float:
    """Return the estimated CPU time of the training of a cell, s; 0 if there is an agent."""
    if not cell.trains or has_agent(cell, request.runs):
        return 0.0
    million = TRAINING[PLAIN[cell.base]] if cell.base in PLAIN else RECIPE_TRAINING
    return million * (cell.steps or request.steps or LIMIT) / 1_000_000


def running(cell: BenchmarkCell, request: Request) -> float:
    """Return the estimated CPU time of the evaluation of a cell, s."""
    steps = cell.problem.simulation().task.blocks
    if cell.base == REFERENCE and cell.variant:
        # the plan before the first sweep takes about as long as a sweep
        return CHUNK * steps * DECISION[REFERENCE] * (int(cell.variant) + 1) / (hindsight.SWEEPS + 1)
    # policies that know the machine are not judged on out-of-model machines
    episodes = request.episodes + request.interpolation_episodes + request.plants_episodes * (cell.base not in EXACT)
    return episodes * steps * DECISION.get(cell.policy, USUAL_DECISION)
