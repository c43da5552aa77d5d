from dataclasses import replace
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

from grind_env.control import read
from grind_env.envs.blocks.job import conditions, job
from grind_env.machine.grind import grind
from grind_env.process.equations import LEAST_DIAMETER
from grind_env.process.state import WheelState
from tests.envs.harness import whole_tape

DIAMETER = WheelState._fields.index("ds")
WORN = {"material": "inconel_718", "Gref": 0.2, "fc": 0.2}
"""With the highest E and D less than an episode wears the wheel away in these."""


@pytest.mark.parametrize("more", [{}, {"stock": 3.0}])
def test_a_wheel_may_be_dressed_away_in_a_program_of_the_control(more: dict[str, float]) -> None:
    env = gym.make("grind/WidePlates-v0", show_block=False).unwrapped
    env.reset(seed=0, options={"context": WORN | more})
    # so little is left of it that dressing takes it all
    env.episodes.wheels[0, DIAMETER] = LEAST_DIAMETER + 2.0
    terminated = False
    while not terminated:
        observation, reward, terminated, *_ = env.step(np.ones(2, np.float32))
        assert np.isfinite(reward) and env.observation_space.contains(observation)
    assert env.episodes.wheels[0, DIAMETER] == LEAST_DIAMETER


@pytest.fixture
def fast_slot(tmp_path: Path) -> Path:
    """Slot with a table that is fast enough to wear a wheel away."""
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
    assert record.strokes["worn"].sum() > volume(300.0, LEAST_DIAMETER, env.task.kinds[0].width)


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
        # nobody gets a wheel for less than it is worth
        lost = volume(300.0, env.episodes.wheels[0, DIAMETER], env.task.kinds[0].width)
        assert paid >= 0.99 * env.task.rates.wheel * lost
        untimed.append(reward - info["reward_time"])
    assert env.episodes.wheels[0, DIAMETER] == LEAST_DIAMETER
    # once nothing is left of it a faster table saves time, and no more
    assert np.diff(untimed).max() < 1e-9


def volume(before: float, after: float, width: float) -> float:
    """Of the ring between two diameters, mm3."""
    return float(np.pi / 4.0 * (before**2 - after**2) * width)
