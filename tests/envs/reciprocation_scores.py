"""Reference scores of `grind/Reciprocation-v0`, measured as in scenarios.md, section 7; run by hand.

    python -m tests.envs.reciprocation_scores

Best constant (E, D) and best interval are tuned on 48 episodes, the better of the two is the fixed plan; it and the
hindsight planner are evaluated on 64 others, common to both.
"""

import itertools

import numpy as np
from numpy.typing import NDArray

from agents.bounds.dynamic_programming import forward_plans
from agents.bounds.hindsight import sweep
from grind_env.envs.reciprocation import reciprocation_task
from grind_env.envs.reciprocation_env import ReciprocationSimulation
from grind_env.envs.rows import Outcome

COST = Outcome._fields.index("cost")
TRAINING, EVALUATION = range(48), range(10_000, 10_064)
INTERVALS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20)

Array = NDArray[np.float64]


def costs(simulation: ReciprocationSimulation, seeds: range, speeds: Array, executions: Array) -> Array:
    """$ per block of each episode under plans of shape (episodes or 1, blocks)."""
    episodes = simulation.start([np.random.default_rng(seed) for seed in seeds])
    shape = (len(seeds), simulation.task.blocks)
    total = np.zeros(len(seeds))
    for E, D in zip(np.broadcast_to(speeds, shape).T, np.broadcast_to(executions, shape).T, strict=True):
        total += simulation.step(episodes, np.array(E, float), np.array(D, float))[0][:, COST]
    return total / shape[1]


def every(blocks: int, interval: int, executions: int) -> Array:
    """D of each block, shape (1, blocks), when every `interval`-th one has `executions`."""
    return np.where(np.arange(1, blocks + 1) % interval == 0, float(executions), 0.0)[None]


def best_fixed(simulation: ReciprocationSimulation) -> tuple[float, int, int]:
    """E, interval and executions of the best plan without sensors."""
    blocks = simulation.task.blocks

    def cost(E: float, interval: int, executions: int) -> float:
        return float(costs(simulation, TRAINING, np.array([[E]]), every(blocks, interval, executions)).mean())

    grid = itertools.product(np.round(np.geomspace(3000, 30_000, 20)), INTERVALS, (1, 2, 3))
    best = min((cost(*plan), plan) for plan in grid)
    for factor in (1.1, 1.05, 1.025, 1.01):
        E, *rest = best[1]
        best = min(best, *((cost(round(E * f), *rest), (round(E * f), *rest)) for f in (factor, 1.0 / factor)))
    return best[1]


def main() -> None:
    """Print the scores."""
    simulation = ReciprocationSimulation(reciprocation_task())
    E, interval, executions = best_fixed(simulation)
    plan = every(simulation.task.blocks, interval, executions)
    fixed = costs(simulation, EVALUATION, np.array([[E]]), plan)
    episodes = simulation.start([np.random.default_rng(seed) for seed in EVALUATION])
    planned = forward_plans(simulation, episodes)
    forward = costs(simulation, EVALUATION, planned.speeds, planned.executions)
    planned = sweep(simulation, episodes, planned, np.random.default_rng(0))
    planner = costs(simulation, EVALUATION, planned.speeds, planned.executions)
    print(f"best fixed plan: E {E:g} mm/min, {executions} dress(es) in every {interval}. block")
    for name, found in (("fixed plan", fixed), ("forward planning", forward), ("hindsight planner", planner)):
        print(f"{name}: {found.mean():.3f} +- {found.std() / len(found) ** 0.5:.3f} $ per block")
    gain = 100.0 * (1.0 - planner.mean() / fixed.mean())
    error = 100.0 * (fixed - planner - (1.0 - planner.mean() / fixed.mean()) * fixed).std() / fixed.mean()
    print(f"gain of the planner: {gain:.1f} +- {error / len(fixed) ** 0.5:.1f} %")


if __name__ == "__main__":
    main()
