"""Findings of the dress study: the interval, the dresser's settings, and the trigger of a dress.

All E and all intervals are chosen on training episodes; the reported costs come from evaluation episodes.
"""

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from itertools import product

import numpy as np

from agents.csv_tables import csv_of
from agents.provenance import provenance
from agents.tuning.minimisers import BestPoint, refine
from grind_env.array_types import Array
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Dress
from grind_env.output_checks import FileKind
from grind_env.policies.choices import speed_grid
from grind_env.policies.evaluation import Evaluation, episode_seeds, start_episodes
from grind_env.policies.planners.hindsight import plan_cost
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import JOB, Problem
from grind_env.policies.scripted.rules import Fixed
from grind_env.process.equations import dress_width, overlap_ratio

#: number of training episodes for the choice of a plan. With rare, expensive scrap, 48 episodes chose plans up to 13 %
#: more expensive than the best one, 128 up to 2.5 %, and 256 no worse plans than 1024 (WideRails)
TRAINING = 256
#: number of episodes for the choice of E at each interval; 48 chose plans at most 1.3 % more expensive there
SCREENING = 48
SPEEDS = 12
INTERVALS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48)
PLANS = (1, 2, 3, 4, 6, 8, 12, 20, 32)  #: intervals tried with each setting of the dresser
LEADS = (0.4, 0.6, 0.8, 1.0, 1.4, 2.0)
DEPTHS = (0.5, 0.75, 1.0, 1.5, 2.0)  #: settings of the dresser, as factors of the task's own
PASSES = (1, 2, 3, 4, 6)  #: passes of the diamond in an execution
DEPTH_DIGITS = 3  #: number of decimals of a dress depth in mm; a control reads no finer depth

TABLE = FileKind("table of `python -m agents dress-study`", re.compile(b"task,question,policy,").match)


@dataclass(frozen=True, slots=True, kw_only=True)
class DressFinding:
    """Cost of one dress strategy on the evaluation episodes of a task."""

    task: str
    #: `interval`, `plan` (the best of all intervals, by the training episodes), `dresser`, `passes` or `decision`
    question: str
    policy: str
    sees: str
    every: int  #: number of blocks from dress to dress in a fixed plan; 0 for a policy that decides
    lead: float  #: dress lead, mm per wheel revolution
    depth: float  #: dress depth, mm per pass
    passes: int
    overlap: float  #: overlap ratio with an unworn diamond
    E: float  #: mean table speed, mm/min
    D: float  #: mean D, dress executions per block
    cost: float  #: cost per good part, $; the next two fields are the ends of its 95 % interval
    cost_low: float
    cost_high: float
    scrap: float  #: share of the parts that are scrap


def intervals(simulation: Simulation) -> list[int]:
    """Return the intervals that fit in an episode."""
    return [every for every in INTERVALS if every <= simulation.task.blocks]


def dressers(problem: Problem) -> list[tuple[str, Dress]]:
    """Return the tried dresser settings, with their question; none for a part program, which sets its own dresser."""
    if problem.id == JOB:
        return []
    own = problem.simulation().task.dress
    tried = [
        ("dresser", replace(own, lead=round(own.lead * lead, 6), depth=round(own.depth * depth, DEPTH_DIGITS)))
        for lead, depth in product(LEADS, DEPTHS)
    ]
    return [*tried, *(("passes", replace(own, passes=passes)) for passes in PASSES)]


def best_plan(simulation: Simulation, every: Sequence[int]) -> Fixed:
    """Return the constant E and the interval of least cost on training episodes; one execution each time.

    A few episodes find a good E for each interval; many episodes then choose the interval and refine E.
    """
    task, episodes = simulation.task, start_episodes(simulation, episode_seeds("training", TRAINING))
    few = episodes.pick(np.arange(min(SCREENING, TRAINING)))
    speeds = [float(speed) for speed in speed_grid(task, SPEEDS)]
    plans = []
    for interval in every:
        tried = [Fixed(E, 1, interval, "interval") for E in speeds]
        plans.append(tried[int(mean_costs(tried, simulation, few).argmin())])
    costs = mean_costs(plans, simulation, episodes)
    best = plans[int(costs.argmin())]
    if task.action.speed_levels is not None:
        return best
    start = BestPoint(best.E, float(costs.min()), len(plans))
    found = refine(
        lambda E: float(mean_costs([replace(best, E=E)], simulation, episodes)[0]), start, *task.action.speed_ends
    )
    return replace(best, E=found.point)


def mean_costs(plans: Sequence[Fixed], simulation: Simulation, episodes: Episodes) -> Array:
    """Return the mean cost of an episode under each plan, $, shape (plans,); the episodes stay unchanged."""
    n, steps = len(episodes.block), simulation.task.blocks
    decided = []
    for plan in plans:
        plan.begin(simulation, 1)
        # a fixed plan does not use the observation
        decided.append([plan.act(np.zeros((1, 0), np.float32), None) for _ in range(steps)])
    # axes before the transpose: plans, blocks, E and D, one episode
    table: Array = np.array(decided).transpose(2, 0, 3, 1)
    speeds, executions = np.broadcast_to(table, (2, len(plans), n, steps))
    costs: Array = plan_cost(simulation, episodes, speeds, executions).mean(axis=1)
    return costs


def finding(
    name: str, simulation: Simulation, question: str, policy: Policy, run: Evaluation, every: int = 0
) -> DressFinding:
    """Return the finding of an evaluation."""
    cost, dress = run.cost_per_good_part, simulation.task.dress
    return DressFinding(
        task=name,
        question=question,
        policy=policy.name,
        sees=policy.sees,
        every=every,
        lead=dress.lead,
        depth=dress.depth,
        passes=dress.passes,
        overlap=new_overlap(simulation),
        E=run.speed,
        D=run.dresses,
        cost=cost.value,
        cost_low=cost.low,
        cost_high=cost.high,
        scrap=run.scrap,
    )


def new_overlap(simulation: Simulation) -> float:
    """Return the overlap ratio of the dress with an unworn diamond."""
    task = simulation.task
    return overlap_ratio(dress_width(task.dress.depth, task.dresser.tip_radius, 0.0), task.dress_lead)


def about(found: Sequence[DressFinding], question: str) -> list[DressFinding]:
    """Return the findings on one question."""
    return [each for each in found if each.question == question]


def csv_text(found: Sequence[DressFinding], seeds: range) -> str:
    """Return the findings, with seeds and versions in every row."""
    facts = provenance(seeds, trains=False)
    names = [each.name for each in fields(DressFinding)]
    return csv_of([*names, *facts], [(*asdict(each).values(), *facts.values()) for each in found])
