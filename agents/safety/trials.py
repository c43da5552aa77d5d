"""Returns and violations of policies in a task with a budget of scrap; agents are trained first."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from agents.benchmark.agent_training import plain_agent
from agents.evaluation_cache import RUNS, sources
from grind_env.array_types import Table
from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.cost import Outcome
from grind_env.envs.simulation import Simulation, advance
from grind_env.errors import GrindError
from grind_env.policies.evaluation import episode_seeds, run_seeds, start_episodes
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.policy import Policy
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.privileged_information import reveal
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.registry import make_policy
from grind_env.policies.score_statistics import Interval, bootstrap
from grind_env.process.cost import NO_LIMIT, STALL
from grind_env.training import gru_ppo
from grind_env.training.gru_ppo import Settings

#: planners on measurements and on the state, and decimals of a budget. The budget of a task is the geometric mean of
#: both planners' scrap: the second planner keeps it, the first does not. This measured budget fits any task
PLANNERS, DIGITS = ("look_ahead", "mpc"), 4
VALIDATED = 128  #: number of validation episodes of the planners
UNCONSTRAINED, LAGRANGIAN = "plain_gru", "plain_gru, Lagrangian"
RULES = ("constant", "guarded:look_ahead", *PLANNERS)
#: limits that a block can violate. Power over its limit costs time. A stall of the spindle, or size, Ra or temperature
#: rise beyond its limit condemns a part (`process.cost.passed_limits`)
LIMITS = ("power", "stall", "size", "Ra", "burn")

COST, FINISHED, GOOD = (Outcome._fields.index(name) for name in ("cost", "finished", "good"))
POWER, TORQUE, SIZE, ROUGHNESS, RISE = (
    Outcome._fields.index(name) for name in ("power_ratio", "peak_torque", "size_error", "roughness_ratio", "rise")
)
SIZE_LIMIT, RISE_LIMIT = KindRow._fields.index("size"), KindRow._fields.index("rise")


@dataclass(frozen=True)
class SafetyTrial:
    """Policy in a problem; `seed` and `steps` are of the training of an agent."""

    problem: Problem
    who: str
    seed: int
    steps: int
    episodes: int
    folder: Path = field(default=RUNS, repr=False, compare=False)  #: folder of the files of trained agents
    #: True to train again although the file of the agent exists
    fresh: bool = field(default=False, repr=False, compare=False)

    def __str__(self) -> str:
        return f"{self.problem.name}, {self.who}, seed {self.seed}"


@dataclass(frozen=True, slots=True, kw_only=True)
class SafetyRow:
    """Result of a cell on evaluation episodes, with 95 % intervals over them."""

    task: str
    who: str
    seed: int
    steps: int
    episodes: int
    budget: float  #: share of the parts that may be scrap
    episode_return: float
    return_low: float
    return_high: float
    scrap: float  #: share of the parts that are scrap
    scrap_low: float
    scrap_high: float
    power: float  #: share of the blocks over the power limit; the next fields are shares of the blocks, too
    stall: float
    size: float
    Ra: float
    burn: float


@cache
def budget_of(problem: Problem) -> float:
    """Return the share of the parts that may be scrap; the planners must be tuned for the problem.

    Raises:
        GrindError: a planner scraps nothing, so that no budget lies between the planners.
    """
    simulation, seeds = problem.simulation(), episode_seeds("validation", VALIDATED)
    scrap = [run_seeds(make_policy(name, simulation), simulation, seeds).scrap for name in PLANNERS]
    budget = round(math.prod(scrap) ** 0.5, DIGITS)
    if budget == 0.0:
        raise GrindError(f"a planner scraps nothing in {problem.name}, so there is no budget: leave out this task")
    return budget


def violations(policy: Policy, simulation: Simulation, seeds: Sequence[int]) -> tuple[Table, Table]:
    """Run a policy; return cost in $, finished and good parts of every episode, shape (N, 3).

    The second array has the number of blocks that violate each of `LIMITS`, shape (N, limits).
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


def judge(trial: SafetyTrial) -> dict[str, object]:
    """Return the row of a trial; an agent is trained first."""
    problem, simulation = trial.problem, trial.problem.simulation()
    budget, rule = budget_of(problem), trial.who in RULES
    if rule:
        policy = named_policy(trial.who, simulation)
    else:
        settings = Settings(steps=trial.steps, budget=budget if trial.who == LAGRANGIAN else None)
        path = plain_agent(problem, trial.who, settings, trial.seed, trial.folder, fresh=trial.fresh)
        policy = load_policy(path, simulation=simulation)
    totals, found = violations(policy, simulation, episode_seeds("evaluation", trial.episodes))
    cost, finished, good = totals.T
    earned = bootstrap(lambda spent: -spent.mean(axis=-1) / simulation.task.reference_cost, cost)
    scrap = bootstrap(lambda parts, kept: 1.0 - kept.sum(axis=-1) / parts.sum(axis=-1), finished, good)
    shares = found.sum(axis=0) / (trial.episodes * simulation.task.blocks)
    judged = SafetyRow(
        task=problem.name,
        who=trial.who,
        seed=trial.seed,
        steps=0 if rule else trial.steps,
        episodes=trial.episodes,
        budget=budget,
        **_interval("episode_return", "return", earned),
        **_interval("scrap", "scrap", scrap),
        **dict(zip(LIMITS, map(float, shares), strict=True)),
    )
    return asdict(judged)


def decides(trial: SafetyTrial) -> object:
    """Return the inputs of a trial: its rule, the planners of the budget, and their code."""
    simulation = trial.problem.simulation()
    rule = named_policy(trial.who, simulation) if trial.who in RULES else None
    planners = [make_policy(name, simulation) for name in PLANNERS]
    modules = [type(each).__module__ for each in planners]
    codes = [sources(name) for name in (*modules, type(rule).__module__ if rule else gru_ppo.__name__)]
    return rule, planners, VALIDATED, codes


def _interval(name: str, ends: str, found: Interval) -> dict[str, float]:
    return {name: found.value, f"{ends}_low": found.low, f"{ends}_high": found.high}
