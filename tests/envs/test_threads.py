"""Vector environments whose episodes several threads grind; a simulation that several threads use, and at its end."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.envs.episodes import EpisodeOver
from grind_env.envs.tasks import TaskError
from grind_env.envs.transition import TOGETHER
from tests.envs.harness import MODES, assert_same, every_id, native, sampled
from tests.envs.test_vector_promises import grooved

N = 11


@pytest.mark.bits
@pytest.mark.parametrize("env_id", every_id())
def test_threads_change_no_bit(env_id: str) -> None:
    one, three = (native(env_id, N, MODES[every_id().index(env_id) % 2], threads=threads) for threads in (1, 3))
    assert_same(one.reset(seed=0), three.reset(seed=0))
    for number, batch in enumerate(sampled(env_id, 8, N)):
        if number == 4:  # from here on some episodes end, and with them some threads have nothing to do
            assert_same(*(each.reset(options={"reset_mask": np.arange(N) < 9}) for each in (one, three)))
        assert_same(one.step(batch), three.step(batch))
    for name in ("block", "wheels", "parts", "memory", "tape"):
        assert_same(getattr(one.episodes, name), getattr(three.episodes, name))


@pytest.mark.parametrize("n", [2, TOGETHER + 2])
def test_more_threads_than_episodes_and_more_episodes_than_are_stepped_in_one_go(n: int) -> None:
    one, many = (native("grind/Oracle6-v0", n, "NextStep", threads=threads) for threads in (1, 5))
    assert_same(one.reset(seed=3), many.reset(seed=3))
    for batch in sampled("grind/Oracle6-v0", 14, n):
        assert_same(one.step(batch), many.step(batch))


def test_a_program_that_python_runs_has_one_thread(tmp_path: Path) -> None:
    program = grooved(tmp_path)
    native("grind/Job-v0", 2, program=program, threads=1)
    with pytest.raises(TaskError, match="threads is 2, but Python runs this program"):
        native("grind/Job-v0", 2, program=program, threads=2)


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
