"""The order of fixed policies in every scenario (scenarios, section 5)."""

import functools
import itertools

import numpy as np
import pytest

from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import load_task
from tests.envs.harness import Array, alike, start

EPISODES = 96
NAMES = ("slot", "job_shop", "rush", "power_limited", "wide_rails", "blades", "CBN")
"""Oracle6 has its exact optimum."""
INTERVALS = (1, 2, 4, 6, 8, 12)
"""Blocks from dress to dress among which the best fixed plan is found; two-block tasks dress after finishing."""
HANDBOOK_SPEED = 12_000.0
"""mm/min; a usual table speed for hardened steel."""
HANDBOOK_SPEEDS = {"power_limited": 8000.0, "wide_rails": 8000.0}
"""mm/min, of the tasks whose spindle of 5 kW the usual one stalls."""
COST, GOOD = (Outcome._fields.index(name) for name in ("cost", "good"))


@functools.cache
def simulation(name: str) -> Simulation:
    return BlockSimulation(load_task(name))


def episode_costs(
    name: str, speeds: Array | float, dresses: Array | float, first: int, count: int
) -> tuple[Array, Array]:
    """Cost in $ and number of good parts of every episode, of plans that broadcast to (blocks, count)."""
    sim = simulation(name)
    episodes = start(sim, count, first)
    total = np.zeros((count, 2))
    shape = (sim.task.blocks, count)
    for E, D in zip(np.broadcast_to(speeds, shape), np.broadcast_to(dresses, shape), strict=True):
        total += sim.step(episodes, np.array(E, float), np.array(D, float))[0][:, [COST, GOOD]]
    return total[:, 0], total[:, 1]


def per_good_part(cost: Array, good: Array) -> float:
    """$."""
    return float(cost.sum() / max(good.sum(), 1e-9))


def difference(dearer: tuple[Array, Array], cheaper: tuple[Array, Array]) -> tuple[float, float]:
    """$ per good part by which one of two plans is dearer in the same episodes, and its standard error."""
    ratios = [per_good_part(*plan) for plan in (dearer, cheaper)]
    rests = [(cost - ratio * good) / good.mean() for (cost, good), ratio in zip((dearer, cheaper), ratios, strict=True)]
    return ratios[0] - ratios[1], float(np.std(rests[0] - rests[1], ddof=1) / np.sqrt(len(rests[0])))


def every(name: str, interval: int) -> Array:
    """One execution in the last block of every interval, shape (blocks, 1)."""
    blocks = simulation(name).task.blocks
    return (np.arange(blocks) % interval == interval - 1).astype(float)[:, None]


@functools.cache
def best_fixed_plan(name: str) -> tuple[Array, Array]:
    """Costs and good parts of the best plan; chosen on other episodes than it is measured on."""
    low, high = simulation(name).task.action.speed_range or (0.0, 0.0)
    plans = list(itertools.product(1000.0 * np.geomspace(low, high, 12), INTERVALS))
    costs = [episode_costs(name, speed, every(name, interval), 5000, 16)[0].mean() for speed, interval in plans]
    speed, interval = plans[int(np.argmin(costs))]
    return episode_costs(name, speed, every(name, interval), 9000, EPISODES)


@pytest.mark.parametrize("name", NAMES)
def test_random_plans_are_dearer_than_the_handbook_and_no_constant_beats_the_best_fixed_plan(name: str) -> None:
    task = simulation(name).task
    handbook = episode_costs(name, HANDBOOK_SPEEDS.get(name, HANDBOOK_SPEED), 1.0, 9000, EPISODES)
    random = episode_costs(name, *alike(task, task.blocks, EPISODES), 9000, EPISODES)
    gain, error = difference(random, handbook)
    assert gain > 3.0 * error
    gain, error = difference(handbook, best_fixed_plan(name))
    assert gain > -3.0 * error


@pytest.mark.parametrize("name", NAMES)
def test_the_best_fixed_plan_grinds_good_parts(name: str) -> None:
    # scrap costs several times what a good part does: a task is no lottery
    task = simulation(name).task
    cost, good = best_fixed_plan(name)
    assert good.mean() > 0.9 * task.parts
    assert per_good_part(cost, good) < 0.25 * min(kind.scrap for kind in task.kinds)
