"""Costs of fixed policies in every scenario against those published (scenarios, section 5)."""

import functools

import numpy as np
import pytest

from grind_env.envs.blocks.tables import Outcome
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import load_task
from tests.envs.harness import Array, alike, start

EPISODES = 160
NAMES = ("slot", "job_shop", "rush", "wide_rails", "blades", "CBN")
"""Power_limited has tests of its own, and Oracle6 its exact optimum."""
COST, GOOD = (Outcome._fields.index(name) for name in ("cost", "good"))


@functools.cache
def simulation(name: str) -> Simulation:
    return Simulation(load_task(name))


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


def per_good_part(cost: Array, good: Array) -> tuple[float, float]:
    """$ and standard error."""
    ratio = cost.sum() / good.sum()
    return float(ratio), float(np.std(cost - ratio * good, ddof=1) / np.sqrt(len(cost)) / good.mean())


def assert_published(measured: tuple[float, float], value: float) -> None:
    """Within four standard errors of the difference, the published error taken as ours, and the few per cent
    that scenarios.md expects of another law of time."""
    mean, error = measured
    assert mean == pytest.approx(value, abs=4.0 * np.sqrt(2.0) * error + 0.03 * value)


@pytest.mark.parametrize(
    ("name", "speed", "value"),
    [
        ("slot", 12.0, 7.15),
        ("job_shop", 15.0, 4.63),
        ("rush", 15.0, 34.0),
        ("wide_rails", 12.0, 8.87),
        ("blades", 10.0, 3.92),
        ("CBN", 20.0, 19.9),
    ],
)
def test_the_handbook_constant(name: str, speed: float, value: float) -> None:
    measured = per_good_part(*episode_costs(name, 1000.0 * speed, 1.0, 9000, EPISODES))
    assert measured[1] < 0.06 * measured[0]
    assert_published(measured, value)


@pytest.mark.parametrize(
    ("name", "value"),
    [("slot", 31.0), ("job_shop", 5.44), ("rush", 74.0), ("wide_rails", 56.0), ("blades", 18.7), ("CBN", 27.0)],
)
def test_random_plans(name: str, value: float) -> None:
    task = simulation(name).task
    plan = alike(task, task.blocks, EPISODES)
    measured = per_good_part(*episode_costs(name, *plan, 9000, EPISODES))
    assert measured[1] < 0.06 * measured[0]
    assert_published(measured, value)


def every(name: str, interval: int) -> Array:
    """One execution in the last block of every interval, shape (blocks, 1)."""
    blocks = simulation(name).task.blocks
    return (np.arange(blocks) % interval == interval - 1).astype(float)[:, None]


FIXED_PLANS = {
    "slot": (np.geomspace(9000.0, 11500.0, 6), (1,), 6.17),
    "job_shop": (np.geomspace(8000.0, 12000.0, 6), (4, 5), 2.87),
    "rush": (np.geomspace(14000.0, 20000.0, 6), (8, 10, 12), 4.53),
    "wide_rails": (np.geomspace(8500.0, 11500.0, 6), (1,), 6.31),
    # 3.71 was measured with an error of 6 % of its own (see its paired gain); dressing every finish block is 3.35
    "blades": (np.geomspace(12500.0, 16500.0, 6), (2,), 3.35),
    "CBN": (np.geomspace(8500.0, 12000.0, 6), (8, 10), 8.71),
}
"""E in mm/min and intervals among which the best fixed plan of a task is found, and its published cost."""


@functools.cache
def best_fixed_plan(name: str) -> tuple[float, tuple[float, float]]:
    """$ of an episode and $ per good part of the best plan; chosen on other episodes than it is measured on."""
    speeds, intervals, _ = FIXED_PLANS[name]
    plans = [(speed, interval) for speed in speeds for interval in intervals]
    costs = [episode_costs(name, speed, every(name, interval), 5000, 64)[0].mean() for speed, interval in plans]
    speed, interval = plans[int(np.argmin(costs))]
    cost, good = episode_costs(name, speed, every(name, interval), 9000, EPISODES)
    return float(cost.mean()), per_good_part(cost, good)


@pytest.mark.parametrize("name", NAMES)
def test_the_best_fixed_plan(name: str) -> None:
    cost, measured = best_fixed_plan(name)
    assert measured[1] < 0.05 * measured[0]
    assert_published(measured, FIXED_PLANS[name][2])
    task = simulation(name).task
    # the reference cost of the reward is the cost of a block under it
    error = measured[1] / measured[0]
    assert task.reference_cost == pytest.approx(cost / task.blocks, rel=0.02 + 3.0 * error)


@pytest.mark.parametrize("name", NAMES)
def test_never_dressing_costs_many_times_the_best_fixed_plan(name: str) -> None:
    low, high = simulation(name).task.action.speed_range or (0.0, 0.0)
    speeds = 1000.0 * np.geomspace(low, high, 12)
    never = min(per_good_part(*episode_costs(name, speed, 0.0, 9000, 48))[0] for speed in speeds)
    assert never > 8.0 * best_fixed_plan(name)[1][0]
