"""Measurement of one cell: the policy is built, or trained if needed, and run through the episodes."""

from dataclasses import replace
from typing import Any

import numpy as np

from agents.benchmark.agent_files import from_file
from agents.benchmark.plan import AT, HELD_OUT, BenchmarkCell, Request
from agents.benchmark.policy_effort import decision_ms, model_of, tuned_on
from agents.benchmark.results import Result, result_of
from agents.evaluation_cache import CHUNK, cached_evaluation
from grind_env.envs.distribution_splits import EVERY
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.nominal_model import on
from grind_env.policies.planners.hindsight import Hindsight
from grind_env.policies.policy import Policy
from grind_env.policies.registry import make_policy


def measure(cell: BenchmarkCell, request: Request) -> Result:
    """Return the result of a cell; episodes cached for equal code, parameters and seeds are not run again."""
    make = trained if cell.trains else scripted
    policy, made = make(cell, request)
    problem = cell.problem
    runs, episodes, between = request.runs / cell.apart, request.episodes, request.interpolation_episodes
    plants = request.plants_episodes if policy.sees == "measurements" else 0
    if cell.variant and not cell.trains:
        # variants of hindsight are slow, and paired comparisons need few episodes
        episodes, between = min(episodes, CHUNK), 0

    def run(count: int, split: str = EVERY, on_plants: bool = False) -> Evaluation:
        seeds, what = range(request.first, request.first + count), on(problem, HELD_OUT) if on_plants else problem
        place = request.runs / f"{AT}{HELD_OUT}" / cell.apart if on_plants else runs
        return cached_evaluation(policy, what, seeds, place, split=split, fresh=request.fresh)

    return result_of(
        cell,
        policy.sees,
        run(episodes),
        run(between, "interpolation") if between else None,
        run(plants, on_plants=True) if plants else None,
        request.first,
        # measured after the evaluation, which compiles the code, in a new simulation, for which no table exists
        decision_ms=decision_ms(policy, replace(problem).simulation()),
        model=model_of(cell),
        **made,
    )


def scripted(cell: BenchmarkCell, request: Request) -> tuple[Policy, dict[str, Any]]:
    """Return an untrained policy, with the number of blocks of its tuning."""
    simulation = cell.problem.simulation()
    policy = make_policy(cell.base, simulation, request.configs)
    if cell.variant and isinstance(policy, Hindsight):
        policy = Hindsight(int(cell.variant))
    return policy, {"blocks": tuned_on(cell.base, simulation, request.configs)}


def trained(cell: BenchmarkCell, request: Request) -> tuple[Policy, dict[str, Any]]:
    """Return an agent, with the facts of its training."""
    # torch takes seconds to import
    from agents.benchmark.agent_training import agent_of, training_of

    path = agent_of(cell, request)
    steps, split, seconds, curve = training_of(path)
    policy = from_file(path, cell.problem.simulation(), cell.name)
    policy.sees = "measurements"
    made = {"blocks": steps, "steps": steps, "trained_on": split, "train_seconds": seconds}
    points = np.array(curve, np.float32).reshape(-1, 2).T
    return policy, made | {"curve_steps": points[0], "curve_score": points[1]}
