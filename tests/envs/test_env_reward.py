import functools
import math

import gymnasium as gym
import numpy as np
import pytest

from grind_env.envs.simulation import Outcome, Simulation
from grind_env.envs.tasks import Task, load_task, task_names
from grind_env.machine.cycle import CycleResult
from grind_env.process.state import WheelState
from tests.envs.harness import IDS, Array, actions, rollout, start

DS = WheelState._fields.index("ds")
TERMS = ["time", "wheel", "dress", "scrap", "handover"]


@pytest.mark.parametrize("env_id", IDS)
def test_the_reward_is_the_sum_of_its_terms(env_id: str) -> None:
    env = gym.make(env_id)
    task: Task = env.unwrapped.task
    total, cost = 0.0, 0.0
    for episode in range(3):
        env.reset(seed=episode)
        for k, action in enumerate(actions(task.blocks, 1, seed=episode)[:, 0]):
            _, reward, terminated, _, info = env.step(action)
            terms = info["reward_terms"]
            assert list(terms) == TERMS
            assert reward == pytest.approx(sum(terms.values()), rel=1e-12)
            assert reward == pytest.approx(-info["block_cost"] / task.reference_cost, rel=1e-12)
            assert all(term <= 0.0 for term in terms.values())
            assert terminated == (k == task.blocks - 1)
            assert terminated or terms["handover"] == 0.0
            total, cost = total + reward, cost + info["block_cost"]

            # hourly rate 80 $, dresser 0.10 $ per execution (scenarios, section 4)
            assert terms["time"] == pytest.approx(-80.0 * info["seconds"] / 3600.0 / task.reference_cost)
            assert terms["dress"] == pytest.approx(-0.10 * info["D"] / task.reference_cost, abs=1e-15)
            scrap = env.unwrapped.blocks[-1].kind.scrap
            assert 0.0 <= info["cost"] <= 1.0
            assert info["cost"] == pytest.approx(1.0 - info["good_parts"], abs=1e-15)
            assert terms["scrap"] == pytest.approx(-scrap * info["cost"] / task.reference_cost)
    assert total == pytest.approx(-cost / task.reference_cost)


class Run:
    """Random episodes of a task; arrays of shape (blocks, N) or (blocks, 1)."""

    def __init__(self, name: str) -> None:
        simulation = Simulation(load_task(name))
        self.task = task = simulation.task
        rng, shape = np.random.default_rng(0), (task.blocks, 64)
        low, high = task.action.speed_range or (6.0, 21.0)
        self.speeds = 1000.0 * low * (high / low) ** rng.random(shape)
        self.executions = np.floor(rng.random(shape) * (task.action.executions + 1))
        episodes = start(simulation, 64)
        self.stock = episodes.tape[:, :, 1].T.copy()
        outcomes, results, diameters = [], [], [episodes.wheels[:, DS].copy()]
        for E, D in zip(self.speeds, self.executions, strict=True):
            outcome, result = simulation.step(episodes, E, D)
            outcomes.append(outcome)
            results.append(result)
            diameters.append(episodes.wheels[:, DS].copy())
        self.outcome = Outcome(*np.moveaxis(np.array(outcomes), 2, 0))
        self.result = CycleResult(*np.moveaxis(np.array(results), 2, 0))
        self.diameters = np.array(diameters)

    def of_kind(self, field: str) -> Array:
        """That number of every block's kind, shape (blocks, 1)."""
        kinds = [self.task.kinds[self.task.kind_of_block(k)] for k in range(self.task.blocks)]
        return np.array([[getattr(kind, field)] for kind in kinds])


run = functools.cache(Run)


@pytest.mark.parametrize("name", task_names())
def test_the_wheel_is_paid_for_the_volume_that_it_loses(name: str) -> None:
    r = run(name)
    dressed = 0.02 * 2 * r.executions  # radius, mm: two passes of 0.02 mm
    worn = (r.diameters[:-1] - r.diameters[1:]) / 2.0 - dressed
    assert (worn > 0.0).all()
    mean = (r.diameters[:-1] + r.diameters[1:]) / 2.0
    wheel_width = {"power_limited": 65.0, "oracle6": 25.0}[name]
    volume = math.pi * mean * (dressed * wheel_width + worn * r.of_kind("width"))
    np.testing.assert_allclose(r.outcome.wheel_cost, 1e-4 * volume, rtol=1e-3)


@pytest.mark.parametrize("name", task_names())
def test_a_block_takes_the_time_of_its_strokes_and_dresses(name: str) -> None:
    r = run(name)
    # scenarios, section 1: ceil(H/a) plunges, one coverage stroke, L spark-out strokes
    strokes = np.ceil(r.stock / r.of_kind("pick") - 1e-6) + 1 + r.of_kind("sparkout")
    assert (r.result.strokes == strokes).all()
    assert (r.result.dresses == r.executions).all()
    speed = r.speeds / 60.0
    stroke_seconds = (r.of_kind("length") + 60.0) / speed + speed / 1000.0 + 0.15
    # 1909.859 rev/min x 0.10 mm/rev, as an F word with three decimals, over the wheel and 10 mm more; two passes
    setup, width = {"power_limited": (60.0, 65.0), "oracle6": (8.0, 25.0)}[name]
    dress_seconds = setup + 2.0 * (width + 10.0) / (190.986 / 60.0)
    seconds = 20.0 + strokes * stroke_seconds + r.executions * dress_seconds
    np.testing.assert_allclose(r.outcome.seconds, seconds, rtol=1e-12)


@pytest.mark.parametrize("name", task_names())
def test_the_part_is_good_when_every_limit_holds(name: str) -> None:
    # the logistic steps of scenarios, section 2, written out
    r = run(name)
    outcome = r.outcome
    heat = r.result.plunge_rise if name == "power_limited" else r.result.finish_rise
    allowed = 450.0 + (150.0 if name == "power_limited" else 0.0)
    np.testing.assert_array_equal(outcome.rise, heat)

    def scrap(x: Array) -> Array:
        return 1.0 / (1.0 + np.exp(-np.clip(x, -500.0, 500.0)))

    good = (
        (1.0 - scrap((heat - allowed) / 12.0))
        * (1.0 - scrap((outcome.peak_power / 7500.0 - 1.0) / 0.02))
        * (1.0 - scrap((outcome.roughness / r.of_kind("roughness_limit") - 1.0) / 0.04))
        * (1.0 - scrap((np.abs(outcome.size_error) - r.of_kind("tolerance")) / 0.8))
    )
    np.testing.assert_allclose(outcome.good, good, rtol=1e-9, atol=1e-12)
    assert np.ptp(outcome.good) > 0.3
    assert (outcome.finished == 1.0).all()


def test_handing_over_a_sharp_wheel_is_cheap_and_a_dull_one_costs_up_to_four_dresses() -> None:
    simulation = Simulation(load_task("power_limited"))
    dress = 80.0 * 107.12 / 3600.0 + 1e-4 * 0.04 * math.pi * 300.0 * 65.0 + 0.10
    ends_sharp = np.repeat([1.0, 3.0], [59, 1])[:, None]
    sharp, _, _ = rollout(simulation, start(simulation, 8), 10000.0, ends_sharp)
    dull, _, _ = rollout(simulation, start(simulation, 8), 10000.0, 0.0)
    assert (sharp.handover_cost[:-1] == 0.0).all() and (dull.handover_cost[:-1] == 0.0).all()
    assert (sharp.handover_cost[-1] < 0.35 * dress).all()
    assert (dull.handover_cost[-1] > 0.9 * dress).all()
    assert (dull.handover_cost[-1] <= 4.0 * dress * 1.001).all()
