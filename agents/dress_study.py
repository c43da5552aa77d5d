"""How a wheel should be dressed: the interval, the dresser's settings, and what decides when.

Three questions of a grinding engineer for each task. All E and all intervals are chosen on training episodes; the
costs that are told come from evaluation episodes.
"""

import hashlib
import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from csv import DictWriter
from dataclasses import asdict, dataclass, fields, replace
from io import StringIO
from itertools import product
from pathlib import Path

from agents.cells import RUNS, behaviour, kept_evaluation
from agents.evaluate import Evaluation, episode_seeds, evaluate, roll_out, start_episodes
from agents.policy import Policy, speed_grid
from agents.provenance import provenance
from agents.scripted.rules import Fixed
from agents.tuned import write_whole
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.process.equations import dress_width, overlap_ratio

EPISODES = 256
TRAINING = 48
SPEEDS = 12
INTERVALS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48)
PLANS = (1, 2, 3, 4, 6, 8, 12, 20, 32)
"""Intervals tried with each setting of the dresser."""
LEADS = (0.4, 0.6, 0.8, 1.0, 1.4, 2.0)
DEPTHS = (0.5, 0.75, 1.0, 1.5, 2.0)
"""Settings of the dresser, as factors of the task's own."""

Advance = Callable[[], object]


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What one way to dress costs on the evaluation episodes of a task."""

    task: str
    question: str
    """`interval`, `dresser` or `decision`."""
    policy: str
    sees: str
    every: int
    """Blocks from dress to dress of a fixed plan; 0 of a policy that decides."""
    lead: float
    """mm a wheel revolution."""
    depth: float
    """mm a pass."""
    overlap: float
    """Overlap ratio of the new diamond."""
    E: float
    """Mean table speed, m/min."""
    D: float
    """Mean executions a block."""
    cost: float
    """$ per good part, with the ends of its 95 % interval."""
    cost_low: float
    cost_high: float
    scrap: float
    """Share of the parts."""


def dress_study(
    task: Task, deciders: Sequence[Policy], *, episodes: int = EPISODES, runs: Path = RUNS, advance: Advance
) -> list[Finding]:
    """Answer the three questions for a task.

    Args:
        task: the task.
        deciders: policies that decide when to dress, for the third question.
        episodes: evaluation episodes.
        runs: what is found is kept below, in `<task>/dress_study/`, and used again while the task is the same.
        advance: called after every finding; there are `count(task, deciders)`.
    """
    seeds = episode_seeds("evaluation", episodes)
    found = []
    for every in intervals(task):
        found.append(kept_finding(runs, task, "interval", seeds, (every,)))
        advance()
    for lead, depth in product(LEADS, DEPTHS):
        dress = replace(task.dress, lead=round(task.dress.lead * lead, 6), depth=round(task.dress.depth * depth, 6))
        found.append(kept_finding(runs, replace(task, dress=dress), "dresser", seeds, PLANS))
        advance()
    for policy in deciders:
        found.append(finding(task, "decision", policy, kept_evaluation(policy, task, seeds, runs)))
        advance()
    return found


def intervals(task: Task) -> list[int]:
    """The intervals that fit in an episode."""
    return [every for every in INTERVALS if every <= task.blocks]


def count(task: Task, deciders: Sequence[Policy]) -> int:
    """Number of findings of a study."""
    return len(intervals(task)) + len(LEADS) * len(DEPTHS) + len(deciders)


def best_plan(task: Task, every: Sequence[int]) -> Fixed:
    """The constant E and the interval, of those given, of least cost on training episodes; one execution each time."""
    simulation = Simulation(task)
    episodes = start_episodes(simulation, episode_seeds("training", TRAINING))
    plans = [
        Fixed(float(speed) / 1000.0, 1, interval, "interval")
        for speed, interval in product(speed_grid(task, SPEEDS), every)
    ]
    return min(plans, key=lambda plan: float(roll_out(plan, simulation, episodes).cost.mean()))


def kept_finding(runs: Path, task: Task, question: str, seeds: range, every: Sequence[int]) -> Finding:
    """The best fixed plan with these intervals on the evaluation episodes, kept or new."""
    made_by = f"{behaviour(task)} {question} {seeds} {every} {SPEEDS} {TRAINING}"
    path = runs / task.name / "dress_study" / f"{hashlib.sha256(made_by.encode()).hexdigest()[:16]}.json"
    # a file that is missing or damaged is made anew
    with suppress(OSError, ValueError, TypeError):
        return Finding(**json.loads(path.read_text(encoding="utf-8")))
    plan = best_plan(task, [interval for interval in every if interval <= task.blocks])
    result = finding(task, question, plan, evaluate(plan, task, seeds), plan.every)
    write_whole(path, json.dumps(asdict(result)))
    return result


def finding(task: Task, question: str, policy: Policy, run: Evaluation, every: int = 0) -> Finding:
    """What an evaluation says."""
    cost = run.cost_per_good_part
    return Finding(
        task=task.name,
        question=question,
        policy=policy.name,
        sees=policy.sees,
        every=every,
        lead=task.dress.lead,
        depth=task.dress.depth,
        overlap=new_overlap(task),
        E=float(run.speeds.mean()) / 1000.0,
        D=float(run.executions.mean()),
        cost=cost.value,
        cost_low=cost.low,
        cost_high=cost.high,
        scrap=run.scrap,
    )


def new_overlap(task: Task) -> float:
    """Overlap ratio of the task's dress with a diamond that is not worn."""
    tip = task.parameters(task.kinds[0]).rd
    return overlap_ratio(dress_width(task.dress.depth, tip, 0.0), task.dress_lead)


def csv_text(found: Sequence[Finding], seeds: range) -> str:
    """The findings, with seeds and versions in every row."""
    facts = {key: value for key, value in provenance(seeds).items() if key not in ("stable_baselines3", "torch")}
    text = StringIO()
    lines = DictWriter(text, [*(each.name for each in fields(Finding)), *facts], lineterminator="\n")
    lines.writeheader()
    lines.writerows({**asdict(each), **facts} for each in found)
    return text.getvalue()
