"""The hindsight planner, which knows the whole tape of an episode, and the exact optimum of a small task."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from agents.evaluate import roll_out
from agents.planners import all_choices
from agents.policy import Array, Decision, Policy, Sees, nearest_speed, speed_bounds
from grind_env.envs.simulation import Episodes, Outcome, Simulation
from grind_env.envs.tasks import Task
from grind_env.errors import GrindError

COST = Outcome._fields.index("cost")

SWEEPS = 8
STRETCH = 6
"""Blocks whose E is scaled together."""


@dataclass
class Hindsight:
    """Improves the plans of other policies by coordinate search on the true tape (scenarios, section 7, 6).

    A strong reference, not a proven bound.

    Args:
        starts: policies whose plans it starts from; the cheapest plan of each episode is improved.
        sweeps: passes over the blocks.
        seed: of the random moves.
    """

    starts: Sequence[Policy]
    sweeps: int = SWEEPS
    seed: int = 0
    name: ClassVar[str] = "hindsight"
    sees: ClassVar[Sees] = "future"
    simulation: Simulation = field(init=False, repr=False)
    plan: Decision | None = field(init=False, repr=False, default=None)
    block: int = field(init=False, repr=False)

    def begin(self, task: Task, episodes: int) -> None:
        """Throw the plan away."""
        self.simulation, self.plan, self.block = Simulation(task), None, 0

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Plan the whole episode before the first block, then follow the plan."""
        if self.plan is None:
            assert episodes is not None
            self.plan = self._plan(episodes)
        self.block += 1
        return Decision(self.plan.speeds[:, self.block - 1], self.plan.executions[:, self.block - 1])

    def _plan(self, episodes: Episodes) -> Decision:
        runs = [roll_out(policy, self.simulation, episodes) for policy in self.starts]
        best = np.argmin([run.cost for run in runs], axis=0)
        n = np.arange(len(best))
        plan = Decision(
            np.array([run.speeds for run in runs])[best, n], np.array([run.executions for run in runs])[best, n]
        )
        rng = np.random.default_rng(self.seed)
        for _ in range(self.sweeps):
            plan = sweep(self.simulation, episodes, plan, rng)
        return plan


def sweep(simulation: Simulation, start: Episodes, plan: Decision, rng: np.random.Generator) -> Decision:
    """One pass over the blocks: at each, the cheapest of the moves of every episode's plan is kept.

    Args:
        simulation: of the task.
        start: N episodes at their first block; left as they are.
        plan: E and D, each shape (N, blocks).
        rng: draws random E.

    Returns:
        The plan, no dearer for any episode.
    """
    task, n = simulation.task, len(start.block)
    plan = Decision(plan.speeds.copy(), plan.executions.copy())
    state = start.pick(np.arange(n))
    for k in range(task.blocks):
        speeds, executions = moves(task, Decision(plan.speeds[:, k:], plan.executions[:, k:]), rng)
        cost = plan_cost(simulation, state, speeds, executions)
        best = cost.argmin(axis=0)
        plan.speeds[:, k:] = speeds[best, np.arange(n)]
        plan.executions[:, k:] = executions[best, np.arange(n)]
        simulation.step(state, plan.speeds[:, k].copy(), plan.executions[:, k].copy())
    return plan


def plan_cost(simulation: Simulation, state: Episodes, speeds: Array, executions: Array) -> Array:
    """Cost of the rest of N episodes under C plans each, shape (C, N); plans have shape (C, N, blocks left)."""
    plans, n, blocks = speeds.shape
    branches = state.pick(np.tile(np.arange(n), plans))
    E = np.ascontiguousarray(speeds.reshape(-1, blocks).T)
    D = np.ascontiguousarray(executions.reshape(-1, blocks).T)
    cost = np.zeros(plans * n)
    for k in range(blocks):
        cost += simulation.step(branches, E[k], D[k])[0][:, COST]
    return cost.reshape(plans, n)


def moves(task: Task, plan: Decision, rng: np.random.Generator) -> Decision:
    """The plan itself and changes that begin with its first block, each shape (C, N, blocks left)."""
    n, blocks = plan.speeds.shape
    low, high = speed_bounds(task)
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
    """E scaled by `factor`; of a task with levels of E, the next level that way."""
    if task.action.speed_levels is None:
        return nearest_speed(task, speeds * factor)
    levels = 1000.0 * np.array(task.action.speed_levels)
    index = np.searchsorted(levels, speeds) + np.sign(factor - 1.0).astype(np.int64)
    return levels[np.clip(index, 0, len(levels) - 1)]


@dataclass(frozen=True, slots=True)
class Optimum:
    """The cheapest plan of a deterministic task."""

    cost: float
    """$, handover included."""
    speeds: Array
    """E, mm/min, shape (blocks,)."""
    executions: Array
    """D, shape (blocks,)."""
    runner_up: float
    """Cost of the second-best plan, $."""


def exact_optimum(task: Task) -> Optimum:
    """The exact optimum of a task without chance and with levels of E, by trying every plan.

    Plans share their beginnings: n choices and B blocks take n + n^2 + ... + n^B block evaluations.

    Raises:
        GrindError: if the task draws anything at random or has a range of E.
    """
    if task.action.speed_levels is None or any(getattr(task.spread, name) for name in task.spread.__slots__):
        raise GrindError(f"{task.name} has no exact optimum: it needs levels of E and no spread")
    simulation = Simulation(task)
    choices = all_choices(task, 0)
    n = len(choices.speeds)
    first = simulation.start([np.random.default_rng(0)])
    costs = []
    for k in range(n):  # one first choice at a time keeps the last level small
        state, cost = first.pick([0]), np.zeros(1)
        cost = cost + simulation.step(state, choices.speeds[k : k + 1], choices.executions[k : k + 1])[0][:, COST]
        for _ in range(1, task.blocks):
            state = state.pick(np.repeat(np.arange(len(cost)), n))
            decision = np.tile(choices.speeds, len(cost)), np.tile(choices.executions, len(cost))
            cost = np.repeat(cost, n) + simulation.step(state, *decision)[0][:, COST]
        costs.append(cost)
    every = np.concatenate(costs)
    best, second = np.argsort(every, kind="stable")[:2]
    plan = np.array(np.unravel_index(best, (n,) * task.blocks))
    return Optimum(float(every[best]), choices.speeds[plan], choices.executions[plan], float(every[second]))
