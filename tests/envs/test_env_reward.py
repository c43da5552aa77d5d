import functools
import math
from typing import NamedTuple

import gymnasium as gym
import numpy as np
import pytest

from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.tasks import Task, load_task, task_names
from tests.envs.harness import IDS, Array, Course, actions, reward_terms_of, rollout, start

TERMS = ["time", "wheel", "dress", "scrap", "handover"]


class Published(NamedTuple):
    """Published set-up of a task."""

    speed: float = 30.0  #: surface speed of the new wheel, m/s
    width: float = 25.0
    price: float = 1e-4
    passes: int = 2
    depth: float = 0.02
    lead: float = 0.10  #: dressing lead, mm per wheel revolution
    setup: float = 8.0
    load: float = 20.0

    @property
    def dress_seconds(self) -> float:
        """Time of a dress, s: the lead as an F word with three decimals, over the wheel and 10 mm more."""
        feed = round(self.lead * 60_000.0 * self.speed / (math.pi * 300.0), 3) / 60.0
        return self.setup + self.passes * (self.width + 10.0) / feed


SETUPS = {
    "slot": Published(),
    "job_shop": Published(lead=0.05),
    "rush": Published(),
    "oracle6": Published(lead=0.14),
    "power_limited": Published(width=65.0, depth=0.03, lead=0.15, setup=60.0),
    "wide_rails": Published(width=65.0, load=30.0),
    "blades": Published(speed=25.0, depth=0.01),
    "CBN": Published(speed=35.0, price=2e-2, passes=3, depth=0.004),
    "memory": Published(lead=0.05, setup=60.0, load=5.0),
    "noise": Published(setup=600.0, load=5.0),
    "credit": Published(width=65.0, depth=0.03, lead=0.15, setup=120.0),
}
#: mm/min; a faster table stalls a spindle of 5 kW in most blocks
FASTEST = {"power_limited": 12_000.0, "wide_rails": 12_000.0}
STALL_SECONDS = 600.0
#: time of a gauging between two blocks of a part; a stalled spindle costs `STALL_SECONDS` once a part
GAUGE_SECONDS = 10.0
TEMPERING = {"aisi_52100": 450.0, "aisi_1020": 600.0, "inconel_718": 600.0}


@pytest.mark.parametrize("env_id", [*IDS, "grind/Reciprocation-v0", "grind/WidePlates-v0"])
def test_the_reward_is_the_sum_of_its_terms(env_id: str) -> None:
    env = gym.make(env_id, info="full")
    task: Task = env.unwrapped.task
    total, cost = 0.0, 0.0
    for episode in range(3):
        env.reset(seed=episode)
        for k, action in enumerate(actions(task.blocks, 1, seed=episode)[:, 0]):
            _, reward, terminated, truncated, info = env.step(action)
            terms = reward_terms_of(info)
            further = {"grind/Rush-v0": ["late"], "grind/CBN-v0": ["change"]}.get(env_id, [])
            assert list(terms) == TERMS + further
            assert reward == pytest.approx(sum(terms.values()), rel=1e-12)
            assert reward == pytest.approx(-info["block_cost"] / task.reference_cost, rel=1e-12)
            assert all(term <= 0.0 for term in terms.values())
            assert terminated == (k == task.blocks - 1)
            assert terminated or terms["handover"] == 0.0
            assert not truncated
            total, cost = total + reward, cost + info["block_cost"]

            # hourly rate 80 $, dresser 0.10 $ per execution
            assert terms["time"] == pytest.approx(-80.0 * info["seconds"] / 3600.0 / task.reference_cost)
            assert terms["dress"] == pytest.approx(-0.10 * info["D"] / task.reference_cost, abs=1e-15)
            scrap = env.unwrapped.blocks[-1].kind.scrap
            assert 0.0 <= info["cost"] <= 1.0
            ends = env.unwrapped.blocks[-1].kind.ends_part
            assert info["cost"] == (pytest.approx(1.0 - info["good_parts"], abs=1e-15) if ends else 0.0)
            assert ends or info["good_parts"] == 0.0
            assert terms["scrap"] == pytest.approx(-scrap * info["cost"] / task.reference_cost)
    assert total == pytest.approx(-cost / task.reference_cost)


class Run(Course):
    """Random episodes of a task with their spindle stalls."""

    def __init__(self, name: str) -> None:
        task = load_task(name)
        rng, shape = np.random.default_rng(0), (task.blocks, 64)
        low, high = task.action.speed_ends
        high = min(high, FASTEST.get(name, high))
        speeds = low * (high / low) ** rng.random(shape)
        # some episodes hardly dress, some do in every block
        executions = np.floor(rng.random(shape) * (task.action.executions + 1))
        executions[rng.random(shape) > rng.random(64) ** 2] = 0.0
        super().__init__(BlockSimulation(task), speeds, executions)
        starts = self.of_kind("starts_part")
        over = self.outcome.peak_torque >= 1.0
        self.stalled_before = np.concatenate([np.zeros((1, 64), bool), over[:-1]]) & ~starts
        """Mask of the blocks that begin after a stall on their part."""
        self.stalls = over & ~self.stalled_before
        """Mask of the blocks with a stall."""


run = functools.cache(Run)


def test_random_plans_stall_the_spindle_in_some_blocks() -> None:
    stalls = {name: run(name).stalls.mean() for name in task_names()}
    assert stalls.pop("credit") > 0.5  # Credit is ruinous without dresses
    assert max(stalls.values()) < 0.5 and 0.0 < np.median(list(stalls.values())) < 0.05
    assert run("wide_rails").stalled_before.any()


