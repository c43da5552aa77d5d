"""Wear and cost of a wheel until it is worn away, in the environment and on the machine."""

from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from grind_env.control import read
from grind_env.envs import task_env_factory
from grind_env.envs.blocks.task_job import conditions, job
from grind_env.envs.cost import Outcome
from grind_env.envs.observations import bounds
from grind_env.envs.reset_options import CONTEXT_FACTORS, Given, read_options, without_effect
from grind_env.envs.simulation import Simulation, advance
from grind_env.envs.task_names import shipped_names
from grind_env.envs.tasks import Task, read_task
from grind_env.machine.grind import grind
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.process.equations import LEAST_DIAMETER
from grind_env.process.stroke_types import WheelState
from tests.envs.harness import Array, whole_tape

DIAMETER = WheelState._fields.index("ds")
#: context in which the highest E and D wear the wheel away in less than an episode
WORN = {"material": "inconel_718", "Gref": 0.2, "fc": 0.2}


@pytest.mark.parametrize("more", [{}, {"stock": 3.0}])
def test_a_wheel_may_be_dressed_down_to_its_least_diameter(more: dict[str, float]) -> None:
    env = gym.make("grind/WidePlates-v0", show_block=False).unwrapped
    env.reset(seed=0, options={"context": WORN | more})
    # dressing takes all that is left of the wheel
    env.episodes.wheels[0, DIAMETER] = LEAST_DIAMETER + 2.0
    terminated = False
    while not terminated:
        observation, reward, terminated, *_ = env.step(np.ones(2, np.float32))
        assert np.isfinite(reward) and env.observation_space.contains(observation)
    assert env.episodes.wheels[0, DIAMETER] == LEAST_DIAMETER


@pytest.fixture
def fast_slot(tmp_path: Path) -> Path:
    """Write the Slot task with a table fast enough to wear a wheel away."""
    path = tmp_path / "fast.toml"
    path.write_text('base = "slot"\n[action]\nspeed_range = [6000, 30000]\n', encoding="utf-8")
    return path


def test_the_machine_wears_the_wheel_away_as_the_environment_does(fast_slot: Path) -> None:
    env = gym.make("grind/Task-v0", task=str(fast_slot)).unwrapped
    env.reset(seed=0, options={"context": WORN})
    for _ in range(3):
        env.step(np.ones(2, np.float32))
    wheel = env.episodes.wheel(0)
    assert wheel.ds == LEAST_DIAMETER
    first = tuple(conditions(env.task, whole_tape(env))[:3])
    record = grind(read(env.part_program()), replace(job(env.task, *env.task.kinds), parts=first))
    assert record.strokes["ds"][-1] == LEAST_DIAMETER
    width = env.task.kinds[0].width
    assert record.strokes["worn"].sum() > ring(300.0, width) - ring(LEAST_DIAMETER, width)


def test_the_machine_grinds_on_with_a_destroyed_wheel_as_the_environment_does() -> None:
    env = gym.make("grind/PowerLimited-v0").unwrapped
    context = {"material": "inconel_718", "kA": 20, "wheel_kA": 20, "fc": 0.2, "Gref": 0.2}
    env.reset(seed=0, options={"context": context})
    found = env.episodes.wheel(0)
    for _ in range(3):
        env.step(np.full(2, -1.0, np.float32))
    wheel = env.episodes.wheel(0)
    shop, first = job(env.task, *env.task.kinds), tuple(conditions(env.task, whole_tape(env))[:3])
    start = replace(shop.wheel, diameter=found.ds, wear_flat_area=found.A, diamond_flat=found.wd)
    record = grind(read(env.part_program()), replace(shop, wheel=start, parts=first))
    limit = shop.setup.wheel.wear_flat_limit
    assert ((record.strokes["A"] <= 0.0) | (record.strokes["A"] >= limit)).any()
    assert sum("destroys the wheel" in warning for warning in record.warnings) >= 1
    assert record.strokes["A"][-1] == pytest.approx(wheel.A, rel=1e-9)
    assert record.strokes["ds"][-1] == pytest.approx(wheel.ds, rel=1e-9)


