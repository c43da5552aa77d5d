"""Reference scores of `grind/WidePlates-v0`: plans, rules, and plans that were made with the whole episode known."""

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from pathlib import Path

import numpy as np
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from agents.reference.scores import mean_return
from agents.search import grid_search
from grind_env.envs.names import environment_id
from grind_env.envs.rows import Outcome
from grind_env.envs.tasks import Task, read_task
from grind_env.envs.wide_plates.env import TASK
from grind_env.envs.wide_plates.simulation import CrossSimulation
from grind_env.policies.choices import Array, nearest_speed, speed_bounds, speed_grid
from grind_env.policies.evaluation import Evaluation, episode_seeds, roll_out, start_episodes
from grind_env.policies.policy import Policy
from grind_env.policies.scripted.rules import Fixed, PowerThreshold, Random, handbook
from grind_env.policies.scripted.size_threshold import SizeThreshold
from grind_env.policies.tuned import write_whole
from grind_env.scores import FILE, Reference, read_references, write_text

EPISODES = 24
TRAINING = 20
SPEEDS = 10
INTERVALS = (2, 3, 4, 6)
"""Parts from one dress to the next."""
SHARES = (0.35, 0.5, 0.65, 0.8)
"""Of the tolerance, above which the size rule dresses."""
ENERGIES = (13.0, 14.5, 16.0, 18.0, 21.0)
"""J/mm3, above which the power rule dresses."""
SWEEPS = 2
"""Passes of the planner over the blocks of a plan."""
SPEED_STEP = 1.15
"""Factor by which it moves E."""

COST, GOOD, FINISHED = (Outcome._fields.index(name) for name in ("cost", "good", "finished"))

Advance = Callable[[], object]


def tuned(simulation: CrossSimulation, episodes: int, advance: Advance) -> list[Policy]:
    """The best constant, interval and thresholds on the training episodes."""
    task = simulation.task
    start = start_episodes(simulation, episode_seeds("training", episodes))
    speeds = [speed / 1000.0 for speed in speed_grid(task, SPEEDS).tolist()]

    def best(policies: Iterator[Policy]) -> Policy:
        def cost(policy: Policy) -> float:
            advance()
            return float(roll_out(policy, simulation, start).cost.mean())

        found: Policy = grid_search(cost, policies).point
        return found

    interval = best(Fixed(E, 1, every, "interval") for E, every in product(speeds, INTERVALS))
    assert isinstance(interval, Fixed)
    near = (interval.E, 1.2 * interval.E)
    return [
        best(Fixed(E, D) for E, D in product(speeds, range(task.action.executions + 1))),
        interval,
        best(SizeThreshold((E,), (share,)) for E, share in product(near, SHARES)),
        best(PowerThreshold(E, energy, 1.0, 1.0) for E, energy in product(near, ENERGIES)),
    ]


def evaluations_of(task: Task) -> int:
    """How many policies `tuned` tries."""
    return SPEEDS * (task.action.executions + 1 + len(INTERVALS)) + 2 * (len(SHARES) + len(ENERGIES))


class Plan:
    """E (mm/min) and D of every block of one episode, and what they cost, block by block."""

    def __init__(self, simulation: CrossSimulation, seed: int, speeds: Array, executions: Array) -> None:
        self.speeds, self.executions = speeds, executions
        episodes = start_episodes(simulation, [seed])
        steps = [simulation.step(episodes, E[None], D[None])[0][0] for E, D in zip(speeds, executions, strict=True)]
        self.outcomes = np.array(steps)

    @property
    def cost(self) -> float:
        """$ of the episode."""
        return float(self.outcomes[:, COST].sum())


def planned(simulation: CrossSimulation, seed: int, start: Plan, advance: Advance) -> Plan:
    """A plan improved block by block as long as it pays: E up or down, one dress more or less."""
    best, low_high = start, speed_bounds(simulation.task)
    for _, block in product(range(SWEEPS), range(simulation.task.blocks)):
        dresses = -1 if best.executions[block] > 0.0 else 1
        for factor, dress in ((SPEED_STEP, 0), (1.0 / SPEED_STEP, 0), (1.0, dresses)):
            speeds, executions = best.speeds.copy(), best.executions.copy()
            speeds[block] = nearest_speed(simulation.task, np.clip(speeds[block] * factor, *low_high))
            executions[block] = np.clip(executions[block] + dress, 0, simulation.task.action.executions)
            trial = Plan(simulation, seed, speeds, executions)
            best = min(best, trial, key=lambda plan: plan.cost)
        advance()
    return best


def hindsight(simulation: CrossSimulation, seeds: Sequence[int], start: Evaluation, advance: Advance) -> Evaluation:
    """The improved plan of each episode, from what a policy did there."""
    plans = []
    for k, seed in enumerate(seeds):
        first = Plan(simulation, seed, start.speeds[k].copy(), start.executions[k].copy())
        plans.append(planned(simulation, seed, first, advance))
    outcomes = np.array([plan.outcomes for plan in plans]).sum(axis=1)
    return Evaluation(
        outcomes[:, COST],
        outcomes[:, GOOD],
        outcomes[:, FINISHED],
        np.array([plan.speeds for plan in plans]),
        np.array([plan.executions for plan in plans]),
    )


def wide_plates_reference(*, episodes: int = EPISODES, training: int = TRAINING) -> Reference:
    """Tune the plans and rules, improve the plan of every evaluation episode, and measure all on these.

    Args:
        episodes: evaluation episodes.
        training: training episodes.
    """
    task = read_task(TASK)
    simulation = CrossSimulation(task)
    seeds = episode_seeds("evaluation", episodes)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, transient=True) as progress:
        bar = progress.add_task(f"{TASK}: tuning", total=evaluations_of(task))
        policies: list[Policy] = [Random(), handbook(task), *tuned(simulation, training, lambda: progress.advance(bar))]
        found = {each.name: roll_out(each, simulation, start_episodes(simulation, seeds)) for each in policies}
        means = {name: float(run.cost.mean()) for name, run in found.items()}
        fixed = min(("constant", "interval"), key=means.__getitem__)
        scripted = min(means, key=means.__getitem__)
        bar = progress.add_task(f"{TASK}: planning", total=episodes * SWEEPS * task.blocks)
        found["hindsight"] = hindsight(simulation, seeds, found[scripted], lambda: progress.advance(bar))
    return Reference(
        zero=mean_return(task, found[fixed]).value,
        hundred=mean_return(task, found["hindsight"]).value,
        ratio=False,
        fixed_plan=fixed,
        best_scripted=scripted,
        J_fix=round(means[fixed], 4),
        J_plan=round(float(found["hindsight"].cost.mean()), 4),
        returns={name: mean_return(task, run) for name, run in found.items()},
    )


def score_wide_plates(data: Path = FILE) -> None:
    """Measure the reference scores of the plates that are wider than the wheel."""
    found = wide_plates_reference()
    # read only now: others may have written to the file in the meantime
    write_whole(data, write_text({**read_references(data), environment_id(TASK): found}))
