"""No corner of the legal contexts leaves the space of the observations, or costs more wheel than there is."""

from itertools import product
from typing import Any

import numpy as np
import pytest

from grind_env.envs import any_task
from grind_env.envs.contexts import CONTEXT_FACTORS, Given, read_options, without_effect
from grind_env.envs.cost import Outcome
from grind_env.envs.names import shipped_names
from grind_env.envs.observations import bounds
from grind_env.envs.simulation import Simulation, advance
from grind_env.envs.tasks import Task, read_task
from grind_env.machine.loops.rows import OWN_FROM
from grind_env.process.equations import LEAST_DIAMETER
from grind_env.process.state import WheelState
from tests.envs.harness import Array

WEARING = ("kA", "pm", "fc", "Gref", "hf")
"""The factors that wear the wheel most; all of their corners are tried, with the most stock."""
MIXED = 64
"""Corners of all factors together, drawn at random, half of them with the least stock."""
BOUNDED, FREE = ("wheel", "change", "scrap"), ("time", "dress", "handover", "late")
LARGEST_ERROR = 0.1
"""mm; more than single precision or a gauge is off."""


def simulation_of(task: Task) -> Simulation:
    return any_task.simulation_of(task, "full")


def corners(task: Task) -> list[dict[str, Any]]:
    """Contexts at the ends of what each factor may be."""
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


def ring(diameter: Array, width: float) -> Array:
    """Volume of a wheel of that diameter, mm3, down to nothing."""
    return 0.25 * np.pi * diameter**2 * width


NOT_WORN_AWAY = ("CBN", "credit", "memory", "oracle6", "power_limited", "wide_plates")


@pytest.mark.parametrize("name", shipped_names())
def test_no_block_costs_more_than_the_rest_of_the_wheel_its_change_and_the_scrap(name: str) -> None:
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


def test_the_cost_of_a_wheel_is_what_it_loses_as_long_as_anything_is_left_of_it() -> None:
    task = read_task("slot")
    simulation = simulation_of(task)
    context = {"material": "inconel_718", "Gref": 0.2, "fc": 0.2}
    episodes = simulation.start([np.random.default_rng(0)], [read_options(task, {"context": context}, Given())])
    paid, first = 0.0, episodes.wheel(0).ds
    for _ in range(task.blocks):
        paid += float(Outcome(*simulation.step(episodes, np.array([15_000.0]), np.array([4.0]))[0][0]).wheel_cost)
    least = episodes.wheel(0).ds
    whole = task.rates.wheel * float(ring(np.array(first), task.wheel.width) - ring(np.array(least), task.wheel.width))
    assert paid == pytest.approx(whole, rel=0.2) and paid <= whole * (1.0 + 1e-9)