def test_wearing_a_wheel_away_does_not_pay(fast_slot: Path) -> None:
    untimed = []
    for E in (12_000.0, 15_000.0, 18_000.0, 20_000.0, 25_000.0, 30_000.0):
        env = gym.make("grind/Task-v0", task=str(fast_slot), action="dict").unwrapped
        env.reset(seed=0, options={"context": WORN | {"stock": 2.0}})
        _, reward, _, _, info = env.step({"E": np.array([E], np.float32), "D": 3})
        paid = -info["reward_wheel"] * env.task.reference_cost
        # the cost is at least the value of the lost volume
        width = env.task.kinds[0].width
        lost = ring(300.0, width) - ring(env.episodes.wheels[0, DIAMETER], width)
        assert paid >= 0.99 * env.task.rates.wheel * lost
        untimed.append(reward - info["reward_time"])
    assert env.episodes.wheels[0, DIAMETER] == LEAST_DIAMETER
    # a faster table saves time and nothing else
    assert np.diff(untimed).max() < 1e-9


#: factors that wear the wheel most; all their corners are tried, with the most stock
WEARING = ("kA", "pm", "fc", "Gref", "hf")
MIXED = 64  #: corners of all factors together, drawn at random, half of them with the least stock
BOUNDED, FREE = ("wheel", "change", "scrap"), ("time", "dress", "handover", "late")
LARGEST_ERROR = 0.1  #: mm; more than the error of single precision and of a gauge


def simulation_of(task: Task) -> Simulation:
    return task_env_factory.simulation_of(task, "full")


def corners(task: Task) -> list[dict[str, Any]]:
    """Return contexts at the ends of the range of each factor."""
    names = [name for name in CONTEXT_FACTORS if name not in without_effect(task)]
    ends = {name: (CONTEXT_FACTORS[name].low, CONTEXT_FACTORS[name].high) for name in names}
    if "executions_left" in ends:
        ends["executions_left"] = (0.0, float(np.floor(task.start.executions_left[1])))
    found = [
        {"material": material, "stock": ends["stock"][1], **dict(zip(WEARING, values, strict=True))}
        for material in ("aisi_1020", "inconel_718")
        for values in product(*(ends[name] for name in WEARING))
    ]
    rng = np.random.default_rng(0)
    mixed = [{name: ends[name][rng.integers(2)] for name in names} for _ in range(MIXED)]
    return found + mixed


def ring(diameter: Array | float, width: float) -> Array | float:
    """Return the volume of a solid wheel of the given diameter, mm3."""
    return 0.25 * np.pi * diameter**2 * width


NOT_WORN_AWAY = ("CBN", "credit", "memory", "oracle6", "power_limited", "wide_plates")


@pytest.mark.parametrize("name", shipped_names())
def test_a_block_costs_at_most_the_rest_of_the_wheel_its_change_and_the_scrap(name: str) -> None:
    task = read_task(name)
    simulation = simulation_of(task)
    given = [read_options(task, {"context": each}, Given()) for each in corners(task)]
    n = len(given)
    episodes = simulation.start([np.random.default_rng(i) for i in range(n)], given)
    rng, worst = np.random.default_rng(1), 0.0
    space = bounds(simulation.entries)
    low, high = task.action.speed_ends
    scrap, change = max(kind.scrap for kind in task.kinds), task.wheel_change.price if task.wheel_change else 0.0
    while not simulation.over(episodes).all():
        running = ~simulation.over(episodes)
        before = WheelState(*episodes.wheels[:, :OWN_FROM].T.copy()).ds
        E = np.where(rng.random(n) < 0.5, low, high)
        D = rng.choice([0.0, task.action.executions], n)
        outcome = Outcome(*advance(simulation, episodes, E, D)[0].T)
        observations = simulation.observe(episodes)
        assert ((observations >= space[0]) & (observations <= space[1])).all()
        assert np.isfinite(outcome.cost[running]).all() and (outcome.cost[running] > 0.0).all()
        left = task.rates.wheel * ring(before + LARGEST_ERROR, task.wheel.width)
        assert (outcome.wheel_cost <= left)[running].all()
        bounded = sum(getattr(outcome, f"{term}_cost") for term in BOUNDED)
        assert (bounded <= left + scrap + change)[running].all()
        assert outcome.cost[running] == pytest.approx(
            (bounded + sum(getattr(outcome, f"{term}_cost") for term in FREE))[running]
        )
        worst = max(worst, float((outcome.wheel_cost / left)[running].max()))
    # the bound is met where a wheel wears away
    worn_away = WheelState(*episodes.wheels[:, :OWN_FROM].T).ds.min() == LEAST_DIAMETER
    assert worst > 0.9 if worn_away else name in NOT_WORN_AWAY
