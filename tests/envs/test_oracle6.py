import itertools

import gymnasium as gym
import numpy as np
import pytest

from grind_env.envs.simulation import Outcome, Simulation
from grind_env.envs.tasks import load_task
from tests.envs.harness import Array, actions, assert_same, native, rollout, start

OPTIMUM = 17.4850
"""$, scenarios 4.2; with tolerance 0.1 %."""

LEVELS = np.array([6000.0, 9000.0, 14000.0, 21000.0])
BEST_E = np.array([21000.0, 6000.0, 14000.0, 21000.0, 6000.0, 6000.0])
BEST_D = np.array([1.0, 0.0, 0.0, 1.0, 0.0, 0.0])
GAUGE = np.array([False, True, False, False, True, True])


def costs(speeds: Array, executions: Array) -> Array:
    """$ of whole episodes, shape (N,), under plans of shape (6, N)."""
    simulation = Simulation(load_task("oracle6"))
    outcome, _, _ = rollout(simulation, start(simulation, speeds.shape[1]), speeds, executions)
    return outcome.cost.sum(axis=0)


@pytest.mark.bits
def test_two_seeds_give_identical_episodes() -> None:
    a, b = native("grind/Oracle6-v0", 2), native("grind/Oracle6-v0", 2)
    assert_same(a.reset(seed=1), b.reset(seed=1234))
    for action in actions(15, 2):
        assert_same(a.step(action), b.step(action))


def test_the_published_optimum_costs_what_was_published() -> None:
    env = gym.make("grind/Oracle6-v0")
    plan = env.unwrapped.codec.encode(BEST_E, BEST_D)
    env.reset(seed=0)
    infos = [env.step(action)[4] for action in plan]
    assert [(info["E"], info["D"]) for info in infos] == list(zip(BEST_E, BEST_D, strict=True))
    assert sum(info["block_cost"] for info in infos) == pytest.approx(OPTIMUM, rel=1e-3)
    handover = -infos[-1]["reward_terms"]["handover"] * env.unwrapped.task.reference_cost
    assert handover == pytest.approx(0.5343, abs=0.001)
    assert env.unwrapped.task.reference_cost == pytest.approx(OPTIMUM / 6)


def test_no_change_of_one_block_improves_on_the_optimum() -> None:
    plans = [
        (E, D, block)
        for block in range(6)
        for E, D in itertools.product(LEVELS, (0.0, 1.0))
        if (BEST_E[block], BEST_D[block]) != (E, D)
    ]
    speeds, executions = np.repeat(BEST_E[:, None], 42, axis=1), np.repeat(BEST_D[:, None], 42, axis=1)
    for i, (E, D, block) in enumerate(plans):
        speeds[block, i], executions[block, i] = E, D
    assert costs(speeds, executions).min() >= 17.52


def test_simple_plans_are_as_much_dearer_as_published() -> None:
    constants = np.array(list(itertools.product(LEVELS, (0.0, 1.0)))).T
    best = costs(np.repeat(constants[:1], 6, axis=0), np.repeat(constants[1:], 6, axis=0)).min()
    assert best / OPTIMUM == pytest.approx(1.34, abs=0.01)

    pairs = np.array(list(itertools.product(constants.T, constants.T)))  # (64, plate or gauge, E or D)
    plans = np.where(GAUGE[:, None, None], pairs[None, :, 1], pairs[None, :, 0])
    assert costs(plans[..., 0], plans[..., 1]).min() / OPTIMUM == pytest.approx(1.045, abs=0.002)

    draws = np.random.default_rng(0).integers(0, 8, (6, 4000))
    random = costs(constants[0][draws], constants[1][draws])
    error = random.std() / np.sqrt(4000) / OPTIMUM
    assert random.mean() / OPTIMUM == pytest.approx(1.59, abs=0.005 + 4.0 * error)


def test_the_cheapest_next_block_is_a_trap() -> None:
    simulation = Simulation(load_task("oracle6"))
    episodes, total = start(simulation, 1), 0.0
    choices = np.array(list(itertools.product(LEVELS, (0.0, 1.0)))).T
    for _ in range(6):
        branches = episodes.pick(np.zeros(8, int))
        outcome = Outcome(*simulation.step(branches, choices[0].copy(), choices[1].copy())[0].T)
        chosen = int(np.argmin(outcome.cost - outcome.handover_cost))
        total += float(outcome.cost[chosen])
        episodes = branches.pick([chosen])
    assert total / OPTIMUM == pytest.approx(1.028, abs=0.003)
