"""The hindsight planner, which knows the whole noise tape of an episode."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation, advance
from grind_env.envs.tasks import Task
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.episode_columns import COST
from grind_env.policies.planners.dynamic_programming import forward_plans, surcharges
from grind_env.policies.policy import Sees

SWEEPS = 3
STRETCH = 6  #: number of blocks whose E is scaled together


@dataclass
class Hindsight:
    """Planner of the whole episode on its true tape: forward dynamic programming, then coordinate search.

    A strong reference, not a proven bound.

    Args:
        sweeps: passes over the blocks.
        seed: seed of the random moves.
    """

    sweeps: int = SWEEPS
    seed: int = 0
    name: ClassVar[str] = "hindsight"
    sees: ClassVar[Sees] = "future"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.simulation, self.block = simulation, 0
        self.plan: Decision | None = None

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        if self.plan is None:
            assert episodes is not None
            self.plan = cheapest_plans(self.simulation, episodes)
            rng = np.random.default_rng(self.seed)
            for _ in range(self.sweeps):
                self.plan = sweep(self.simulation, episodes, self.plan, rng)
        self.block += 1
        return Decision(self.plan.speeds[:, self.block - 1], self.plan.executions[:, self.block - 1])


def cheapest_plans(simulation: Simulation, start: Episodes) -> Decision:
    """Return for each of N episodes the cheapest plan of forward dynamic programming over all surcharges."""
    plans = [forward_plans(simulation, start, surcharge) for surcharge in surcharges(simulation.task)]
    speeds, executions = np.stack([plan.speeds for plan in plans]), np.stack([plan.executions for plan in plans])
    best = plan_cost(simulation, start, speeds, executions).argmin(axis=0)
    n = np.arange(len(best))
    return Decision(speeds[best, n], executions[best, n])


def sweep(simulation: Simulation, start: Episodes, plan: Decision, rng: np.random.Generator) -> Decision:
    """Go once over the blocks and keep the cheapest change of each episode's plan at each block.

    Args:
        simulation: simulation of the task.
        start: N episodes at their first block; they stay unchanged.
        plan: E and D, each shape (N, blocks).
        rng: draws random E.

    Returns:
        The new plan, which costs no episode more.
    """
    task, n = simulation.task, len(start.block)
    plan = Decision(plan.speeds.copy(), plan.executions.copy())
    state = start.pick(np.arange(n))
    for k in range(plan.speeds.shape[1]):
        speeds, executions = moves(task, Decision(plan.speeds[:, k:], plan.executions[:, k:]), rng)
        cost = plan_cost(simulation, state, speeds, executions)
        best = cost.argmin(axis=0)
        plan.speeds[:, k:] = speeds[best, np.arange(n)]
        plan.executions[:, k:] = executions[best, np.arange(n)]
        advance(simulation, state, plan.speeds[:, k].copy(), plan.executions[:, k].copy())
    return plan


def plan_cost(simulation: Simulation, state: Episodes, speeds: Array, executions: Array) -> Array:
    """Return the cost of the rest of N episodes, $, shape (C, N); plans have shape (C, N, blocks left)."""
    plans, n, blocks = speeds.shape
    branches = state.pick(np.tile(np.arange(n), plans))
    E = np.ascontiguousarray(speeds.reshape(-1, blocks).T)
    D = np.ascontiguousarray(executions.reshape(-1, blocks).T)
    cost = np.zeros(plans * n)
    for k in range(blocks):
        cost += advance(simulation, branches, E[k], D[k])[0][:, COST]
    return cost.reshape(plans, n)


def moves(task: Task, plan: Decision, rng: np.random.Generator) -> Decision:
    """Return the plan itself and changes that begin with its first block, each shape (C, N, blocks left)."""
    n, blocks = plan.speeds.shape
    low, high = task.action.speed_ends
    E, D = [plan.speeds], [plan.executions]

    def add(speeds: Array, executions: Array) -> None:
        E.append(speeds)
        D.append(executions)

    def scaled(factor: float | Array, stretch: int = 1) -> Array:
        speeds = plan.speeds.copy()
        speeds[:, :stretch] = moved(task, speeds[:, :stretch], np.broadcast_to(factor, (n,))[:, None])
        return speeds

    def dressed(*changes: float) -> Array:
        executions = plan.executions.copy()
        changed = executions[:, : len(changes)] + np.array(changes)[:blocks]
        fits = ((changed >= 0) & (changed <= task.action.executions)).all(axis=1)
        executions[:, : len(changes)] = np.where(fits[:, None], changed, executions[:, : len(changes)])
        return executions

    anywhere = plan.speeds.copy()
    anywhere[:, 0] = nearest_speed(task, np.exp(rng.uniform(np.log(low), np.log(high), n)))
    nearby = scaled(np.exp(rng.normal(0.0, 0.15, n)))
    for speeds in (scaled(1.05), scaled(1 / 1.05), scaled(1.01), scaled(1 / 1.01), nearby, anywhere):
        add(speeds, plan.executions)
    for factor in (1.05, 1 / 1.05):
        add(scaled(factor, STRETCH), plan.executions)
    for executions in (dressed(1), dressed(-1), dressed(1, -1), dressed(-1, 1)):
        add(plan.speeds, executions)
        add(nearby, executions)
    for factor in (1.3, 1 / 1.3):
        for executions in (dressed(1), dressed(-1)):
            add(scaled(factor), executions)
    return Decision(np.array(E), np.array(D))


def moved(task: Task, speeds: Array, factor: Array) -> Array:
    """Return E scaled by `factor`; for a task with levels of E, the next level in that direction."""
    if task.action.speed_levels is None:
        return nearest_speed(task, speeds * factor)
    levels = np.array(task.action.speed_levels)
    index = np.searchsorted(levels, speeds) + np.sign(factor - 1.0).astype(np.int64)
    return levels[np.clip(index, 0, len(levels) - 1)]
