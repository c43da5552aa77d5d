"""The full grid: the cells that remake all results, and their durations."""

from collections.abc import Sequence

from agents.benchmark.plan import (
    AT,
    FLAGSHIP,
    KINDS,
    LIMIT,
    LIMITED,
    LONG,
    PLAIN,
    SWEEPS,
    BenchmarkCell,
    Request,
    named,
    planned,
)
from agents.benchmark.price import EXACT, tuned_on
from agents.cells import CHUNK
from grind_env.policies.planners import hindsight
from grind_env.policies.problem import Problem
from grind_env.policies.registry import FIXED_PLANS, REFERENCE

EPISODES, INTERPOLATION_EPISODES, PLANTS_EPISODES = 512, 256, 256
SEEDS, FLAGSHIP_SEEDS = 5, 10
"""Trainings of every kind, and of every plain one on the flagship task."""
TRAINING = {"none": 28.0, "stack": 33.0, "gru": 80.0, "belief": 55.0, "state": 28.0}
RECIPE_TRAINING = 100.0
"""CPU-seconds of a plain training of a million steps, and of one by the recipe, by measurement, as what follows."""
DECISION = {"hindsight": 6e-3, "belief_planner": 2.6e-3, "mpc": 1.1e-3, "look_ahead": 6e-4}
USUAL_DECISION, TUNING_BLOCK = 6e-5, 2e-5
"""Seconds of a decision, and of a block on which a rule is tuned."""


def grid(
    problems: Sequence[Problem], policies: Sequence[str] | None, kinds: Sequence[str] | None, seeds: int | None
) -> list[BenchmarkCell]:
    """Return the cells of the grid, those that take long first; by default of all policies, variants and kinds."""
    chosen = KINDS if kinds is None else kinds
    cells = dict.fromkeys(planned(problems, policies, [], 0))
    for problem in problems:
        for kind in chosen:
            usual = FLAGSHIP_SEEDS if problem.name == FLAGSHIP and kind in PLAIN else SEEDS
            cells |= dict.fromkeys(planned([problem], [], [kind], usual if seeds is None else seeds))
        if policies is None:
            simulation = problem.simulation()
            rules = [name for name in named(problem) if name not in (*FIXED_PLANS, *LONG)]
            variants = [f"{name}{AT}{LIMITED}" for name in rules if tuned_on(name, simulation) > LIMIT]
            variants += [f"{REFERENCE}{AT}{sweeps}" for sweeps in SWEEPS]
            cells |= dict.fromkeys(BenchmarkCell(problem, name) for name in variants)
    return sorted(cells, key=lambda cell: -DECISION.get(cell.base, 0.0) - cell.trains)


def making(cell: BenchmarkCell, request: Request) -> float:
    """CPU-seconds in which the policy of a cell is tuned or trained."""
    if cell.variant == LIMITED:
        return LIMIT * TUNING_BLOCK
    if not cell.trains:
        return 0.0
    million = TRAINING[PLAIN[cell.policy]] if cell.policy in PLAIN else RECIPE_TRAINING
    return million * (request.steps or 1_000_000) / 1_000_000


def running(cell: BenchmarkCell, request: Request) -> float:
    """CPU-seconds in which the policy of a cell is judged."""
    steps = cell.problem.simulation().task.blocks
    if cell.base == REFERENCE and cell.variant:
        # the plan that sweeps begin with takes about as long as one
        return CHUNK * steps * DECISION[REFERENCE] * (int(cell.variant) + 1) / (hindsight.SWEEPS + 1)
    # what knows the machine is not judged on others
    episodes = request.size - request.plants_episodes * (cell.base in EXACT)
    return episodes * steps * DECISION.get(cell.policy, USUAL_DECISION)
