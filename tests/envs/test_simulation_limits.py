"""A simulation is used from several threads, and at its end."""

from concurrent.futures import ThreadPoolExecutor

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.envs.episodes import EpisodeOver

IDS = ["PowerLimited", "WidePlates", "Reciprocation"]


def rolled_out(simulation, seed: int, n: int = 32, steps: int = 8) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    episodes = simulation.start([np.random.default_rng([seed, i]) for i in range(n)], full_tape=False)
    found = []
    for _ in range(steps):
        outcomes, _ = simulation.step(episodes, rng.uniform(5000.0, 25000.0, n), rng.integers(0, 2, n).astype(float))
        found += [outcomes, simulation.observe(episodes)]
    return found


@pytest.mark.parametrize("name", IDS)
def test_threads_give_what_they_give_one_after_the_other(name):
    simulation = gym.make(f"grind/{name}-v0").unwrapped.simulation
    alone = [rolled_out(simulation, seed) for seed in range(4)]
    with ThreadPoolExecutor(4) as pool:
        for _ in range(5):
            beside = list(pool.map(lambda seed: rolled_out(simulation, seed), range(4)))
            for one, other in zip(alone, beside, strict=True):
                assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("name", [*IDS, "Job"])
def test_no_step_follows_the_last_block(name):
    program = {"program": str(grind_env.examples.path("plate_g82.nc"))} if name == "Job" else {}
    simulation = gym.make(f"grind/{name}-v0", **program).unwrapped.simulation
    episodes = simulation.start([np.random.default_rng(i) for i in range(2)])
    choice = np.full(2, 12000.0), np.zeros(2)
    first = np.array([0])
    while not simulation.over(episodes)[0]:
        simulation.step(episodes, *choice, active=first)
    for active in (None, first):
        before = episodes.pick([0, 1]).arrays()
        with pytest.raises(EpisodeOver, match="episode 0 is over after"):
            simulation.step(episodes, *choice, active=active)
        assert all(np.array_equal(before[key], array, equal_nan=True) for key, array in episodes.arrays().items())
    simulation.step(episodes, *choice, active=np.array([1]))
