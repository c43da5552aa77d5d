"""Estimated CPU time of the training and of the evaluation of a benchmark cell."""

from agents.benchmark.plan import LIMIT, PLAIN, BenchmarkCell, Request
from agents.benchmark.policy_effort import EXACT
from agents.evaluation_cache import CHUNK
from grind_env.policies.planners import hindsight
from grind_env.policies.registry import REFERENCE

TRAINING = {"gru": 80.0, "belief": 55.0}
#: measured CPU time of a million training steps, s, of plain agents by memory, and of the recipe
RECIPE_TRAINING = 100.0
DECISION = {"hindsight": 6e-3, "belief_planner": 2.6e-3, "mpc": 1.1e-3, "look_ahead": 6e-4}
USUAL_DECISION = 6e-5  #: measured CPU time of a decision, s, of slow policies and of all others


def training_seconds(cell: BenchmarkCell, request: Request) -> float:
    """Return the estimated CPU time of the training of a cell, s; 0 if there is an agent."""
    if not cell.trains or cell.has_agent(request.runs):
        return 0.0
    million = TRAINING[PLAIN[cell.base]] if cell.base in PLAIN else RECIPE_TRAINING
    return million * (cell.steps or request.steps or LIMIT) / 1_000_000


def evaluation_seconds(cell: BenchmarkCell, request: Request) -> float:
    """Return the estimated CPU time of the evaluation of a cell, s."""
    steps = cell.problem.simulation().task.blocks
    if cell.base == REFERENCE and cell.variant:
        # the plan before the first sweep takes about as long as a sweep
        return CHUNK * steps * DECISION[REFERENCE] * (int(cell.variant) + 1) / (hindsight.SWEEPS + 1)
    # policies that know the machine are not judged on out-of-model machines
    episodes = request.episodes + request.interpolation_episodes + request.plants_episodes * (cell.base not in EXACT)
    return episodes * steps * DECISION.get(cell.policy, USUAL_DECISION)