@pytest.mark.parametrize("name", task_names())
def test_the_wheel_cost_is_the_price_of_the_lost_volume(name: str) -> None:
    r, shop = run(name), SETUPS[name]
    kept = r.outcome.change_cost == 0.0
    dressed = shop.depth * shop.passes * r.executions  # radius, mm
    worn = (r.wheels.ds[:-1] - r.wheels.ds[1:]) / 2.0 - dressed
    # the wheel no longer cuts a part after a stall
    # nor may a finish block cut a part that has become too thin as it cooled
    cuts = kept & ~r.stalled_before
    assert (worn[cuts & r.of_kind("starts_part")] > 0.0).all()
    assert worn[cuts].min() > -1e-12 and (worn[cuts] > 0.0).mean() > 0.97
    np.testing.assert_allclose(worn[kept & r.stalled_before], 0.0, atol=1e-12)
    mean = (r.wheels.ds[:-1] + r.wheels.ds[1:]) / 2.0
    volume = math.pi * mean * (dressed * shop.width + worn * r.of_kind("width"))
    np.testing.assert_allclose(r.outcome.wheel_cost[kept], (shop.price * volume)[kept], rtol=1e-3)
    assert kept.mean() > 0.98


@pytest.mark.parametrize("name", task_names())
def test_a_block_takes_the_time_of_its_strokes_and_dresses(name: str) -> None:
    r, shop = run(name), SETUPS[name]
    # ceil(H/a) plunges, one coverage stroke, L spark-out strokes
    strokes = np.ceil(r.tape.stock.T / r.of_kind("pick") - 1e-6) + 1 + r.of_kind("sparkout")
    assert (r.result.strokes == strokes).all()
    assert (r.result.dresses == r.executions).all()
    speed = r.speeds / 60.0
    # the table does not reach its speed where the stroke is shorter than speed^2 over 1 m/s2
    distance = r.of_kind("length") + 60.0
    reached = distance / speed + speed / 1000.0
    stroke_seconds = np.where(speed**2 <= 1000.0 * distance, reached, 2.0 * np.sqrt(distance / 1000.0)) + 0.15
    seconds = strokes * stroke_seconds + r.executions * shop.dress_seconds
    seconds = seconds + np.where(r.of_kind("starts_part"), shop.load, GAUGE_SECONDS)
    seconds = seconds + 2400.0 * (r.outcome.change_cost > 0.0) + STALL_SECONDS * r.stalls
    np.testing.assert_allclose(r.outcome.seconds, seconds, rtol=1e-12)


def scrap(x: Array) -> Array:
    return 1.0 / (1.0 + np.exp(-np.clip(x, -500.0, 500.0)))


@pytest.mark.parametrize("name", task_names())
def test_the_part_is_good_when_every_limit_holds_in_every_block(name: str) -> None:
    # the logistic steps of the cost written out, with torque in place of power; no part is good after a stall
    r = run(name)
    outcome = r.outcome
    allowance, rough, tolerance = (r.of_kind(key) for key in ("rise_allowance", "roughness_limit", "tolerance"))
    heat = np.where(allowance > 0.0, r.result.plunge_rise, r.result.finish_rise)
    np.testing.assert_array_equal(outcome.rise, heat)
    tempering = np.array([TEMPERING[kind.material] for kind in r.task.kinds])[r.kinds]
    roughness = outcome.roughness / np.where(rough > 0.0, rough, 1.0)
    good = (
        (1.0 - scrap((heat - tempering - allowance) / 12.0))
        * np.where(outcome.peak_torque < 1.0, 1.0 - scrap((outcome.peak_torque - 1.0) / 0.02), 0.0)
        * (1.0 - np.where(rough > 0.0, scrap((roughness - 1.0) / 0.04), 0.0))
        * (1.0 - np.where(tolerance > 0.0, scrap((np.abs(outcome.size_error) - tolerance) / 0.8), 0.0))
    )
    starts, ends = r.of_kind("starts_part"), r.of_kind("ends_part")
    whole = good * np.where(starts, 1.0, np.concatenate([np.ones((1, 64)), good[:-1]]))
    np.testing.assert_allclose(outcome.good, np.where(ends, whole, 0.0), rtol=1e-9, atol=1e-12)
    assert np.ptp(outcome.good[ends]) > 0.3
    np.testing.assert_array_equal(outcome.finished, ends)
    np.testing.assert_allclose(outcome.scrap_cost, np.where(ends, r.of_kind("scrap") * (1.0 - whole), 0.0), atol=1e-9)


def test_handing_over_a_sharp_wheel_is_cheap_and_a_dull_one_costs_up_to_four_dresses() -> None:
    simulation = BlockSimulation(load_task("power_limited"))
    # 60 s and two passes over 75 mm at 0.15 mm in 1910 rpm, 0.03 mm deep
    dress = 80.0 * 91.42 / 3600.0 + 1e-4 * 0.06 * math.pi * 300.0 * 65.0 + 0.10
    ends_sharp = np.repeat([1.0, 3.0], [59, 1])[:, None]
    sharp, _, _ = rollout(simulation, start(simulation, 8), 8000.0, ends_sharp)
    # at a slow table, where a wheel gets duller before it stalls
    dull, _, _ = rollout(simulation, start(simulation, 8), 3000.0, 0.0)
    assert (sharp.handover_cost[:-1] == 0.0).all() and (dull.handover_cost[:-1] == 0.0).all()
    assert (sharp.handover_cost[-1] < 0.35 * dress).all()
    assert (dull.handover_cost[-1] > 0.9 * dress).all()
    assert (dull.handover_cost[-1] <= 4.0 * dress * 1.001).all()
