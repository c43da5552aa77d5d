import itertools

import gymnasium as gym
import numpy as np
import pytest

from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.tasks import load_task
from tests.envs.harness import actions, assert_same, native, rollout, start
from tests.policies.optimum import exact_optimum

LEVELS = np.array([6000.0, 9000.0, 14000.0, 21000.0])
CHOICES = np.array(list(itertools.product(LEVELS, (0.0, 1.0)))).T  #: E and D of every choice, shape (2, 8)


@pytest.mark.bits
def test_two_seeds_give_identical_episodes() -> None:
    a, b = native("grind/Oracle6-v0", 2), native("grind/Oracle6-v0", 2)
    assert_same(a.reset(seed=1), b.reset(seed=1234))
    for action in actions(15, 2):
        assert_same(a.step(action), b.step(action))


@pytest.mark.nightly
def test_the_optimum_costs_the_same_in_the_environment_as_in_the_search() -> None:
    env = gym.make("grind/Oracle6-v0", info="full")
    best = exact_optimum(BlockSimulation(load_task("oracle6")))
    plan = env.unwrapped.codec.encode(best.speeds, best.executions)
    simulation = BlockSimulation(load_task("oracle6"))
    outcome, _, _ = rollout(simulation, start(simulation, 1), best.speeds[:, None], best.executions[:, None])
    env.reset(seed=0)
    infos = [env.step(action)[4] for action in plan]
    assert [(info["E"], info["D"]) for info in infos] == list(zip(best.speeds, best.executions, strict=True))
    assert sum(info["block_cost"] for info in infos) == pytest.approx(best.cost, rel=1e-9)
    # the optimum risks scrap and hands over a used wheel
    assert sum(info["good_parts"] for info in infos) == pytest.approx(float(outcome.good.sum()), rel=1e-9)
    assert infos[-1]["reward_handover"] < 0.0
    # only the order of magnitude: the reference scores fix the unit of the reward
    assert 1.0 / 3.0 < best.cost / 6.0 / env.unwrapped.task.reference_cost < 3.0


@pytest.mark.nightly
def test_always_choosing_the_cheapest_next_block_misses_the_optimum() -> None:
    simulation = BlockSimulation(load_task("oracle6"))
    episodes, total = start(simulation, 1), 0.0
    for _ in range(6):
        branches = episodes.pick(np.zeros(8, int))
        outcome = Outcome(*simulation.step(branches, CHOICES[0].copy(), CHOICES[1].copy())[0].T)
        chosen = int(np.argmin(outcome.cost - outcome.handover_cost))
        total += float(outcome.cost[chosen])
        episodes = branches.pick([chosen])
    assert total > 1.001 * exact_optimum(simulation).cost
