"""Measure one cell: build or train the policy if needed, and run it through the episodes."""

from dataclasses import replace
from typing import Any

from agents.benchmark.plan import AT, HELD_OUT, LIMIT, LIMITED, PLAIN, PUBLIC, ROBUST, BenchmarkCell, Request
from agents.benchmark.price import model_of, price_of, tuned_on
from agents.benchmark.results import Result, result_of
from agents.benchmark.trained import from_file
from agents.budgets import TUNING_EPISODES
from agents.cells import CHUNK, kept_evaluation
from grind_env.envs.splits import EVERY
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.model_view import on
from grind_env.policies.planners.hindsight import Hindsight
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem
from grind_env.policies.registry import make_policy

GENERATION = 16
"""Points of CMA-ES that are tried together, at most, of so few coefficients."""


def measure(cell: BenchmarkCell, request: Request) -> Result:
    """Measure a cell; what is cached of the same code, parameters and seeds is not run again."""
    make = trained if cell.trains else scripted
    policy, problem, made = make(cell, request)
    runs, episodes, between = request.runs / cell.apart, request.episodes, request.interpolation_episodes
    plants = request.plants_episodes if policy.sees == "measurements" else 0
    if cell.variant and cell.variant != LIMITED:
        # of the curve of hindsight, which is long to make, and paired
        episodes, between = min(episodes, CHUNK), 0

    def run(count: int, split: str = EVERY, on_plants: bool = False) -> Evaluation:
        seeds, what = range(request.first, request.first + count), on(problem, HELD_OUT) if on_plants else problem
        place = request.runs / f"{AT}{HELD_OUT}" / cell.apart if on_plants else runs
        return kept_evaluation(policy, what, seeds, place, split=split, fresh=request.fresh)

    return result_of(
        cell,
        policy.sees,
        run(episodes),
        run(between, "interpolation") if between else None,
        run(plants, on_plants=True) if plants else None,
        # behind the evaluation, which has compiled what it needs; in a simulation for which no table has been made
        price_of(policy, replace(problem).simulation()),
        request.first,
        model=model_of(cell),
        **made,
    )


def scripted(cell: BenchmarkCell, request: Request) -> tuple[Policy, Problem, dict[str, Any]]:
    """Return a policy that is not trained, with its tuned parameters, and its problem."""
    base, configs, simulation = cell.base, request.configs, cell.problem.simulation()
    if cell.variant == LIMITED:
        # it takes seconds to import
        from agents.tuning.rules import tune

        runs = request.runs / cell.apart / base
        # a search ends with a generation
        configs, evaluations = runs / "parameters", LIMIT // (TUNING_EPISODES * simulation.task.blocks) - GENERATION
        tune(cell.problem, [base], evaluations=evaluations, starts=1, folder=configs, runs=runs, fresh=request.fresh)
    blocks = tuned_on(base, simulation, configs)
    policy = make_policy(base, simulation, configs)
    if cell.variant and isinstance(policy, Hindsight):
        policy = Hindsight(int(cell.variant))
    return policy, cell.problem, {"blocks": blocks}


def trained(cell: BenchmarkCell, request: Request) -> tuple[Policy, Problem, dict[str, Any]]:
    """Return an agent, and the problem as it is shown it."""
    # torch takes seconds to import
    from agents.benchmark.agents import plain_agent, recipe_agent, training_of
    from grind_env.training.gru_ppo import shown

    assert cell.seed is not None
    problem = cell.problem
    if cell.policy in PLAIN:
        memory: Any = PLAIN[cell.policy]
        problem = shown(problem, memory)
        ground = on(problem, PUBLIC) if cell.policy == ROBUST else problem
        path = plain_agent(ground, cell.policy, memory, cell.seed, request.steps, request.runs, fresh=request.fresh)
    else:
        path = recipe_agent(problem, cell.seed, request.steps, request.runs, fresh=request.fresh)
    policy, found = from_file(path, problem.simulation(), cell.name), training_of(path)
    policy.sees = "state" if PLAIN.get(cell.policy) == "state" else "measurements"
    steps, split, seconds = found
    return policy, problem, {"blocks": steps, "steps": steps, "trained_on": split, "train_seconds": seconds}
